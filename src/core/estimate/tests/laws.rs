//! Scenes of balls that the air lifts.

use nalgebra::Vector3;

use super::{modelled, parameter, scene};
use crate::motion::{Quantity, Scene, Timing};
use crate::physics::Body;

/// All of a scene free of balls that the air lifts, whose lift is free.
pub(super) fn lifted(timing: Timing) -> Scene {
    let mut scene = modelled(scene(timing));
    for link in scene.links.keys().collect::<Vec<_>>() {
        let body = scene.links[link].body;
        let round = Vector3::repeat(body.moments_kg_m2().x);
        let ball = Body::new(body.mass_kg(), round).unwrap();
        let ball = ball.with_force(body.force_m_s2()).unwrap();
        let ball = ball.with_drag(body.drag()).unwrap();
        scene.links[link].body = ball.with_lift(0.08).unwrap();
        let free = (f64::NEG_INFINITY, f64::INFINITY);
        let lift = parameter("lift", Quantity::Lift { link }, 0.11, free);
        scene.parameters.push(lift);
    }
    let is_of_ball = |quantity| !matches!(quantity, Quantity::Moment { axis: 1 | 2, .. });
    scene.parameters.retain(|free| is_of_ball(free.quantity));
    scene
}
