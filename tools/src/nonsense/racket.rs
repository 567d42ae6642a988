//! A racket that is swung in a hand: no free flight, though a scene may say so.
//!
//! The arm turns about a shoulder with the least jerk (Flash and Hogan, "The coordination of arm
//! movements", Journal of Neuroscience 5(7), 1985), the wrist turns the racket about its handle, and
//! at the lowest point of the swing its tip brushes the floor.

use std::f64::consts::TAU;

use enact::math::Pose;
use enact::motion::{Mark, PoseSample, Stamp, TakeEvent, TrackIndex};
use nalgebra::{UnitQuaternion, Vector3};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};

use super::Asked;
use crate::perform::acting::START;
use crate::stress::hit::rng;

/// A scene that takes the racket for a body that falls and bounces. Stamps are physical times.
pub const SCENE_TOML: &str = r#"
name = "a racket that falls"
[timing]
stamps = "physical"
[[body]]
name = "racket"
shape = { kind = "cuboid", size_mm = [25, 260, 680] }
mass_g = 300
features_mm = { tip = [0, 0, -340] }
[[surface]]
name = "floor"
point_mm = [0, 0, 0]
normal = [0, 0, 1]
[[event]]
name = "release"
kind = "start"
[[event]]
name = "brush"
kind = "collision"
body = "racket"
feature = "tip"
surface = "floor"
restitution = 0.5
[[event]]
name = "catch"
kind = "end"
"#;

/// From the racket's middle to its tip \[m\].
const TIP_M: f64 = 0.34;
/// How long the swing takes \[s\].
const SWING_S: f64 = 1.5;
const RATE_HZ: f64 = 120.0;
/// Of the tracker, per axis [m], \[rad\].
const NOISE_M: f64 = 5e-4;
const NOISE_RAD: f64 = 5e-3;

/// A swing: arm, angle and the turn of the wrist are of the seed.
pub fn swung(seed: u64) -> Asked {
    let mut rng = rng(seed);
    let arm_m = rng.random_range(0.4..0.6);
    let half_swing_rad = rng.random_range(1.0..1.4);
    let turn_rad = rng.random_range(-1.5..1.5);
    let heading = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), rng.random_range(0.0..TAU));
    let pose = |time_s: f64| {
        let share = least_jerk(time_s / SWING_S);
        let swing = heading
            * UnitQuaternion::from_axis_angle(
                &Vector3::y_axis(),
                half_swing_rad * (2.0 * share - 1.0),
            );
        let wrist = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn_rad * share);
        let shoulder_m = Vector3::new(0.0, 0.0, arm_m + TIP_M);
        Pose::from_parts(
            (shoulder_m - swing * (Vector3::z() * arm_m)).into(),
            swing * wrist,
        )
    };
    let at = |time_s: f64| Stamp(START.0 + (time_s * 1e9).round() as i64);
    let mut vector = |sd: f64| {
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        Vector3::new(normal(), normal(), normal()) * sd
    };
    let samples = (SWING_S * RATE_HZ) as u32;
    let mut events: Vec<TakeEvent> = (0..=samples)
        .map(|index| {
            let time_s = f64::from(index) / RATE_HZ;
            let mut seen = pose(time_s);
            seen.translation.vector += vector(NOISE_M);
            seen.rotation *= UnitQuaternion::from_scaled_axis(vector(NOISE_RAD));
            TakeEvent::Pose {
                track: TrackIndex(0),
                stream: 0,
                sample: PoseSample::from_pose(at(time_s), &seen),
            }
        })
        .collect();
    let marks = [0.0, 0.5 * SWING_S, SWING_S].map(|time_s| Mark {
        stamp: at(time_s),
        event: None,
    });
    events.extend(marks.map(TakeEvent::Mark));
    Asked {
        scene: enact::config::scene_from_toml(SCENE_TOML).expect("a valid scene"),
        events,
    }
}

/// Share of a way after a share of its time, at rest before and after: `10 x³ − 15 x⁴ + 6 x⁵`.
fn least_jerk(x: f64) -> f64 {
    x * x * x * (10.0 - x * (15.0 - 6.0 * x))
}
