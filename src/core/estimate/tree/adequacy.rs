//! Adequacy of a motion of joined bodies: whether noise and a hand's wander explain what is left of its samples, and
//! which quantity that the scene keeps fixed would explain it instead.
//!
//! Bodies by themselves have flights between events, which fit without them; joined bodies have no such reference. It is
//! taken from the samples themselves: second differences show the white noise, and what is slower is a wander of the
//! hand or a wrong scene ([`errors`]). The two are told apart by their shapes: one quantity, moved, changes all samples
//! in one way `u` beyond what the motion may follow ([`linear`]), a wander in any of many ways. Under each model of the
//! errors, with a prior `N(0, τ²)` of a typical change `τ`, the odds of a wrong quantity are
//!
//! ```text
//! s = uᵀ P r,   V = uᵀ P u,   Δθ = −s/(V + τ⁻²)
//! log (L_θ/L) = ½ s²/(V + τ⁻²) − ½ log (τ² V + 1)
//! ```
//!
//! which is Rao's score test `s²/V` with the errors' own covariance, less a price for what the prior allows ([`odds`]).
//! Those that score high are set free for a [`trial`], whose odds then count. Where no quantity is wrong, the motion is
//! said to fit only if joints that are elsewhere by a share of a link would have shown, in every direction that samples tell
//! anything of.

mod candidates;
pub(super) mod certainty;
mod errors;
mod linear;
pub(super) mod linearised;
mod odds;
#[cfg(test)]
mod tests;
mod trial;

use nalgebra::{DVector, Vector3};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use self::candidates::{STEP, candidates, change};
use self::errors::{Left, TreeErrors};
use self::linear::Linear;
use self::linearised::Linearised;
use self::trial::{TriedQuantity, tried};
use super::problem::TreeProblem;
use crate::estimate::adequacy::wandering::{Asked, together};
use crate::estimate::wander::Process;
use crate::motion::{
    Fit, FitUntold, Fits, GoalUnit, JointTree, Observer, Quantity, Scene, Suspect, Tested, WholeFit,
};

/// Above this probability of the data under white noise they fit.
const WELL: f64 = 1e-3;
/// Logarithm of the odds that samples show a wander.
const WANDER: f64 = 3.0;
/// Logarithm of the odds, of all quantities together, beyond which one is suspected,
const SUSPECTED: f64 = 6.0;
/// and beyond which it is set free for a trial.
const TRIED: f64 = 0.0;
/// Greatest number of trials.
const TRIALS: usize = 6;
/// Least share of the misfit that a suspect explains: of a wander by chance, no quantity explains so much.
const LEAST_SHARE: f64 = 0.3;
/// Least number of residuals beyond what the motion may follow, and of those that tell the noise.
const LEAST_FREEDOM: f64 = 6.0;
/// A joint that is elsewhere by this share of its link's length, in any direction that samples tell of, must show, or
/// the motion is not said to fit.
const SHOWN_SHARE: f64 = 0.1;
/// A wander that is farther from the motion than this, in weights of the samples, is none that a motion fits.
const FAR: f64 = 3.0;
/// How many times as far from its samples as bodies that rest a motion may be from which a hand strays.
const BESIDE: f64 = 1.5;

/// A quantity that the scene keeps fixed.
struct SuspectCandidate {
    quantity: Quantity,
    /// `u`.
    total: DVector<f64>,
}

/// How well a solution explains its samples, and what in the scene may be wrong where it does not. Fails where samples
/// are too few to tell, and where the observer stops it.
pub(super) fn judge(
    scene: &Scene,
    joined: &JointTree,
    of: &Linearised,
    observer: &mut dyn Observer,
) -> Result<(Fit, Vec<Suspect>), FitUntold> {
    if let Some(errors) = of.problem.errors {
        return judge_wandering(scene, joined, of, &errors, observer);
    }
    let Linearised {
        problem,
        active,
        linear,
        errors,
        held,
        ..
    } = of;
    let errors = errors.as_ref().ok_or(FitUntold::FewSamples)?;
    let candidates = suspect_candidates(scene, joined, of);
    let totals: Vec<DVector<f64>> = candidates.iter().map(|of| of.total.clone()).collect();
    let residuals = linear.of_samples();
    let left = errors.left(
        &held.free,
        totals.as_slice(),
        &residuals,
        problem.information.0,
    );
    let by_noise = by_noise(linear, errors, &left, held.free.ncols());
    let by_noise = by_noise.ok_or(FitUntold::FewSamples)?;
    let is_told = |at: usize, of: &SuspectCandidate| {
        // Where not even white noise alone lets a typical change show by a standard deviation.
        left[0].products[(at, at)] * of.quantity.typical().powi(2) > 1.0
    };
    let (told, untold): (Vec<_>, Vec<_>) = candidates
        .iter()
        .enumerate()
        .partition(|(at, of)| is_told(*at, of));
    let price = (told.len().max(1) as f64).ln();
    let evidence = odds::evidence(&left);
    let mut scored: Vec<(Quantity, f64)> = told
        .iter()
        .map(|(at, of)| {
            let wrong = odds::evidence_if_wrong(&left, *at, of.quantity.typical(), 0.0);
            (of.quantity, wrong - evidence - price)
        })
        .filter(|(_, odds)| *odds > TRIED)
        .collect();
    scored.sort_by(|a, b| b.1.total_cmp(&a.1));
    let cost = 0.5 * residuals.norm_squared();
    let misfit = (cost - errors.floor()).max(f64::MIN_POSITIVE);
    let mut suspects = Vec::new();
    for (quantity, _) in scored.into_iter().take(TRIALS) {
        if observer.should_stop() {
            return Err(FitUntold::Stopped);
        }
        let Some(tried) = tried(scene, problem, of.point, active, quantity) else {
            continue;
        };
        let wrong = evidence_at(scene, errors, quantity, &tried, problem.information.0);
        let odds = wrong - evidence - price;
        let explains =
            ((cost - 0.5 * tried.linear.of_samples().norm_squared()) / misfit).clamp(0.0, 1.0);
        if odds > SUSPECTED && explains >= LEAST_SHARE {
            suspects.push(Suspect {
                values: vec![(quantity, tried.value)],
                explains,
                gain: 2.0 * odds,
                probability: (-odds).exp(),
            });
        }
    }
    let suspects = together(suspects);
    let log_odds_of_wander = odds::of_wander(&left);
    // Of each joint, the direction in which an error of its place shows least.
    let shown = joined.joints.iter().map(|joint| {
        let of_joint = told.iter().filter(|(_, of)| match of.quantity {
            Quantity::JointPlace { child, .. } => child == joint.child,
            _ => false,
        });
        let errors_m = of_joint
            .map(|(at, of)| odds::shown(&left, *at, of.quantity.typical(), SUSPECTED + price));
        let most_m = errors_m.reduce(f64::max).unwrap_or(f64::INFINITY);
        (most_m, most_m / (2.0 * scene.links[joint.child].radius_m()))
    });
    let (shown_m, shown_share) = shown.fold(
        (0.0, 0.0),
        |most: (f64, f64), of| {
            if of.1 > most.1 { of } else { most }
        },
    );
    let joint = linear.rms();
    let is_noise = by_noise.probability >= WELL;
    let fits = match () {
        () if !suspects.is_empty() || farther_than_rest(problem, joint[0]) => Fits::No,
        () if shown_share > SHOWN_SHARE => Fits::Unknown,
        () if is_noise => Fits::Yes,
        () if log_odds_of_wander > WANDER && linear.rms_in_weights() <= FAR => Fits::Yes,
        () => Fits::Unknown,
    };
    let fit = Fit {
        fits,
        joint,
        alone: errors.white_rms(&linear.series),
        parts: Vec::new(),
        whole: Some(WholeFit {
            by_noise,
            is_noise,
            log_odds_of_wander,
            shown_m: Some(shown_m),
            untold: untold.iter().map(|(_, of)| of.quantity).collect(),
        }),
    };
    Ok((fit, suspects))
}

/// The same where samples err in time.
fn judge_wandering(
    scene: &Scene,
    joined: &JointTree,
    of: &Linearised,
    errors: &[Process; 2],
    observer: &mut dyn Observer,
) -> Result<(Fit, Vec<Suspect>), FitUntold> {
    let candidates = suspect_candidates(scene, joined, of);
    let quantities: Vec<Quantity> = candidates.iter().map(|of| of.quantity).collect();
    let totals: Vec<DVector<f64>> = candidates.into_iter().map(|of| of.total).collect();
    let columns = of.columns(&totals);
    let (rows, priors) = of.rows(&columns);
    let restricted = of.restricted(&rows, &priors);
    let fitted = restricted.at(errors).ok_or(FitUntold::FewSamples)?;
    let joint = of.linear.rms();
    let asked = Asked {
        scene,
        quantities: &quantities,
        joint,
        // The motion does not follow the hand, but bodies at their mean places do.
        is_far: farther_than_rest(of.problem, joint[0] / BESIDE),
    };
    asked.judged(&restricted, &fitted, observer)
}

/// What the scene keeps fixed, with how residuals change with it.
fn suspect_candidates(scene: &Scene, joined: &JointTree, of: &Linearised) -> Vec<SuspectCandidate> {
    let Linearised {
        problem,
        active,
        linear,
        held,
        ..
    } = of;
    candidates(scene, joined, problem)
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

/// The test of all residuals against white noise; `None` where too few are beyond what the motion may follow.
fn by_noise(
    linear: &Linear,
    errors: &TreeErrors,
    left: &[Left],
    followed: usize,
) -> Option<Tested> {
    let freedom = errors.row_count(linear) as f64 - (followed + linear.rate_rows) as f64;
    let noise_freedom = errors.degrees();
    if freedom < LEAST_FREEDOM || noise_freedom < LEAST_FREEDOM {
        return None;
    }
    let products = &left.first()?.products;
    let last = products.nrows() - 1;
    let statistic = products[(last, last)] / freedom;
    let law = FisherSnedecor::new(freedom, noise_freedom).ok()?;
    Some(Tested {
        statistic,
        freedom: freedom as usize,
        noise_freedom: noise_freedom as usize,
        probability: law.sf(statistic),
    })
}

/// Logarithm of the likelihood of a scene with a quantity free, where a trial led.
fn evidence_at(
    scene: &Scene,
    errors: &TreeErrors,
    quantity: Quantity,
    tried: &TriedQuantity,
    information: f64,
) -> f64 {
    let held = tried.linear.held();
    let total = [tried.linear.total(&held, &tried.change)];
    let residuals = tried.linear.of_samples();
    let left = errors.left(&held.free, &total, &residuals, information);
    let off = tried.value - scene.value_of(quantity);
    odds::evidence_if_wrong(&left, 0, quantity.typical(), off)
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
