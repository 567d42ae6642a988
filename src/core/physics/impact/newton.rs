//! One to three simultaneous contacts without friction: Newton's rule at each (see [`super::Law`]),
//! `p = −(1 + e)(J M⁻¹ Jᵀ)⁻¹ u` with the speeds `u = J V`.

use nalgebra::{Matrix3, Vector3};

use super::error::ImpactError;
use super::rows::{Change, ROWS};

/// Contacts are independent where the determinant of `J M⁻¹ Jᵀ`, scaled to unit diagonal, is
/// greater than this. For three points in a line rounding leaves less than 1e-15.
const LEAST_DETERMINANT: f64 = 1e-10;

/// Impulses along the normals, with the intermediate results that their derivatives need.
pub(crate) struct Newton {
    restitution: f64,
    /// `(J M⁻¹ Jᵀ)⁻¹`, with ones on the diagonal for absent contacts.
    inverse: Matrix3<f64>,
    /// Impulses at restitution zero [N s].
    plastic: Vector3<f64>,
}

impl Newton {
    pub(crate) fn new(
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
    pub(crate) fn impulses(&self) -> Vector3<f64> {
        self.plastic * (1.0 + self.restitution)
    }

    /// Derivative of the impulses by the restitution.
    pub(crate) fn by_restitution(&self) -> Vector3<f64> {
        self.plastic
    }

    /// Changes of the impulses under changes of the speeds.
    pub(crate) fn by_speeds<const C: usize>(&self, speeds: &Change<C>) -> Change<C> {
        self.inverse * speeds * -(1.0 + self.restitution)
    }

    /// Changes of the impulses under changes of the speeds and of Delassus' operator, the latter
    /// times the impulses: `δp = −(1 + e) W⁻¹ δu − W⁻¹ δW p` with `W = J M⁻¹ Jᵀ`.
    pub(crate) fn change<const C: usize>(
        &self,
        speeds: &Change<C>,
        delassus_impulses: &Change<C>,
    ) -> Change<C> {
        self.by_speeds(speeds) - self.inverse * delassus_impulses
    }
}
