//! The samples' errors, and what they say of an objective that becomes less.

use crate::estimate::adequacy::hand::Hand;
use crate::estimate::context::SolveContext;
use crate::estimate::covariance::bins::Bins;

/// The samples' errors that scores are compared with.
pub(in crate::estimate::adequacy) struct Errors<'a> {
    /// Variances of white noise, of positions and orientations, in squared units.
    pub(in crate::estimate::adequacy) white: [f64; 2],
    /// The hand's wander over the bins that the flights may have,
    pub(in crate::estimate::adequacy) hands: &'a [Hand; 2],
    /// whether they show it,
    pub(in crate::estimate::adequacy) is_hand: bool,
    /// whether the misfit is unlikely under it,
    pub(in crate::estimate::adequacy) is_unlikely: bool,
    /// and whether it is beyond it.
    pub(in crate::estimate::adequacy) is_beyond: bool,
    /// The bins.
    pub(in crate::estimate::adequacy) bins: &'a Bins,
}

impl Errors<'_> {
    /// Decrease of Schwarz's criterion where an objective becomes so many times less by as many
    /// quantities.
    pub(super) fn gain(&self, context: &SolveContext, ratio: f64, quantities: usize) -> f64 {
        if self.is_hand {
            self.gain_under_wander(ratio, quantities)
        } else {
            schwarz(context.problem.sample_count(), ratio, quantities)
        }
    }

    /// The same under a wander, shown or not: the samples of a bin are then one.
    pub(super) fn gain_under_wander(&self, ratio: f64, quantities: usize) -> f64 {
        schwarz(self.bins.count(), ratio, quantities)
    }

    /// What white noise leaves of the objective.
    pub(super) fn floor(&self, context: &SolveContext) -> f64 {
        1.5 * context.problem.sample_count() as f64 * (self.white[0] + self.white[1])
    }
}

fn schwarz(poses: usize, ratio: f64, quantities: usize) -> f64 {
    let data = 6.0 * poses as f64;
    data * ratio.ln() - quantities as f64 * data.ln()
}
