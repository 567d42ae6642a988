//! Adequacy of a motion of joined bodies, as of bodies by themselves ([`asked`]): here residuals change with
//! quantities by differences ([`candidates`]), and what the motion may follow is told by all its rows at once ([`linear`]).
//!
//! Where no quantity is wrong, the motion is said to fit only if joints that are elsewhere by a share of a link would have
//! shown, in every direction that samples tell anything of.
//!
//! [`asked`]: crate::estimate::adequacy::asked

mod candidates;
pub(super) mod certainty;
mod linear;
pub(super) mod linearised;
#[cfg(test)]
mod tests;
mod trial;

use nalgebra::{DVector, Vector3};

use self::candidates::{STEP, candidates, change};
use self::linearised::Linearised;
use self::trial::TreeTrials;
use super::problem::TreeProblem;
use crate::estimate::adequacy::asked::{Asked, FitAsked};
use crate::estimate::covariance::in_time::Strayed;
use crate::motion::{Fit, FitUntold, GoalUnit, Observer, Performer, Quantity, Scene, Suspect};

/// How many times as far from its samples as bodies that rest a motion may be from which a hand strays.
const BESIDE: f64 = 1.5;

/// A quantity that the scene keeps fixed.
struct SuspectCandidate {
    quantity: Quantity,
    /// How residuals change with it, beyond what rows hold.
    total: DVector<f64>,
}

/// How well a solution explains its samples, and what in the scene may be wrong where it does not. Fails where samples
/// are too few to tell, and where the observer stops it.
pub(super) fn judge(
    scene: &Scene,
    of: &Linearised,
    observer: &mut dyn Observer,
) -> Result<(Fit, Vec<Suspect>), FitUntold> {
    let told = of.told().ok_or(FitUntold::FewSamples)?;
    let candidates = suspect_candidates(scene, of);
    let quantities: Vec<Quantity> = candidates.iter().map(|of| of.quantity).collect();
    let totals: Vec<DVector<f64>> = candidates.into_iter().map(|of| of.total).collect();
    let columns = of.columns(&totals);
    let (rows, priors) = of.rows(&columns);
    let restricted = of.restricted(&rows, &priors);
    let fitted = restricted.at(&told.errors).ok_or(FitUntold::FewSamples)?;
    let joint = of.linear.rms();
    let strayed = match (&of.problem.errors, scene.performer) {
        (Some(_), _) => Strayed::Hand,
        (None, Performer::Nobody) => Strayed::Tracker,
        (None, Performer::Hand | Performer::Unsaid) => Strayed::MaybeHand,
    };
    let trials = TreeTrials {
        scene,
        of,
        apart_s: strayed.apart_s(),
    };
    let asked = Asked {
        of_fit: FitAsked::WithSuspects,
        scene,
        quantities: &quantities,
        joint,
        // The motion does not follow the hand, but bodies at their mean places do.
        is_far: farther_than_rest(of.problem, joint[0] / BESIDE),
        strayed,
        trials: Some(&trials),
    };
    asked.judged(&restricted, &fitted, observer)
}

/// What the scene keeps fixed, with how residuals change with it.
fn suspect_candidates(scene: &Scene, of: &Linearised) -> Vec<SuspectCandidate> {
    let Linearised {
        problem,
        active,
        linear,
        held,
        ..
    } = of;
    candidates(scene, problem)
        .into_iter()
        .filter_map(|quantity| {
            let step = STEP * quantity.typical();
            let change = change(
                scene,
                problem,
                of.point,
                active,
                quantity,
                scene.value_of(quantity),
                step,
            )?;
            let total = linear.total(held, &change);
            Some(SuspectCandidate { quantity, total })
        })
        .collect()
}

/// Whether the motion is farther from its samples than bodies that rest at their mean places would be: no one quantity
/// is to blame for that.
fn farther_than_rest(problem: &TreeProblem, distance_m: f64) -> bool {
    let placed = || {
        let samples = problem.samples.iter();
        samples.filter(|sample| sample.quantity.unit() == GoalUnit::Metre)
    };
    let mut squares_m2 = 0.0;
    let mut tracks: Vec<_> = placed().map(|sample| sample.track).collect();
    tracks.sort();
    tracks.dedup();
    for track in tracks {
        let places = || placed().filter(|of| of.track == track).map(|of| of.seen);
        let mean_m = places().sum::<Vector3<f64>>() / places().count() as f64;
        squares_m2 += places()
            .map(|place_m| (place_m - mean_m).norm_squared())
            .sum::<f64>();
    }
    distance_m * distance_m * placed().count() as f64 > squares_m2
}
