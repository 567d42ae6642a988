//! What may be suspected.

use crate::motion::{Quantity, Scene};

/// Which quantities are looked into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::estimate::adequacy) enum Which {
    /// Those by which flights are differentiated in closed form.
    Cheap,
    /// All.
    All,
}

/// Quantities that are suspected together: the components of one thing. Gravity's size is one more
/// thing than its vector.
pub(super) fn groups(scene: &Scene, which: Which) -> Vec<Vec<Quantity>> {
    let mut groups = Quantity::by_thing(candidates(scene, which).into_iter());
    let size = Quantity::Gravity {
        axis: scene.gravity_m_s2.iamax(),
    };
    if groups
        .iter()
        .any(|group| group.len() > 1 && group.contains(&size))
    {
        groups.push(vec![size]);
    }
    groups
}

/// Quantities that may be suspected, one by one.
pub(in crate::estimate::adequacy) fn candidates(scene: &Scene, which: Which) -> Vec<Quantity> {
    let all = scene.mechanisms.keys();
    let is_alone = all.filter(|of| !scene.is_apart(*of)).count() == 1;
    let is_candidate = |quantity: &Quantity| {
        let means_something = match quantity {
            Quantity::LinearDrag { .. }
            | Quantity::QuadraticDrag { .. }
            | Quantity::Moment { .. }
            | Quantity::Mass { .. }
                if which == Which::Cheap =>
            {
                false
            }
            // It is tried beside the height of what is hit.
            Quantity::ContactDuration { .. } => false,
            // Of one body, a force is gravity.
            Quantity::Force { .. } => !is_alone,
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
    if !matches!(quantity, Quantity::Friction { .. } | Quantity::Tilt { .. }) {
        return true;
    }
    let wider = scene.with_free(&[(quantity, scene.value_of(quantity))]);
    (0..wider.events.len()).all(|event| wider.contact_set(event).is_ok())
}
