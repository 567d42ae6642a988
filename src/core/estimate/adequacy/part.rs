//! What the tests of an event and of a flight share.

use nalgebra::DVector;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::alone::Alone;
use super::hand::{Expected, ResidualKind, Wander};
use crate::estimate::covariance::bins::{Bins, Residuals, Six};
use crate::estimate::covariance::trace::Design;
use crate::estimate::terms::context::SolveContext;
use crate::motion::{PartFit, Performer, Place, Tested};

/// What is tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Index into `Scene::events`.
    Event(usize),
    /// Index into `Problem::arcs`.
    Flight(usize),
}

/// A test with the noise that it was made under, in squared units of positions and orientations.
pub(super) struct PartTest {
    pub(super) part: Part,
    pub(super) fit: PartFit,
    pub(super) white: [f64; 2],
    /// Variances of the hand's wander.
    pub(super) wander: [f64; 2],
}

impl PartTest {
    /// The test of a part, at its place, by noise and by a hand.
    pub(super) fn new(
        part: Part,
        place: Place,
        white: [f64; 2],
        hands: &[Wander; 2],
        by_noise: Tested,
        by_hand: Tested,
    ) -> Self {
        Self {
            part,
            wander: [0, 1].map(|kind| hands[kind].variance),
            white,
            fit: PartFit {
                place,
                by_noise,
                by_hand,
                log_odds_of_wander: hands[0].log_odds.max(hands[1].log_odds),
            },
        }
    }
}

/// A sum of `freedom` squares, each with one as expected, as a statistic with Fisher's distribution; `None`
/// where there are none.
pub(super) fn tested(square: f64, freedom: usize, noise_freedom: usize) -> Option<Tested> {
    let statistic = square / freedom as f64;
    let law = FisherSnedecor::new(freedom as f64, noise_freedom.max(1) as f64).ok()?;
    Some(Tested {
        statistic,
        freedom,
        noise_freedom,
        probability: law.sf(statistic),
    })
}

/// The wander over some bins: as the flights' residuals show it beyond the directions that their fits absorb; where
/// there was no hand, a tracker's slow errors.
pub(super) fn hands(
    context: &SolveContext,
    bins: &Bins,
    errors: &[Residuals],
    absorbed: &[Vec<Six>],
    white: [f64; 2],
    expected: Expected,
) -> [Wander; 2] {
    let means = bins.mean_residuals(errors);
    let problem = context.problem;
    ResidualKind::ALL.map(|kind| match problem.performer {
        Performer::Nobody => Wander::of_tracker(bins),
        Performer::Hand | Performer::Unsaid => {
            let unit = [problem.position_unit_m, problem.orientation_unit_rad][kind as usize];
            Wander::of(
                bins,
                kind,
                means.as_slice(),
                absorbed,
                white[kind as usize],
                unit,
                expected,
            )
        }
    })
}

/// The wander over other bins, of variances that were shown.
pub(super) fn hands_like(context: &SolveContext, bins: &Bins, variances: [f64; 2]) -> [Wander; 2] {
    ResidualKind::ALL.map(|kind| match context.problem.performer {
        Performer::Nobody => Wander::of_tracker(bins),
        Performer::Hand | Performer::Unsaid => {
            Wander::of_variance(bins, kind, variances[kind as usize])
        }
    })
}

/// Number of residuals that are seen.
pub(super) fn seen(errors: &[Residuals]) -> usize {
    let of_each = errors.iter().map(|of| {
        let kinds = of.kinds.iter().filter(|is_seen| **is_seen).count();
        3 * of.each.len() * kinds
    });
    of_each.sum()
}

/// Directions of the bins' means that the flights' own fits absorb.
pub(super) fn absorbed(
    context: &SolveContext,
    alone: &Alone,
    bins: &Bins,
    design: &Design,
    arcs: &[usize],
) -> Vec<Vec<Six>> {
    let (problem, layout) = (context.problem, context.layout);
    let mut directions: Vec<Vec<Six>> = Vec::new();
    if problem.times_are_unknown() {
        for (bin, rate) in design.rates().into_iter().enumerate() {
            let mut column = vec![[0.0; 6]; bins.count()];
            column[bin] = rate;
            directions.push(column);
        }
    }
    let states = arcs.iter().flat_map(|arc| layout.state(*arc));
    let parameters = layout.parameters.iter().copied();
    for unknown in states.chain(parameters) {
        if !alone.is_unseen(unknown) {
            let mut step = DVector::zeros(layout.size());
            step[unknown] = 1.0;
            directions.push(bins.means(&design.sums(&step)));
        }
    }
    directions
}
