//! Which of several quantities that are kept fixed is wrong: with it free, and the errors told again with it free, it is
//! many deviations from where it is kept, and no other hand explains the samples nearly as well.
//!
//! A test at the errors that were told with all of them fixed would take what a wrong one leaves for a wander. It only
//! chooses which ones are tried. With `L` the restricted likelihood at the likeliest errors and a prior `N(0, τ²)` of a typical
//! change `τ`, the odds are `L_free/L_fixed`.

use nalgebra::DMatrix;

use super::likelihood::{APART_S, FittedErrors, Restricted};
use super::process::Process;

/// Deviations beyond which a quantity is wrong,
pub const WRONG: f64 = 4.0;
/// where the logarithm of the odds that it is exceeds this.
const ODDS: f64 = 4.5;
/// Deviations beyond which one is tried, at the errors told with all fixed,
const TRIED: f64 = 2.0;
/// and at noise alone, which takes no misfit for a wander.
const TRIED_BY_NOISE: f64 = 4.0;
/// How many are tried at most of each.
const TRIALS: usize = 5;

/// A quantity that is kept fixed.
#[derive(Clone, Copy, Debug)]
pub struct KeptQuantity {
    /// A typical change of it.
    pub typical: f64,
    /// Share of the wander's variance that has to go with it if it is wrong.
    pub explains_least: f64,
}

/// A quantity that is wrong.
#[derive(Clone, Copy, Debug)]
pub struct WrongQuantity {
    /// Which one.
    pub index: usize,
    /// By how much.
    pub change: f64,
    /// The same, in deviations.
    pub deviations: f64,
    /// Logarithm of the odds that it is, if it may be off by a typical change.
    pub log_odds: f64,
    /// Share of the wander's variance that goes with it.
    pub explains: f64,
}

/// What a motion's samples say of quantities that are kept fixed.
#[derive(Clone, Debug)]
pub struct Judgement {
    /// What follows where no hand strayed.
    pub by_noise: FittedErrors,
    /// Those that are wrong, the likeliest first.
    pub wrong: Vec<WrongQuantity>,
    /// Of each the change that would show, infinite where none would.
    pub shows: Vec<f64>,
}

/// Looks at quantities whose columns come after the free ones, one by one; `None` where there is no time. What rounding leaves no
/// answer of is not wrong.
pub fn judge(
    of: &Restricted,
    fitted: &FittedErrors,
    kept: &[KeptQuantity],
    should_stop: &mut dyn FnMut() -> bool,
) -> Option<Judgement> {
    let last = kept.len();
    let score = |of: &FittedErrors, index: usize| {
        let information = of.left[(index, index)];
        let is_told = information * kept[index].typical.powi(2) > 1.0;
        is_told.then(|| of.left[(index, last)].abs() / information.sqrt())
    };
    let shows = (0..last).map(|index| match score(fitted, index) {
        Some(_) => WRONG / fitted.left[(index, index)].sqrt(),
        None => f64::INFINITY,
    });
    let best = |of: &FittedErrors, least: f64| {
        let mut best: Vec<(usize, f64)> = (0..last)
            .filter_map(|index| Some((index, score(of, index)?)))
            .filter(|(_, score)| *score > least)
            .collect();
        best.sort_by(|a, b| b.1.total_cmp(&a.1));
        best.into_iter().map(|(index, _)| index).take(TRIALS)
    };
    let by_noise = of.at(&without_wander(&fitted.processes));
    let by_noise = by_noise.unwrap_or_else(|| fitted.clone());
    let mut tried: Vec<usize> = best(fitted, TRIED)
        .chain(best(&by_noise, TRIED_BY_NOISE))
        .collect();
    tried.sort_unstable();
    tried.dedup();
    let mut wrong = Vec::new();
    let rows = of.rows.thinned(APART_S);
    let thin = Restricted { rows: &rows, ..*of };
    let fixed = (!tried.is_empty()).then(|| thin.likeliest(&fitted.processes));
    if let Some(fixed) = fixed.flatten() {
        for index in tried {
            if should_stop() {
                return None;
            }
            let one = with_one(&thin, &fixed, index, kept[index].typical);
            wrong.extend(one.filter(|one| {
                let is_likely = one.deviations.abs() > WRONG && one.log_odds > ODDS;
                is_likely && one.explains >= kept[index].explains_least
            }));
        }
    }
    wrong.sort_by(|a: &WrongQuantity, b| b.log_odds.total_cmp(&a.log_odds));
    Some(Judgement {
        wrong,
        shows: shows.collect(),
        by_noise,
    })
}

/// A quantity where it is free, too.
fn with_one(
    of: &Restricted,
    fixed: &FittedErrors,
    index: usize,
    typical: f64,
) -> Option<WrongQuantity> {
    let free = of.free;
    let last = of.rows.count() - 1;
    let kept: Vec<usize> = (0..free).chain([free + index, last]).collect();
    let rows = of.rows.select(&kept);
    let mut priors: DMatrix<f64> = of.priors.select_columns(&kept).select_rows(&kept);
    priors[(free, free)] += typical.powi(-2);
    let with = Restricted {
        rows: &rows,
        free: free + 1,
        priors: &priors,
        least: of.least,
    };
    let fitted = with.likeliest(&fixed.processes)?;
    let change = -fitted.answer[free];
    let wander = |of: &FittedErrors| -> f64 {
        let kinds = (0..2).filter(|kind| rows.shows(*kind));
        kinds.map(|kind| of.processes[kind].wander_variance()).sum()
    };
    Some(WrongQuantity {
        index,
        change,
        deviations: change / fitted.deviation(free),
        log_odds: 0.5 * (fixed.merit - fitted.merit) - typical.ln(),
        explains: (1.0 - wander(&fitted) / wander(fixed)).clamp(0.0, 1.0),
    })
}

/// The errors of a motion of which no hand strayed: the same without their wander.
pub fn without_wander(processes: &[Process; 2]) -> [Process; 2] {
    processes.map(|of| Process {
        smooth_sd: f64::MIN_POSITIVE.sqrt(),
        rough_sd: f64::MIN_POSITIVE.sqrt(),
        ..of
    })
}
