//! One to three contacts at once, without friction: Newton's rule at each (see [`super::Law`]).

use nalgebra::{Matrix3, Vector3};

use super::error::ImpactError;
use super::rows::{Change, ROWS};

/// Least determinant of the contacts' mobilities, scaled to unit diagonal, that counts as
/// independent: what rounding leaves of three points in a line is below 1e-15.
const LEAST_DETERMINANT: f64 = 1e-10;

/// Impulses along the normals, with what their derivatives need.
pub(super) struct Newton {
    restitution: f64,
    /// `(J M⁻¹ Jᵀ)⁻¹`, zero for contacts that are not there.
    inverse: Matrix3<f64>,
    /// Impulses at restitution zero [N s].
    plastic: Vector3<f64>,
}

impl Newton {
    pub(super) fn new(
        restitution: f64,
        count: usize,
        speeds: &Vector3<f64>,
        delassus: &Matrix3<f64>,
    ) -> Result<Self, ImpactError> {
        let mut delassus = *delassus;
        for absent in count..ROWS {
            delassus[(absent, absent)] = 1.0;
        }
        let scale = delassus.diagonal().map(|m| 1.0 / m.sqrt());
        let scaled = delassus.component_mul(&(scale * scale.transpose()));
        let inverse = delassus
            .try_inverse()
            .filter(|_| scaled.determinant() > LEAST_DETERMINANT)
            .ok_or(ImpactError::Dependent { count })?;
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

    /// Derivative of the impulses by the restitution.
    pub(super) fn by_restitution(&self) -> Vector3<f64> {
        self.plastic
    }

    /// Changes of the impulses by those of the speeds.
    pub(super) fn by_speeds<const C: usize>(&self, speeds: &Change<C>) -> Change<C> {
        self.inverse * speeds * -(1.0 + self.restitution)
    }

    /// Changes of the impulses by those of the speeds and of Delassus' operator times the impulses.
    pub(super) fn change<const C: usize>(
        &self,
        speeds: &Change<C>,
        mobility_impulses: &Change<C>,
    ) -> Change<C> {
        self.by_speeds(speeds) - self.inverse * mobility_impulses
    }
}
