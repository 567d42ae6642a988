//! Flights of four and five samples: one that rises where it should fall is not called physical, and
//! one that falls is.

use enact::config::scene_from_toml;
use enact::math::Pose;
use enact::motion::{
    About, Doubt, LinkIndex, Mark, PoseSample, Scene, Stamp, TakeEvent, TrackIndex, Verdict,
};
use enact::physics::{State, flow};
use enact::pipeline::{Outcome, Pipeline};
use enact_tools::perform::{Acting, bounces, perform};
use nalgebra::{UnitQuaternion, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const RATE_HZ: f64 = 30.0;
const GRAVITY_M_S2: Vector3<f64> = Vector3::new(0.0, 0.0, -9.80665);
const NOISE_RAD: f64 = 0.005;

/// A box in free flight, of samples that are said to be so good \[m\].
fn scene(weight_m: f64) -> Scene {
    let text = format!(
        "name = \"toss\"\n[timing]\nstamps = \"physical\"\n\
         [weights]\nposition_mm = {:?}\norientation_deg = {:?}\n\
         [[body]]\nname = \"thing\"\nshape = {{ kind = \"cuboid\", size_mm = [120, 70, 30] }}\n\
         mass_g = 200\n[[event]]\nname = \"end\"\nkind = \"end\"\n",
        1e3 * weight_m,
        NOISE_RAD.to_degrees()
    );
    scene_from_toml(&text).unwrap()
}

/// So many samples of a flight with an acceleration and white noise \[m\].
fn flight(samples: usize, pull_m_s2: Vector3<f64>, noise_m: f64, seed: u64) -> Vec<TakeEvent> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal =
        |sd: f64| Vector3::from_fn(|_, _| -> f64 { StandardNormal.sample(&mut random) }) * sd;
    let start = State {
        position_m: Vector3::zeros(),
        orientation: UnitQuaternion::from_scaled_axis(normal(1.0)),
        velocity_m_s: normal(1.0),
        angular_velocity_rad_s: normal(4.0) + Vector3::new(6.0, 8.0, 6.0),
    };
    let body = scene(noise_m).links[LinkIndex(0)].body;
    let stamp = |index: usize| Stamp((1e9 * index as f64 / RATE_HZ).round() as i64);
    let mut events: Vec<TakeEvent> = (0..samples)
        .map(|index| {
            let there = flow::advance(&body, &pull_m_s2, &start, index as f64 / RATE_HZ);
            let turn = there.orientation * UnitQuaternion::from_scaled_axis(normal(NOISE_RAD));
            let place_m = there.position_m + normal(noise_m);
            TakeEvent::Pose {
                track: TrackIndex(0),
                stream: 0,
                sample: PoseSample::from_pose(
                    stamp(index),
                    &Pose::from_parts(place_m.into(), turn),
                ),
            }
        })
        .collect();
    events.push(TakeEvent::Mark(Mark {
        stamp: stamp(samples - 1),
        event: None,
    }));
    events
}

fn finished(scene: &Scene, events: Vec<TakeEvent>) -> Outcome {
    let outcome = Pipeline::of(scene.clone(), events).finish(&mut ());
    outcome.expect("an estimate")
}

fn is_doubted_for_its_fall(outcome: &Outcome) -> bool {
    let mut doubts = outcome.estimate.doubts.iter();
    doubts.any(|doubt| doubt.about == About::Fall)
}

/// With noise as the scene says, and with samples that are far better than it says, as a filter leaves
/// them: there the residuals with gravity are as large as said, and only their shape tells.
#[test]
fn a_flight_that_rises_is_not_physical() {
    for (samples, weight_m, noise_m) in [(4, 0.002, 0.002), (5, 0.002, 0.002), (5, 0.012, 0.0005)] {
        for seed in 8000..8010 {
            let rising = flight(samples, -0.92 * GRAVITY_M_S2, noise_m, seed);
            let outcome = finished(&scene(weight_m), rising);
            let estimate = &outcome.estimate;
            let what = format!(
                "{samples}, {weight_m} m, seed {seed}: {:?}",
                estimate.doubts
            );
            assert_ne!(estimate.verdict, Verdict::Physical, "{what}");
            assert!(is_doubted_for_its_fall(&outcome), "{what}");
        }
    }
}

/// Of so few samples another spin is sometimes as near, which is said; nothing else is.
#[test]
fn flights_that_fall_are_physical() {
    for (samples, weight_m) in [(4, 0.002), (5, 0.012)] {
        let (mut physical, mut doubted) = (0, Vec::new());
        for seed in 8000..8100 {
            let falling = flight(samples, GRAVITY_M_S2, weight_m, seed);
            let estimate = finished(&scene(weight_m), falling).estimate;
            physical += usize::from(estimate.verdict == Verdict::Physical);
            let is_spin = |doubt: &Doubt| doubt.about == About::Rivals;
            if !estimate.doubts.iter().all(is_spin) {
                doubted.push((seed, estimate.doubts));
            }
        }
        let what = format!("{samples}, {weight_m} m: {physical} physical, {doubted:?}");
        assert!(physical >= 80 && doubted.len() <= 1, "{what}");
    }
}

/// Some five samples before a bounce, and ten after it, with noise as the scene says.
#[test]
fn brief_flights_before_a_bounce_are_physical() {
    let acting = Acting {
        distortion: 0.0,
        noise_position_m: 0.002,
        noise_orientation_rad: NOISE_RAD,
        rate_hz: 60.0,
        mark_error_s: 0.0,
        ..Acting::timing_known()
    };
    let (mut asked, mut doubted) = (0, Vec::new());
    for seed in 8000..8100 {
        let Ok(mut truth) = bounces(1, seed) else {
            continue;
        };
        truth.scene.weights.position_m = acting.noise_position_m;
        truth.scene.weights.orientation_rad = acting.noise_orientation_rad;
        let performance = perform(&truth, &acting, seed);
        let hit = acting.start.0 + (1e9 * truth.event_times_s[0]) as i64;
        let step = 1e9 / acting.rate_hz;
        let (from, to) = (hit - (6.5 * step) as i64, hit + (11.5 * step) as i64);
        let mut events = performance.events;
        events.retain_mut(|event| match event {
            TakeEvent::Pose { sample, .. } => (from..=to).contains(&sample.stamp.0),
            TakeEvent::Mark(mark) => {
                mark.stamp = mark.stamp.min(Stamp(to));
                true
            }
        });
        let outcome = finished(&truth.scene, events);
        let brief = outcome.estimate.residuals.iter();
        if brief
            .filter(|flight| [4, 5].contains(&flight.samples))
            .count()
            == 0
        {
            continue;
        }
        asked += 1;
        if is_doubted_for_its_fall(&outcome) {
            doubted.push(seed);
        }
    }
    assert!(asked >= 50, "{asked}");
    assert!(doubted.len() * 100 <= asked, "{doubted:?} of {asked}");
}
