//! How a simulation is done: its steps, its contacts, and what things are made of.

use rapier3d::dynamics::{FrictionModel, IntegrationParameters, SpringCoefficients};
use rapier3d::prelude::{CoefficientCombineRule, ColliderBuilder};

use crate::motion::{LinkIndex, Scene};

/// Coefficient of friction of contacts of bodies without one: wood on wood or on glazed clay.
pub const FRICTION: f64 = 0.4;

/// Coefficient of restitution of contacts of bodies without one: low, so that a body stays where it landed. How it
/// would bounce further was not performed.
pub const RESTITUTION: f64 = 0.1;

/// How a motion is simulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Manner {
    /// Steps of the simulation between two poses.
    pub steps: usize,
    /// Angular damping \[1/s\]: without it rapier's cylinders and balls would roll for ever.
    pub rolling_per_s: f64,
    /// Natural frequency of the springs that contacts with what stands still are \[Hz\].
    pub contact_hz: f64,
    /// Their damping ratio.
    pub contact_damping: f64,
    /// Whether each point of a contact has its own friction (Coulomb); otherwise a contact has one friction and one
    /// torsion, which is faster.
    pub has_point_friction: bool,
    /// Whether bodies rest when all have been slow for a while, besides when rapier lets them sleep, which at short
    /// steps it does not.
    pub rests_when_slow: bool,
}

impl Manner {
    /// To see how bodies come to lie: rapier's own settings.
    pub const SETTLING: Self = Self {
        steps: 1,
        rolling_per_s: 1.0,
        contact_hz: 60.0,
        contact_damping: 10.0,
        has_point_friction: false,
        rests_when_slow: false,
    };

    /// To see where: short steps, hard contacts, nothing that slows but friction.
    pub const PREDICTING: Self = Self {
        steps: 8,
        rolling_per_s: 0.0,
        contact_hz: 60.0,
        contact_damping: 10.0,
        has_point_friction: true,
        rests_when_slow: true,
    };

    pub(super) fn is_prediction(&self) -> bool {
        *self != Self::SETTLING
    }

    pub(super) fn set(&self, parameters: &mut IntegrationParameters) {
        if !self.is_prediction() {
            return;
        }
        let springs = SpringCoefficients::new(self.contact_hz, self.contact_damping);
        parameters.contact_softness = springs;
        parameters.static_contact_softness = springs;
        if self.has_point_friction {
            parameters.friction_model = FrictionModel::Coulomb;
        }
    }
}

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
