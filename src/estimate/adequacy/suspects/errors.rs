//! The samples' errors, and what they say of an objective that becomes less.

use crate::estimate::adequacy::hand::Hand;
use crate::estimate::context::SolveContext;
use crate::estimate::covariance::bins::Bins;

/// The samples' errors that scores are compared with.
pub(in crate::estimate::adequacy) struct Errors<'a> {
    /// Variances of white noise, of positions and orientations, in squared units.
    pub(in crate::estimate::adequacy) white: [f64; 2],
    /// The hand's wander over the bins, where the flights show one.
    pub(in crate::estimate::adequacy) hands: Option<&'a [Hand; 2]>,
    /// Whether the misfit is beyond the white noise and the wander, if there is one.
    pub(in crate::estimate::adequacy) is_exceeded: bool,
    /// The bins.
    pub(in crate::estimate::adequacy) bins: &'a Bins,
}

impl Errors<'_> {
    /// Number of independent data: under a wander the samples of a bin are one.
    pub(super) fn data(&self, context: &SolveContext) -> f64 {
        let count = match self.hands {
            Some(_) => self.bins.count(),
            None => context.problem.sample_count(),
        };
        6.0 * count as f64
    }

    /// Decrease of Schwarz's criterion where an objective becomes so many times less by as many
    /// quantities.
    pub(super) fn gain(&self, context: &SolveContext, ratio: f64, quantities: usize) -> f64 {
        let data = self.data(context);
        data * ratio.ln() - quantities as f64 * data.ln()
    }

    /// What white noise leaves of the objective.
    pub(super) fn floor(&self, context: &SolveContext) -> f64 {
        1.5 * context.problem.sample_count() as f64 * (self.white[0] + self.white[1])
    }
}
