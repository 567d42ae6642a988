//! Scenes of balls that the air lifts, and of what sticks and springs back.

use nalgebra::Vector3;

use super::{LAW, meeting, modelled, parameter, scene};
use crate::motion::{Quantity, Scene, Timing};
use crate::physics::Body;

/// Two that stick, and spring back along the surface by as much as is free.
pub(super) fn springing(timing: Timing) -> Scene {
    let mut scene = meeting(timing, 9.0);
    scene.contact_laws[LAW].tangential_restitution = 0.3;
    let quantity = Quantity::TangentialRestitution { law: LAW };
    let free = parameter("tangential", quantity, 0.4, (0.0, 1.0));
    scene.parameters.push(free);
    scene
}

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
