//! Which numbers of the law of an impact are unknown, and whether more is than those.

use std::sync::Arc;

use nalgebra::DVector;

use crate::motion::{Quantity, Scene};
use crate::physics::tree::TreeImpactDerivative;

/// Which of a problem's parameters an impact's law has in the place of the scene's numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FreeLaw {
    /// Its restitution,
    pub restitution: Option<usize>,
    /// its friction,
    pub friction: Option<usize>,
    /// its tangential restitution,
    pub tangential_restitution: Option<usize>,
    /// and its tilts.
    pub tilt: [Option<usize>; 2],
}

impl FreeLaw {
    /// Of an event of the scene; nothing where it is no collision.
    pub(super) fn of(scene: &Scene, event: usize) -> Self {
        let Some(collision) = scene.events[event].kind.collision() else {
            return Self::default();
        };
        let law = collision.law;
        let place = |quantity| scene.parameter_of(quantity);
        let tilt = |tangent| place(Quantity::Tilt { event, tangent });
        Self {
            restitution: place(Quantity::Restitution { law }),
            friction: place(Quantity::Friction { law }),
            tangential_restitution: place(Quantity::TangentialRestitution { law }),
            tilt: [tilt(0), tilt(1)],
        }
    }

    /// Derivatives of the rates after an impact, of parameters that are its law's.
    pub(super) fn rates_by<'d>(
        &self,
        derivative: &'d TreeImpactDerivative,
    ) -> impl Iterator<Item = (usize, DVector<f64>)> + use<'d> {
        let own = [
            (self.restitution, Some(derivative.by_restitution.clone())),
            (self.friction, Some(derivative.by_friction.clone())),
            (
                self.tangential_restitution,
                Some(derivative.by_tangential_restitution.clone()),
            ),
        ];
        let tilts = self.tilt.into_iter().enumerate().map(|(tangent, tilt)| {
            let by = derivative.by_tilt.as_ref();
            (tilt, by.map(|by| by.column(tangent).into_owned()))
        });
        let all = own.into_iter().chain(tilts);
        all.filter_map(|(parameter, by)| Some((parameter?, by?)))
    }
}

/// The scene, where it frees more than laws of impacts.
pub(super) fn freed(scene: &Scene) -> Option<Arc<Scene>> {
    let mut parameters = scene.parameters.iter();
    let is_more = parameters.any(|of| !is_of_law(of.quantity));
    is_more.then(|| Arc::new(scene.clone()))
}

/// Whether a quantity is of such a law.
pub(super) fn is_of_law(quantity: Quantity) -> bool {
    matches!(
        quantity,
        Quantity::Restitution { .. }
            | Quantity::Friction { .. }
            | Quantity::TangentialRestitution { .. }
            | Quantity::Tilt { .. }
    )
}
