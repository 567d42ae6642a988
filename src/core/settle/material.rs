//! What things are made of in a simulation.

use rapier3d::prelude::{CoefficientCombineRule, ColliderBuilder};

use crate::motion::{LinkIndex, Scene};

/// Coefficient of friction of contacts of bodies without one: wood on wood or on glazed clay.
pub const FRICTION: f64 = 0.4;

/// Coefficient of restitution of contacts of bodies without one: low, so that a body stays where it landed. How it
/// would bounce further was not performed.
pub const RESTITUTION: f64 = 0.1;

/// Standard deviations of both of a body of which nothing is known: from ice to rubber.
pub const FRICTION_SD: f64 = 0.2;
/// See [`FRICTION_SD`].
pub const RESTITUTION_SD: f64 = 0.15;

/// The collider of a link, of what the scene says the link is made of: the restitution and friction of the body, if it
/// has them.
pub(super) fn made_of(
    collider: ColliderBuilder,
    scene: &Scene,
    link: LinkIndex,
) -> ColliderBuilder {
    let name = &scene.links[link].name;
    let law = scene.contact_laws.iter().find(|law| law.name == *name);
    let restitution = law.map_or(RESTITUTION, |law| law.restitution);
    // A body with a restitution alone has no friction at its impacts; at rest nothing is as slippery.
    let friction = law
        .map(|law| law.friction)
        .filter(|friction| *friction > 0.0);
    surfaced(collider, restitution, friction.unwrap_or(FRICTION))
}

/// The collider of what stands still: what touches it decides.
pub(super) fn standing(collider: ColliderBuilder) -> ColliderBuilder {
    surfaced(collider, 0.0, 0.0)
}

/// Of two that touch, the greater coefficient counts.
fn surfaced(collider: ColliderBuilder, restitution: f64, friction: f64) -> ColliderBuilder {
    collider
        .friction(friction)
        .friction_combine_rule(CoefficientCombineRule::Max)
        .restitution(restitution)
        .restitution_combine_rule(CoefficientCombineRule::Max)
}
