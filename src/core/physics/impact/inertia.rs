//! The inertia that an impact meets: `M⁻¹` of one side, from impulses to changes of velocity.
//!
//! Nothing else in this room knows masses and moments: a side of another kind answers here.

use nalgebra::{SMatrix, Vector3};

use super::law::Side;

/// `M⁻¹` of one side of an impact; zero for the static world.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct InverseInertia {
    /// Inverse of the mass [1/kg].
    pub(super) mass_per_kg: f64,
    /// Inverses of the principal moments [1/(kg m²)].
    pub(super) moments_per_kg_m2: Vector3<f64>,
}

impl InverseInertia {
    /// That of a rigid body.
    pub(super) fn of(side: &Side) -> Self {
        Self {
            mass_per_kg: 1.0 / side.body.mass_kg(),
            moments_per_kg_m2: side.body.moments_kg_m2().map(|moment| 1.0 / moment),
        }
    }

    /// Change of velocity [m/s, world] of the impulses in the columns [N s, world].
    pub(super) fn velocity_changes<const C: usize>(
        &self,
        impulses: &SMatrix<f64, 3, C>,
    ) -> SMatrix<f64, 3, C> {
        impulses * self.mass_per_kg
    }

    /// Change of angular velocity [rad/s, body] of an impulse's moment about the centre of mass
    /// [N m s, body].
    pub(super) fn spin_change(&self, moment: &Vector3<f64>) -> Vector3<f64> {
        self.moments_per_kg_m2.component_mul(moment)
    }

    /// The same of the moments in the columns.
    pub(super) fn spin_changes<const C: usize>(
        &self,
        mut moments: SMatrix<f64, 3, C>,
    ) -> SMatrix<f64, 3, C> {
        for mut column in moments.column_iter_mut() {
            column.component_mul_assign(&self.moments_per_kg_m2);
        }
        moments
    }
}
