//! How certain a motion is: deviations of its events' times, of its duration, and of all that is a function of its
//! unknowns.
//!
//! At the optimum the unknowns respond to errors `n` of samples and priors by `−P Jᵀ n` with `P = Z (Zᵀ JᵀJ Z)⁻¹ Zᵀ`, so that
//! `m·u` has the variance `yᵀ Σ y`, `y = J P m` (the sandwich, as of bodies by themselves:
//! [`covariance`](crate::estimate::covariance)), with the errors' covariance `Σ` as the [residuals](super::errors) show it.

use nalgebra::{Cholesky, DVector, Dyn};

use super::errors::{Errors, Left};
use super::linear::{Held, Linear};
use crate::estimate::tree::point::TreePoint;
use crate::estimate::tree::problem::TreeProblem;
use crate::optimise::Solution;
use crate::optimise::active::ActiveSet;

/// Weight of a squared step that holds what nothing tells, per information: next to nothing.
const CALM: f64 = 1e-8;

/// Greatest share of what is known of a sum of unknowns that is from it, or nothing tells that.
const CALM_MOST: f64 = 0.1;

/// Deviations at an optimum.
pub(in crate::estimate::tree) struct Certainty {
    errors: Errors,
    left: Vec<Left>,
    held: Held,
    factor: Cholesky<f64, Dyn>,
}

impl Certainty {
    /// At a solution; `None` where something there is no number.
    pub(in crate::estimate::tree) fn new(
        problem: &TreeProblem,
        solution: &Solution<TreePoint>,
    ) -> Option<Self> {
        let active = ActiveSet::of(
            &solution.system,
            &solution.multipliers,
            problem.information.1,
        );
        let linear = Linear::new(problem, &solution.point, &active)?;
        let errors = Errors::new(&linear);
        let held = linear.held();
        let left = errors.left(&held.free, (&[], &linear.residuals), problem.information.0);
        let mut square = held.free.tr_mul(&held.free);
        for at in 0..square.nrows() {
            square[(at, at)] += CALM * problem.information.0;
        }
        let factor = square.cholesky()?;
        (!left.is_empty()).then_some(Self {
            errors,
            left,
            held,
            factor,
        })
    }

    /// Standard deviation of a sum of unknowns, each with a factor; `None` where neither samples nor priors tell it.
    pub(in crate::estimate::tree) fn sd(&self, moment: &[(usize, f64)]) -> Option<f64> {
        let mut of = DVector::zeros(self.held.basis.nrows());
        for (unknown, factor) in moment {
            of[*unknown] += factor;
        }
        let free = self.held.basis.tr_mul(&of);
        let answer = self.factor.solve(&free);
        let response = &self.held.free * &answer;
        let (own, seen) = (free.dot(&answer), response.norm_squared());
        // Written so that what is no number is not told.
        if !(own - seen <= CALM_MOST * own) {
            return None;
        }
        Some(self.errors.variance(&self.left, &response).max(0.0).sqrt())
    }
}
