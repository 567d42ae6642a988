//! A die that should bounce six times with a given face up each time: more than physics can do.
//!
//! What the performer has in mind are flights, each by itself as physics has it, from goal to
//! goal; that no impact joins them is what the estimator has to live with.

use enact::math::{Pose, so3};
use enact::motion::{GoalTarget, LinkIndex, Scene};
use nalgebra::Vector3;

use super::truth::{Truth, TruthError};

/// Its scene file.
pub const SCENE_TOML: &str = include_str!("../../../config/die.toml");

/// Durations of the flights \[s\], and whole turns beyond the least. The goals are near the poses
/// of a physical motion with restitutions between 0.5 and 0.9, turned by 6° and rounded.
const FLIGHTS: [(f64, f64); 7] = [
    (0.231, 0.0),
    (0.179, -1.0),
    (0.164, -1.0),
    (0.155, 0.0),
    (0.153, 0.0),
    (0.141, 0.0),
    (0.12, 0.0),
];
/// From the place of the first bounce to that of the beginning \[m\].
const BEFORE_M: Vector3<f64> = Vector3::new(-0.102, -0.006, 0.276);
/// Turn in the first flight [rad, body].
const TURN_BEFORE_RAD: Vector3<f64> = Vector3::new(-2.38, -0.98, 0.54);
/// From the place of the last bounce to that of the end \[m\].
const AFTER_M: Vector3<f64> = Vector3::new(0.06, 0.005, 0.012);
/// Turn in the last flight [rad, body].
const TURN_AFTER_RAD: Vector3<f64> = Vector3::new(-1.0, 0.7, -1.1);

/// What the performer has in mind.
///
/// # Panics
/// If the scene file in this repository is broken.
pub fn reference() -> Truth {
    let scene = enact::config::scene_from_toml(SCENE_TOML).expect("a valid scene file");
    reference_in(&scene).expect("a scene with six bounces, each with a pose goal")
}

/// The same in a scene of one cube with a pose goal at each of six events.
pub fn reference_in(scene: &Scene) -> Result<Truth, TruthError> {
    let goals: Vec<Pose> = scene
        .goals
        .iter()
        .filter_map(|goal| match goal.target {
            GoalTarget::Pose { world_from_body } => Some(world_from_body),
            GoalTarget::PositionWithin { .. } | GoalTarget::Condition(_) => None,
        })
        .collect();
    let (Some(first), Some(last), true) = (
        goals.first(),
        goals.last(),
        goals.len() + 1 == FLIGHTS.len(),
    ) else {
        return Err(TruthError::Lacks {
            what: "a pose goal at each of six bounces",
        });
    };
    let moved = |pose: &Pose, shift_m: Vector3<f64>, turn| {
        Pose::from_parts(
            (pose.translation.vector + shift_m).into(),
            pose.rotation * turn,
        )
    };
    let mut poses = vec![moved(first, BEFORE_M, so3::exp(&-TURN_BEFORE_RAD))];
    poses.extend(&goals);
    poses.push(moved(last, AFTER_M, so3::exp(&TURN_AFTER_RAD)));
    let mut truth = Truth {
        scene: scene.clone(),
        is_physical: false,
        parameters: scene.parameters.iter().map(|p| p.initial).collect(),
        arcs: Vec::new(),
        event_times_s: Vec::new(),
        duration_s: 0.0,
    };
    truth.fly_through(LinkIndex(0), &poses, &FLIGHTS);
    truth.event_times_s = truth.arcs[1..].iter().map(|arc| arc.start_s).collect();
    Ok(truth)
}
