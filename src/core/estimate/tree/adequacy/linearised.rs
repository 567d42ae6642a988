//! A solution, linearised, with what its samples show of their errors: what is judged of a motion, and how certain it is,
//! are told by the same.

use nalgebra::{DMatrix, DVector};

use super::errors::TreeErrors;
use super::linear::{HeldDirections, Linear};
use super::odds;
use crate::estimate::adequacy::is_beyond_noise;
use crate::estimate::tree::point::TreePoint;
use crate::estimate::tree::problem::TreeProblem;
use crate::estimate::tree::program::REGULARISER;
use crate::estimate::wander::Process;
use crate::estimate::wander::likelihood::{FittedErrors, Restricted};
use crate::estimate::wander::series::SeriesRows;
use crate::estimate::wander::wrong::without_wander;
use crate::optimise::Solution;
use crate::optimise::active::ActiveSet;

/// How many residuals beyond what the motion may follow tell whether they are greater than noise.
const TELLING: f64 = 20.0;

/// A solution and what is told of it.
pub(in crate::estimate::tree) struct Linearised<'s> {
    pub(super) problem: &'s TreeProblem,
    pub(super) point: &'s TreePoint,
    pub(super) active: ActiveSet,
    pub(super) linear: Linear,
    /// What errors may be where each sample errs by itself.
    pub(super) errors: Option<TreeErrors>,
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
            errors: problem.errors.is_none().then(|| TreeErrors::new(&linear)),
            held: linear.held(),
            active,
            linear,
        })
    }

    /// The likeliest errors of samples that err in time, from where they are thought to be, and what follows of them.
    pub(in crate::estimate::tree) fn fitted(&self, from: &[Process; 2]) -> Option<FittedErrors> {
        let columns = self.columns(&[]);
        let (rows, priors) = self.rows(&columns);
        self.restricted(&rows, &priors).fitted(from)
    }

    /// Whether residuals are greater than the noise of the likeliest errors makes them, by more than chance.
    pub(in crate::estimate::tree) fn shows_hand(&self) -> bool {
        let columns = self.columns(&[]);
        let (rows, priors) = self.rows(&columns);
        let restricted = self.restricted(&rows, &priors);
        let fitted = restricted.fitted(&[Process::EXPECTED; 2]);
        let noise = fitted.and_then(|of| restricted.at(&without_wander(&of.processes)));
        let freedom = (3 * rows.samples()) as f64 - restricted.free as f64;
        noise.is_some_and(|noise| {
            freedom >= TELLING && is_beyond_noise(noise.left[(0, 0)], 1.0, freedom)
        })
    }

    /// Derivatives along what rows leave free, then further columns, then residuals.
    pub(super) fn columns(&self, further: &[DVector<f64>]) -> DMatrix<f64> {
        let free = &self.held.free;
        let count = free.ncols() + further.len();
        let mut columns = free.clone().resize_horizontally(count + 1, 0.0);
        for (at, column) in further.iter().enumerate() {
            columns.set_column(free.ncols() + at, column);
        }
        columns.set_column(count, &self.linear.residuals);
        columns
    }

    /// Rows of samples of such columns, and products of those of priors.
    pub(super) fn rows(&self, columns: &DMatrix<f64>) -> (SeriesRows, DMatrix<f64>) {
        let first = self.linear.sample_rows();
        let priors = columns.rows(first, columns.nrows() - first);
        (
            SeriesRows::new(&self.linear.series, columns),
            priors.tr_mul(&priors),
        )
    }

    /// What the motion may follow of such rows.
    pub(super) fn restricted<'r>(
        &self,
        rows: &'r SeriesRows,
        priors: &'r DMatrix<f64>,
    ) -> Restricted<'r> {
        Restricted {
            rows,
            priors,
            free: self.held.free.ncols(),
            least: REGULARISER * self.problem.information.0,
        }
    }

    /// Logarithm of the likelihood of the samples, over all models of their errors; `None` where there is none.
    pub(in crate::estimate::tree) fn evidence(&self) -> Option<f64> {
        let Some(errors) = &self.errors else {
            let fitted = self.at(&self.problem.errors?)?;
            return Some(-0.5 * fitted.merit);
        };
        let left = errors.left(
            &self.held.free,
            &[][..],
            &self.linear.residuals,
            self.problem.information.0,
        );
        (!left.is_empty()).then(|| odds::evidence(&left))
    }

    /// What follows of such errors of samples that err in time.
    pub(super) fn at(&self, errors: &[Process; 2]) -> Option<FittedErrors> {
        let columns = self.columns(&[]);
        let (rows, priors) = self.rows(&columns);
        self.restricted(&rows, &priors).at(errors)
    }
}
