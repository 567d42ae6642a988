//! How certain a motion is: deviations of its events' times, of its duration, and of all that is a function of its
//! unknowns.
//!
//! At the optimum the unknowns respond to errors `n` of samples and priors by `−P Jᵀ n` with `P = Z (Zᵀ JᵀJ Z)⁻¹ Zᵀ`, so that
//! `m·u` has the variance `yᵀ Σ y`, `y = J P m` (the sandwich, as of bodies by themselves:
//! [`covariance`](crate::estimate::covariance)), with the errors' covariance `Σ` as the [residuals](super::errors) show it.

use nalgebra::{Cholesky, DVector, Dyn};

use super::errors::{Left, regularise};
use super::linearised::Linearised;
use crate::estimate::tree::program::REGULARISER;

/// Greatest share of what is known of a sum of unknowns that is from it, or nothing tells that.
const REGULARISER_MOST: f64 = 0.1;

/// Deviations at an optimum.
pub(in crate::estimate::tree) struct Certainty<'s> {
    of: Linearised<'s>,
    /// Under each model of errors, where each sample errs by itself.
    left: Vec<Left>,
    factor: Cholesky<f64, Dyn>,
}

impl<'s> Certainty<'s> {
    /// At a solution; `None` where something there is no number.
    pub(in crate::estimate::tree) fn new(of: Linearised<'s>) -> Option<Self> {
        let information = of.problem.information.0;
        let Some(errors) = &of.errors else {
            let fitted = of.at(&of.problem.errors?)?;
            return Some(Self {
                of,
                left: Vec::new(),
                factor: fitted.information,
            });
        };
        let left = errors.left(&of.held.free, &[][..], &of.linear.residuals, information);
        let mut square = of.held.free.tr_mul(&of.held.free);
        regularise(&mut square, information);
        let factor = square.cholesky()?;
        (!left.is_empty()).then_some(Self { of, left, factor })
    }

    /// Standard deviation of a sum of unknowns, each with a factor; `None` where neither samples nor priors tell it.
    pub(in crate::estimate::tree) fn sd(&self, moment: &[(usize, f64)]) -> Option<f64> {
        let mut sum = DVector::zeros(self.of.held.basis.nrows());
        for (unknown, factor) in moment {
            sum[*unknown] += factor;
        }
        let free = self.of.held.basis.tr_mul(&sum);
        let answer = self.factor.solve(&free);
        let Some(errors) = &self.of.errors else {
            // The weights are those of the errors.
            let variance = free.dot(&answer);
            let held = REGULARISER * self.of.problem.information.0 * answer.norm_squared();
            return (held <= REGULARISER_MOST * variance).then(|| variance.max(0.0).sqrt());
        };
        let response = &self.of.held.free * &answer;
        let (own, seen) = (free.dot(&answer), response.norm_squared());
        // Written so that what is no number is not told.
        if !(own - seen <= REGULARISER_MOST * own) {
            return None;
        }
        Some(errors.variance(&self.left, &response).max(0.0).sqrt())
    }
}
