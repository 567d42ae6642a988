//! The law of impact at a collision, with the estimated parameters.

use nalgebra::Vector3;

use crate::math::so3;
use crate::motion::{Estimate, Partner, Quantity, Scene};
use crate::physics::contact::Feature;
use crate::physics::impact::{self, Contact};
use crate::physics::{Body, State};

/// A collision whose outcome follows from the state before it: one point of a body, one plane,
/// no friction.
pub(super) struct Law {
    pub(super) body: usize,
    pub(super) restitution: f64,
    /// Of the impulse \[world\]: the surface's, tilted.
    pub(super) normal: Vector3<f64>,
    centre_m: Vector3<f64>,
    radius_m: f64,
    plane_point_m: Vector3<f64>,
    plane_normal: Vector3<f64>,
}

impl Law {
    /// The law at an event; `None` where its outcome does not follow here.
    pub(super) fn new(scene: &Scene, estimate: &Estimate, event: usize) -> Option<Self> {
        let collision = scene.events[event].kind.collision()?;
        let value = |quantity: Quantity| {
            let free = scene.parameters.iter().find(|p| p.quantity == quantity)?;
            let found = estimate.parameters.iter().find(|p| p.name == free.name)?;
            Some(found.value)
        };
        let friction = value(Quantity::Friction { event }).unwrap_or(collision.friction);
        let ([contact], Partner::World, true) =
            (&collision.contacts[..], collision.partner, friction == 0.0)
        else {
            return None;
        };
        let feature = scene.bodies[collision.body].features[contact.feature?].geometry;
        let Feature::Point { point_m, radius_m } = feature else {
            return None;
        };
        let (plane_point_m, plane_normal) = scene.surfaces[contact.other?].plane()?;
        let tilt = tangents(&plane_normal)
            .iter()
            .enumerate()
            .filter_map(|(tangent, axis)| Some(axis * value(Quantity::Tilt { event, tangent })?))
            .sum();
        Some(Self {
            body: collision.body,
            restitution: value(Quantity::Restitution { event }).unwrap_or(collision.restitution),
            normal: so3::exp(&tilt) * plane_normal,
            centre_m: point_m,
            radius_m,
            plane_point_m,
            plane_normal,
        })
    }

    /// Where the body touches the plane in that state.
    pub(super) fn contact(&self, state: &State) -> Contact {
        let down = state
            .orientation
            .inverse_transform_vector(&-self.plane_normal);
        Contact {
            point_m: self.centre_m + down * self.radius_m,
            surface_point_m: self.plane_point_m,
            surface_normal: self.plane_normal,
        }
    }

    /// The state after it.
    pub(super) fn after(&self, body: &Body, before: &State) -> State {
        let contact = self.contact(before);
        impact::bounce(body, &contact, &self.normal, self.restitution, before)
    }
}

/// The axes about which a normal tilts: across it and the world axis that is least along it,
/// then across both.
fn tangents(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let first = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
    [first, normal.cross(&first)]
}
