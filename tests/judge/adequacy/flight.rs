//! A flight by itself, with one thing in its scene that is not so: integrated by Runge and Kutta's formula, seen with a
//! tracker's noise and by nobody's hand.

use enact::config::scene_from_toml;
use enact::motion::{Fits, PoseSample, Stamp, TakeEvent, TrackIndex};
use enact::pipeline::{Outcome, Pipeline};
use nalgebra::{UnitQuaternion, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const SCENE_TOML: &str = r#"
name = "one flight"
hand = "none"
[timing]
stamps = "physical"
[[body]]
name = "box"
shape = { kind = "cuboid", size_mm = [160, 100, 40] }
mass_g = 370
[[event]]
name = "go"
kind = "start"
[[event]]
name = "end"
kind = "end"
"#;
/// Uniform moments of the box [kg m²].
const MOMENTS_KG_M2: [f64; 3] = [3.577e-4, 8.387e-4, 1.0977e-3];
const RATE_HZ: f64 = 240.0;
const SAMPLES: usize = 144;
/// Steps of the integration per sample.
const STEPS: usize = 8;

/// What really flew.
#[derive(Clone, Copy)]
struct Flown {
    moments_kg_m2: [f64; 3],
    /// Growth of the moments after a second: contents that move outwards.
    growth: f64,
    drag_per_m: f64,
    tracker_m: [f64; 3],
    /// Stamps of a second.
    clock: f64,
}

const RIGHT: Flown = Flown {
    moments_kg_m2: MOMENTS_KG_M2,
    growth: 0.0,
    drag_per_m: 0.0,
    tracker_m: [0.0; 3],
    clock: 1.0,
};

/// Velocity and angular velocity, with their derivatives by time at those of the flight.
fn change(flown: &Flown, at_s: f64, v: Vector3<f64>, w: Vector3<f64>) -> [Vector3<f64>; 2] {
    let fall = Vector3::new(0.0, 0.0, -9.80665) - v * (flown.drag_per_m * v.norm());
    let growth = 1.0 + flown.growth * at_s;
    let moments = Vector3::from(flown.moments_kg_m2) * growth;
    let momentum = moments.component_mul(&w);
    let turning = momentum.cross(&w) - w.component_mul(&moments) * (flown.growth / growth);
    [fall, turning.component_div(&moments)]
}

fn poses(flown: &Flown, seed: u64) -> Vec<TakeEvent> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut noise =
        |sd: f64| Vector3::from_fn(|_, _| -> f64 { StandardNormal.sample(&mut random) }) * sd;
    let mut place = Vector3::new(0.0, 0.0, 1.0);
    let mut turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.4, -0.6, 0.2));
    let mut v = Vector3::new(2.4, 0.3, 2.9);
    let mut w = Vector3::new(3.0, 8.0, 2.0) + noise(0.5);
    let step_s = 1.0 / (RATE_HZ * STEPS as f64);
    let mut events = Vec::new();
    for sample in 0..SAMPLES {
        let seen = place + turn * Vector3::from(flown.tracker_m) + noise(0.0005);
        let seen_turn = turn * UnitQuaternion::from_scaled_axis(noise(0.005));
        let q = seen_turn.quaternion();
        events.push(TakeEvent::Pose {
            track: TrackIndex(0),
            stream: 0,
            sample: PoseSample::new(
                Stamp((1e9 * flown.clock * sample as f64 / RATE_HZ) as i64),
                seen,
                [q.i, q.j, q.k, q.w],
            ),
        });
        for step in 0..STEPS {
            let at_s = sample as f64 / RATE_HZ + step as f64 * step_s;
            let half = 0.5 * step_s;
            let [a1, b1] = change(flown, at_s, v, w);
            let [a2, b2] = change(flown, at_s + half, v + a1 * half, w + b1 * half);
            let [a3, b3] = change(flown, at_s + half, v + a2 * half, w + b2 * half);
            let [a4, b4] = change(flown, at_s + step_s, v + a3 * step_s, w + b3 * step_s);
            let of =
                |a: Vector3<f64>, b, c, d: Vector3<f64>| (a + (b + c) * 2.0 + d) * (step_s / 6.0);
            let (by_v, by_w) = (of(a1, a2, a3, a4), of(b1, b2, b3, b4));
            place += (v + by_v * 0.5) * step_s;
            turn *= UnitQuaternion::from_scaled_axis((w + by_w * 0.5) * step_s);
            (v, w) = (v + by_v, w + by_w);
        }
    }
    events
}

fn answered(flown: &Flown, scene_toml: &str, seed: u64) -> Outcome {
    let scene = scene_from_toml(scene_toml).expect("a scene");
    let pipeline = Pipeline::of(scene, poses(flown, seed));
    pipeline.finish(&mut ()).expect("an estimate")
}

#[test]
fn a_right_flight_fits() {
    for seed in 0..6 {
        let outcome = answered(&RIGHT, SCENE_TOML, seed);
        assert_eq!(outcome.estimate.fits(), Fits::Yes, "{seed}");
        assert!(outcome.estimate.suspects.is_empty(), "{seed}");
    }
}

#[test]
fn what_is_wrong_with_a_flight_is_suspected() {
    let wrongs = [
        (
            "box.drag",
            Flown {
                drag_per_m: 0.15,
                ..RIGHT
            },
        ),
        (
            "box.tracker",
            Flown {
                tracker_m: [0.03, -0.01, 0.02],
                ..RIGHT
            },
        ),
        (
            "box.clock",
            Flown {
                clock: 1.05,
                ..RIGHT
            },
        ),
    ];
    for (name, flown) in wrongs {
        is_suspected(name, &flown, SCENE_TOML);
    }
    let other = "mass_g = 370\nmoments_kg_m2 = [3.6e-4, 8.4e-4, 7.5e-4]";
    is_suspected(
        "box.moment",
        &RIGHT,
        &SCENE_TOML.replace("mass_g = 370", other),
    );
}

fn is_suspected(name: &str, flown: &Flown, scene_toml: &str) {
    for seed in 0..3 {
        let outcome = answered(flown, scene_toml, seed);
        let estimate = &outcome.estimate;
        assert_ne!(estimate.fits(), Fits::Yes, "{name} {seed}");
        let suspects = estimate.suspects.iter().flat_map(|suspect| &suspect.values);
        let mut names = suspects.map(|(quantity, _)| outcome.given.name_of_quantity(*quantity));
        let is_it = names.any(|of| of.starts_with(name));
        assert!(is_it, "{name} {seed}: {:?}", estimate.suspects);
    }
}

/// A bottle whose contents move: no quantity of a scene says that.
#[test]
fn a_flight_that_no_rigid_body_makes_does_not_fit() {
    for seed in 0..3 {
        let outcome = answered(
            &Flown {
                growth: 1.5,
                ..RIGHT
            },
            SCENE_TOML,
            seed,
        );
        assert_eq!(outcome.estimate.fits(), Fits::No, "{seed}");
    }
}

/// A tracker's slow errors are within the weights of what is measured; what is beyond them is none.
#[test]
fn where_nobody_acted_a_flight_is_measured_by_its_weights() {
    let off = |tracker_m: f64| Flown {
        tracker_m: [tracker_m, 0.0, 0.0],
        ..RIGHT
    };
    for (tracker_m, fits) in [(0.0, Fits::Yes), (0.0005, Fits::Yes), (0.03, Fits::No)] {
        let outcome = answered(&off(tracker_m), SCENE_TOML, 1);
        assert_eq!(outcome.estimate.fits(), fits, "{tracker_m}");
    }
}

#[test]
fn of_few_samples_it_is_said_that_they_are_few() {
    let scene = scene_from_toml(SCENE_TOML).expect("a scene");
    let few = poses(&RIGHT, 3).into_iter().step_by(40);
    let outcome = Pipeline::of(scene, few)
        .finish(&mut ())
        .expect("an estimate");
    let untold = outcome.estimate.fit.expect_err("four poses tell nothing");
    assert!(untold.sentence().contains("too few"), "{untold:?}");
}
