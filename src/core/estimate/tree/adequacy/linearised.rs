//! A solution, linearised, with what its samples show of their errors: what is judged of a motion, and how certain it is,
//! are told by the same.

use super::errors::TreeErrors;
use super::linear::{HeldDirections, Linear};
use super::odds;
use crate::estimate::tree::point::TreePoint;
use crate::estimate::tree::problem::TreeProblem;
use crate::optimise::Solution;
use crate::optimise::active::ActiveSet;

/// A solution and what is told of it.
pub(in crate::estimate::tree) struct Linearised<'s> {
    pub(super) problem: &'s TreeProblem,
    pub(super) point: &'s TreePoint,
    pub(super) active: ActiveSet,
    pub(super) linear: Linear,
    pub(super) errors: TreeErrors,
    pub(super) held: HeldDirections,
}

impl<'s> Linearised<'s> {
    /// `None` where something there is no number.
    pub(in crate::estimate::tree) fn new(
        problem: &'s TreeProblem,
        solution: &'s Solution<TreePoint>,
    ) -> Option<Self> {
        let point = &solution.point;
        let active = ActiveSet::of(
            &solution.system,
            &solution.multipliers,
            problem.information.1,
        );
        let linear = Linear::new(problem, point, &active)?;
        Some(Self {
            problem,
            point,
            errors: TreeErrors::new(&linear),
            held: linear.held(),
            active,
            linear,
        })
    }

    /// Logarithm of the likelihood of the samples, over all models of their errors; `None` where there is none.
    pub(in crate::estimate::tree) fn evidence(&self) -> Option<f64> {
        let information = self.problem.information.0;
        let left = self.errors.left(
            &self.held.free,
            &[][..],
            &self.linear.residuals,
            information,
        );
        (!left.is_empty()).then(|| odds::evidence(&left))
    }
}
