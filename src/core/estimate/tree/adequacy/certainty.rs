//! How certain a motion is: deviations of its events' times, of its duration, and of all that is a function of its
//! unknowns.
//!
//! Along a basis `Z` of what rows leave free the information is `A = (J Z)ᵀ V⁻¹ J Z`, with the errors' covariance `V`, so that
//! `m·u` has the variance `(Zᵀ m)ᵀ A⁻¹ Zᵀ m`. A motion that was found with each sample by itself is less certain: what moves it
//! is `y = J Z ((J Z)ᵀ J Z)⁻¹ Zᵀ m` of all errors, and the variance is `yᵀ V y`.

use nalgebra::DVector;

use super::linearised::Linearised;
use crate::estimate::tree::program::REGULARISER;

/// Greatest share of what is known of a sum of unknowns that is from the regulariser, or nothing tells that.
const REGULARISER_MOST: f64 = 0.1;

/// Deviations at an optimum.
pub(in crate::estimate::tree) struct Certainty<'s> {
    of: Linearised<'s>,
}

impl<'s> Certainty<'s> {
    /// At a solution; `None` where something there is no number.
    pub(in crate::estimate::tree) fn new(of: Linearised<'s>) -> Option<Self> {
        of.told().is_some().then_some(Self { of })
    }

    /// Standard deviation of a sum of unknowns, each with a factor; `None` where neither samples nor priors tell it.
    pub(in crate::estimate::tree) fn sd(&self, moment: &[(usize, f64)]) -> Option<f64> {
        let mut sum = DVector::zeros(self.of.held.basis.nrows());
        for (unknown, factor) in moment {
            sum[*unknown] += factor;
        }
        let free = self.of.held.basis.tr_mul(&sum);
        let answer = self.of.told()?.information.solve(&free);
        let variance = free.dot(&answer);
        let held = REGULARISER * self.of.problem.information.0 * answer.norm_squared();
        // Written so that what is no number is not told.
        let is_told = held <= REGULARISER_MOST * variance;
        let variance = match &self.of.problem.errors {
            Some(_) => variance,
            None => self.of.spread(&free)?,
        };
        is_told.then(|| variance.max(0.0).sqrt())
    }
}
