//! What intervals are wider for what residuals leave open of the errors they have ([`vague`](crate::estimate::wander::vague)).

use nalgebra::DMatrix;

use super::linearised::{LinearisedSolution, free_directions, products};
use crate::estimate::terms::context::SolveContext;
use crate::estimate::unknowns::point::Point;
use crate::estimate::wander::likelihood::APART_S;
use crate::optimise::kkt::Kkt;
use crate::optimise::{Program, System};

/// By how much variances are more, as a form on answers of the unknowns.
pub(super) struct VagueErrors {
    /// Coordinates of an answer along the directions that constraints leave free.
    along: DMatrix<f64>,
    /// `A E A` with the information `A` of these, and what their variance `A⁻¹` is more.
    form: DMatrix<f64>,
}

impl VagueErrors {
    /// Of a motion that was found with errors of a hand; `None` of others, and where it may move in too many directions.
    pub(super) fn of(
        context: &SolveContext,
        point: &Point,
        system: &System,
        multipliers: &[f64],
    ) -> Option<Self> {
        let weave = context.problem.weave.as_ref()?;
        let kkt = Kkt::new(context, system, multipliers)?;
        let free = free_directions(context, system, &kkt)?;
        let linearised = LinearisedSolution::new(context, point, &free, free.ncols(), APART_S)?;
        let more = linearised.restricted().vague(&weave.errors.processes)?;
        let count = free.ncols();
        let products = products(context, system, &free);
        let information = products.view((0, 0), (count, count));
        let mut along = free.transpose();
        for (mut column, scale) in along.column_iter_mut().zip(context.damping().iter()) {
            column *= *scale;
        }
        Some(Self {
            along,
            form: information * more * information,
        })
    }

    /// By how much the covariances of quantities with such answers are more, a column each.
    pub(super) fn more(&self, answers: &DMatrix<f64>) -> DMatrix<f64> {
        let along = &self.along * answers;
        along.tr_mul(&(&self.form * &along))
    }
}
