//! A brick thrown spinning about its middle axis, which flips over and over, bounces once on a
//! corner and flies on: for studies of bodies with three different moments.

use enact::motion::{
    Collision, ContactLaw, Event, EventKind, Feature, LinkIndex, Scene, TrackIndex,
};
use enact::physics::{Body, Shape, State, contact};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::bounces::bounces;
use super::truth::{Flight, Truth, TruthError, simulate};

/// Half the brick's sides \[m\].
const HALF_M: Vector3<f64> = Vector3::new(0.10, 0.06, 0.03);
/// Mass [kg].
const MASS_KG: f64 = 1.0;
/// The first flight and the second \[s\].
const FLIGHTS_S: [f64; 2] = [0.7, 0.3];
/// Height of the hand that throws \[m\].
const THROWN_M: f64 = 0.5;
/// Share of the spin that is not about the middle axis, at the throw.
const TILT: f64 = 0.2;
/// Restitution at the bounce.
const RESTITUTION: f64 = 0.6;
/// The bounce's corner approaches at least this fast [m/s].
const SLOWEST_APPROACH_M_S: f64 = 0.5;
/// Heights are looked at in this spacing \[s\].
const SCAN_S: f64 = 1e-3;
/// Throws tried.
const TRIES: usize = 2000;

/// A motion whose first flight has `count` flips, one bounce, and no goals.
pub fn flips(count: usize, seed: u64) -> Result<Truth, TruthError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let scene = bounces(1, 0)?.scene;
    (0..TRIES)
        .find_map(|_| thrown(&scene, count, &mut rng))
        .ok_or(TruthError::NotFound {
            count: 1,
            tries: TRIES,
        })
}

/// A throw that meets the table with one corner first, fast enough, and then flies on.
fn thrown(like: &Scene, count: usize, rng: &mut impl Rng) -> Option<Truth> {
    let body = brick();
    let gravity_m_s2 = &like.gravity_m_s2;
    let flight = Flight {
        body: &body,
        gravity_m_s2,
    };
    let mut normal = || -> f64 { StandardNormal.sample(&mut *rng) };
    let quaternion = Quaternion::new(normal(), normal(), normal(), normal());
    let tilt = Vector3::new(normal(), 0.0, normal());
    let way = Vector3::new(0.2 + 0.05 * normal(), 0.05 * normal(), 0.0);
    let spin = (Vector3::y() + tilt * (TILT / tilt.norm())).normalize();
    // A spin k times as fast flips k times as often.
    let flip_s = flip_s(&flight, &spin)?;
    let share = count as f64 + rng.random_range(-0.2..0.2);
    let [first_s, second_s] = FLIGHTS_S;
    let mut state = State {
        position_m: Vector3::new(0.0, 0.0, THROWN_M),
        orientation: UnitQuaternion::new_normalize(quaternion),
        velocity_m_s: way,
        angular_velocity_rad_s: spin * (share * flip_s / first_s),
    };
    let (reach_m, corner) = lowest(&flight.advance(&state, first_s));
    let below_m = -flight.advance(&state, first_s).position_m.z - reach_m;
    state.velocity_m_s.z += below_m / first_s;
    let scene = scene(like, corner);
    let truth = simulate(&scene, &[], &[state], first_s + second_s).ok()?;
    let [arc, after] = &truth.arcs[..] else {
        return None;
    };
    let height_m = |state: &State| state.position_m.z + lowest(state).0;
    let is_clear = |of: &State, lasts_s: f64| {
        let steps = (lasts_s / SCAN_S) as usize;
        (1..steps).all(|step| height_m(&flight.advance(of, step as f64 * SCAN_S)) > 0.0)
    };
    let before = flight.advance(&arc.state, first_s - SCAN_S);
    let is_good = (arc.end_s - first_s).abs() < 1e-6
        && height_m(&before) > SLOWEST_APPROACH_M_S * SCAN_S
        && is_clear(&arc.state, first_s)
        && is_clear(&after.state, second_s);
    is_good.then_some(truth)
}

/// Time from one flip to the next at that spin \[s\]: of `ω` along the middle axis changing sign.
fn flip_s(flight: &Flight, spin: &Vector3<f64>) -> Option<f64> {
    const LONGEST_S: f64 = 100.0;
    const STEP_S: f64 = 0.01;
    let state = State {
        position_m: Vector3::zeros(),
        orientation: UnitQuaternion::identity(),
        velocity_m_s: Vector3::zeros(),
        angular_velocity_rad_s: *spin,
    };
    let mut flips = Vec::new();
    let mut last = 1.0;
    for step in 1..(LONGEST_S / STEP_S) as usize {
        let time_s = step as f64 * STEP_S;
        let now = flight.advance(&state, time_s).angular_velocity_rad_s.y;
        if now * last < 0.0 {
            flips.push(time_s);
        }
        last = now;
        if flips.len() == 2 {
            return Some(flips[1] - flips[0]);
        }
    }
    None
}

fn brick() -> Body {
    let square = HALF_M.component_mul(&HALF_M);
    let moments_kg_m2 = Vector3::new(
        square.y + square.z,
        square.x + square.z,
        square.x + square.y,
    ) * (MASS_KG / 3.0);
    Body::new(MASS_KG, moments_kg_m2).expect("a brick is a body")
}

fn corners_m() -> impl Iterator<Item = Vector3<f64>> {
    (0..8).map(|corner: usize| {
        let sign = Vector3::from_fn(|axis, _| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 });
        HALF_M.component_mul(&sign)
    })
}

/// Height of the lowest corner against the centre of mass \[m\], and which it is.
fn lowest(state: &State) -> (f64, usize) {
    let heights = corners_m()
        .map(|corner_m| (state.orientation * corner_m).z)
        .zip(0..);
    heights
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .expect("a brick has corners")
}

fn scene(like: &Scene, corner: usize) -> Scene {
    let mut scene = like.clone();
    scene.name = "brick, flipping".to_owned();
    scene.tracks[TrackIndex(0)].topic = "/tracker/brick/pose".to_owned();
    let brick_of = &mut scene.links[LinkIndex(0)];
    brick_of.name = "brick".to_owned();

    brick_of.body = brick();
    brick_of.shape = Shape::Cuboid {
        half_extents_m: HALF_M,
    };
    let features = corners_m().enumerate().map(|(index, point_m)| Feature {
        name: format!("corner_{index}"),
        geometry: contact::Feature::corner(point_m),
    });
    brick_of.features = features.collect();
    let law = scene.add_law(ContactLaw::frictionless("bounce", RESTITUTION));
    scene.events = vec![
        Event::new(
            "bounce",
            EventKind::Collision(Collision::bounce(LinkIndex(0), corner, 0, law)),
        ),
        Event::new("end", EventKind::End),
    ];
    scene
}
