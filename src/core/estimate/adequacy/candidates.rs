//! What may be suspected.

use crate::estimate::covariance::in_time::Strayed;
use crate::motion::{Quantity, Scene};

/// Quantities that may be suspected, one by one.
pub(super) fn candidates(scene: &Scene, strayed: Strayed) -> Vec<Quantity> {
    let all = scene.mechanisms.keys();
    let is_alone = all.filter(|of| !scene.is_apart(*of)).count() == 1;
    let is_candidate = |quantity: &Quantity| {
        let means_something = match quantity {
            // A hand rounds an impact, as if it lasted.
            Quantity::ContactDuration { .. } => strayed != Strayed::Hand,
            // Of one body, a force is gravity.
            Quantity::Force { .. } => !is_alone,
            // Of a ball of which nobody says that the air lifts it, a curve is a force.
            Quantity::Lift { link } => scene.links[*link].body.lift() != 0.0,
            // Nor does what nobody says to grip and spring back.
            Quantity::TangentialRestitution { law } => {
                scene.contact_laws[*law].tangential_restitution > 0.0
            }
            _ => true,
        };
        means_something
            && !scene.frees(*quantity)
            && scene.untold(*quantity).is_none()
            && is_supported(scene, *quantity)
    };
    scene
        .quantities()
        .into_iter()
        .filter(is_candidate)
        .collect()
}

/// Whether the contacts of all collisions are supported with that quantity free.
fn is_supported(scene: &Scene, quantity: Quantity) -> bool {
    if !matches!(
        quantity,
        Quantity::Friction { .. } | Quantity::TangentialRestitution { .. } | Quantity::Tilt { .. }
    ) {
        return true;
    }
    let wider = scene.with_free(&[(quantity, scene.value_of(quantity))]);
    (0..wider.events.len()).all(|event| wider.contact_set(event).is_ok())
}
