//! The samples' errors, and what they say of an objective that becomes less.

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::estimate::adequacy::hand::Wander;
use crate::estimate::covariance::bins::Bins;
use crate::estimate::terms::context::SolveContext;

/// Greatest probability of a suspect's score under a right value, of all together (Bonferroni).
pub(super) const LEVEL: f64 = 1e-3;
/// A wander that the flights may hide seldom leaves this share of the misfit to one wrong quantity,
const ALL: f64 = 0.95;
/// or less with a gain that is greater by so much per share: more where flights show a wander that is likely to leave
/// what is left.
const GAIN_PER_SHARE: f64 = 900.0;
const GAIN_PER_SHARE_OF_HAND: f64 = 4000.0;
/// Greatest probability of a gain under right values where times are unknown: a wander's means are not independent.
const LEVEL_OF_TIMES: f64 = 1e-5;
/// Unknowns of a flight's state.
const STATE: usize = 12;

/// The samples' errors that scores are compared with.
pub(in crate::estimate::adequacy) struct Errors<'a> {
    /// Variances of white noise, of positions and orientations, in squared units.
    pub(in crate::estimate::adequacy) white: [f64; 2],
    /// The hand's wander over the bins that the flights may have,
    pub(in crate::estimate::adequacy) hands: &'a [Wander; 2],
    /// whether they show it, and such a one is likely to leave what is left,
    pub(in crate::estimate::adequacy) is_likely: bool,
    /// whether they show it at all,
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

    /// Whether so great a share of the misfit goes with one thing, at such a gain under a wander, that no wander is likely
    /// to look like it.
    pub(super) fn is_alone(&self, explains: f64, ratio: f64, quantities: usize) -> bool {
        let lacks = (ALL - explains).max(0.0);
        let per_share = match self.is_likely {
            true => GAIN_PER_SHARE_OF_HAND,
            false => GAIN_PER_SHARE,
        };
        self.gain_under_wander(ratio, quantities) >= -2.0 * LEVEL.ln() + per_share * lacks
    }

    /// Whether an objective that becomes so many times less by one quantity shows more than a wander of any size would,
    /// where times are unknown: Fisher's test, the means over bins less what flights and their times follow.
    pub(super) fn is_less(&self, context: &SolveContext, ratio: f64) -> bool {
        let problem = context.problem;
        let followed = STATE * problem.arcs.len() + self.bins.count();
        let Some(freedom) = self.bins.dimension().checked_sub(followed) else {
            return false;
        };
        let law = FisherSnedecor::new(1.0, freedom as f64);
        law.is_ok_and(|law| law.sf(freedom as f64 * (ratio - 1.0)) < LEVEL_OF_TIMES)
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
