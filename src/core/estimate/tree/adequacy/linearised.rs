//! A solution, linearised, with what its samples show of their errors: what is judged of a motion, and how certain it is,
//! are told by the same.

use std::cell::OnceCell;

use nalgebra::{DMatrix, DVector};

use super::linear::{HeldDirections, Linear};
use crate::estimate::tree::point::TreePoint;
use crate::estimate::tree::problem::TreeProblem;
use crate::estimate::tree::program::REGULARISER;
use crate::estimate::wander::likelihood::{FittedErrors, LikelyErrors, NoiseAlone, Restricted};
use crate::estimate::wander::series::SeriesRows;
use crate::estimate::wander::spread::spread;
use crate::optimise::Solution;
use crate::optimise::active::ActiveSet;

/// A solution and what is told of it.
pub(in crate::estimate::tree) struct Linearised<'s> {
    pub(super) problem: &'s TreeProblem,
    pub(super) point: &'s TreePoint,
    pub(super) active: ActiveSet,
    pub(super) linear: Linear,
    pub(super) held: HeldDirections,
    told: OnceCell<Option<FittedErrors>>,
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
            held: linear.held(),
            active,
            linear,
            told: OnceCell::new(),
        })
    }

    /// The likeliest errors of samples that err in time, from where they are thought to be, and what follows of them.
    pub(in crate::estimate::tree) fn fitted(&self, from: &LikelyErrors) -> Option<FittedErrors> {
        let columns = self.columns(&[]);
        let (rows, priors) = self.rows(&columns);
        self.restricted(&rows, &priors).fitted(from)
    }

    /// Whether noise alone does not explain the residuals.
    pub(in crate::estimate::tree) fn shows_hand(&self) -> bool {
        self.alone().is_some_and(|alone| !alone.explains())
    }

    /// The likeliest noise where nothing strays.
    fn alone(&self) -> Option<NoiseAlone> {
        let columns = self.columns(&[]);
        let (rows, priors) = self.rows(&columns);
        NoiseAlone::of(&self.restricted(&rows, &priors), self.told()?)
    }

    /// Variance that errors give to a sum of what rows leave free, of a motion that was found with each sample by itself. They are
    /// noise where that explains them.
    pub(super) fn spread(&self, sum: &DVector<f64>) -> Option<f64> {
        let free = &self.held.free;
        let mut information = free.tr_mul(free);
        for at in 0..free.ncols() {
            information[(at, at)] += REGULARISER * self.problem.information.0;
        }
        let answer = free * information.cholesky()?.solve(sum);
        let alone = self.alone().filter(NoiseAlone::explains);
        let errors = match &alone {
            Some(alone) => &alone.fitted.errors,
            None => &self.told()?.errors,
        };
        let first = self.linear.sample_rows();
        let priors = answer.rows(first, answer.len() - first).norm_squared();
        let columns = DMatrix::from_columns(&[answer]);
        Some(spread(&self.linear.series, &columns, &errors.processes)[(0, 0)] + priors)
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

    /// Logarithm of the likelihood of the samples; `None` where there is none.
    pub(in crate::estimate::tree) fn evidence(&self) -> Option<f64> {
        self.told().map(|fitted| -0.5 * fitted.merit)
    }

    /// What follows of the errors with which the motion was found, or where each sample was weighed by itself, of the likeliest.
    pub(super) fn told(&self) -> Option<&FittedErrors> {
        let told = || match &self.problem.errors {
            Some(errors) => {
                let columns = self.columns(&[]);
                let (rows, priors) = self.rows(&columns);
                self.restricted(&rows, &priors).at(errors)
            }
            None => self.fitted(&LikelyErrors::EXPECTED),
        };
        self.told.get_or_init(told).as_ref()
    }
}
