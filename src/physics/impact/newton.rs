//! One to three contacts at once, without friction: Newton's rule at each (see [`super::Law`]).

use nalgebra::{Matrix3, Vector3};

use super::assembly::Encounter;
use super::error::ImpactError;
use super::meeting::Velocities;

/// Least determinant of the contacts' mobilities, scaled to unit diagonal, that counts as
/// independent: what rounding leaves of three points in a line is below 1e-15.
const LEAST_DETERMINANT: f64 = 1e-10;

/// Impulses along the normals, with what their derivatives need.
pub(super) struct Newton {
    restitution: f64,
    /// `(J M⁻¹ Jᵀ)⁻¹`, with ones for contacts that are not there.
    inverse: Matrix3<f64>,
    /// Impulses at restitution zero [N s].
    plastic: Vector3<f64>,
}

impl Newton {
    pub(super) fn new(
        restitution: f64,
        encounters: &[Encounter],
        before: &[Velocities; 2],
    ) -> Result<Self, ImpactError> {
        let mut mobility = Matrix3::identity();
        let mut speeds = Vector3::zeros();
        for (row, encounter) in encounters.iter().enumerate() {
            speeds[row] = encounter.normal.dot(&encounter.relative(before));
            for (column, other) in encounters.iter().enumerate() {
                let kicks = other.kicks(&other.normal);
                mobility[(row, column)] = encounter.normal.dot(&encounter.relative(&kicks));
            }
        }
        let scale = mobility.diagonal().map(|m| 1.0 / m.sqrt());
        let scaled = mobility.component_mul(&(scale * scale.transpose()));
        let inverse = mobility
            .try_inverse()
            .filter(|_| scaled.determinant() > LEAST_DETERMINANT)
            .ok_or(ImpactError::Dependent {
                count: encounters.len(),
            })?;
        Ok(Self {
            restitution,
            inverse,
            plastic: -(inverse * speeds),
        })
    }

    /// Impulses along the normals [N s].
    pub(super) fn impulses(&self) -> Vector3<f64> {
        self.plastic * (1.0 + self.restitution)
    }

    /// Impulses at restitution zero: the derivative by the restitution.
    pub(super) fn plastic(&self) -> &Vector3<f64> {
        &self.plastic
    }

    /// Changes of the impulses along the normals, given those of `J V` and of `J M⁻¹ Jᵀ` times
    /// the impulses.
    pub(super) fn change(
        &self,
        speeds: &Vector3<f64>,
        mobility_impulses: &Vector3<f64>,
    ) -> Vector3<f64> {
        -(self.inverse * (speeds * (1.0 + self.restitution) + mobility_impulses))
    }
}
