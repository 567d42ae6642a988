//! Which of several quantities that are kept fixed is wrong: with it free, and the errors told again with it free, it is
//! many deviations from where it is kept, and no other hand explains the samples nearly as well.
//!
//! A test at the errors that were told with all of them fixed would take what a wrong one leaves for a wander. It only
//! chooses which ones are tried. With `L` the restricted likelihood at the likeliest errors and a prior `N(0, τ²)` of a typical
//! change `τ`, the odds are `L_free/L_fixed`.

use super::likelihood::{FittedErrors, LikelyErrors, Restricted};

/// Deviations beyond which a quantity is wrong,
pub const WRONG: f64 = 4.0;
/// where the logarithm of the odds that it is exceeds this.
const ODDS: f64 = 4.5;
/// Logarithm of the odds within which two are not told apart: of twenty.
const ALIKE: f64 = 3.0;
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
    /// By how much it may change at most, down and up.
    pub room: [f64; 2],
    /// From which change it is tried whatever its slope tells, which may vanish.
    pub tried_from: Option<f64>,
}

/// How quantities are looked at.
pub trait Looker {
    /// Whether there is no time for another one.
    fn should_stop(&mut self) -> bool;

    /// What a quantity explains, from what it does by its slope, beside what follows where none is free; `None` where nothing is
    /// tried, or that leads to no motion.
    fn tried(&mut self, near: WrongQuantity, fixed: &FittedErrors) -> Option<WrongQuantity>;
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
    /// Share of the wander's variance that goes with it, or where nothing strays, of the noise's.
    pub explains: f64,
}

impl WrongQuantity {
    /// Of which nothing is known but from where it is tried.
    fn from(index: usize, change: f64) -> Self {
        Self {
            index,
            change,
            deviations: 0.0,
            log_odds: f64::NEG_INFINITY,
            explains: 0.0,
        }
    }

    /// Whether its slope told anything.
    pub fn is_told(&self) -> bool {
        self.log_odds.is_finite()
    }

    /// What a motion tells that was found with a quantity free, beside the one with it fixed.
    ///
    /// Of `A` with it free, the part along which it stays has the determinant `|A| (sd/length)²`, with the length of the
    /// quantity's derivative by the directions, which are orthonormal; over the quantity the likelihood is integrated with its
    /// prior.
    pub fn found(&self, freed: &FreedQuantity, [with, fixed]: [&FittedErrors; 2]) -> Self {
        let FreedQuantity {
            change,
            sd,
            sd_per_length,
            typical,
        } = *freed;
        let price = (typical / sd).hypot(1.0).ln() + 0.5 * (change / typical).powi(2);
        let merit = with.merit + 2.0 * sd_per_length.ln();
        Self {
            index: self.index,
            change,
            deviations: change / sd,
            log_odds: 0.5 * (fixed.merit - merit) - price,
            explains: explained(with, fixed),
        }
    }
}

/// A quantity at its likely value.
#[derive(Clone, Copy, Debug)]
pub struct FreedQuantity {
    /// By how much it is not as it was kept.
    pub change: f64,
    /// Its standard deviation.
    pub sd: f64,
    /// The same by the length of its derivative by the directions; one where it stays at a limit.
    pub sd_per_length: f64,
    /// A typical change of it.
    pub typical: f64,
}

/// Share of what strays that goes with a quantity.
fn explained(with: &FittedErrors, fixed: &FittedErrors) -> f64 {
    (1.0 - with.strayed() / fixed.strayed()).clamp(0.0, 1.0)
}

/// What a motion's samples say of quantities that are kept fixed.
#[derive(Clone, Debug)]
pub struct Judgement {
    /// Those that are wrong, the likeliest first.
    pub wrong: Vec<WrongQuantity>,
    /// Of each the change that would show, infinite where none would.
    pub shows: Vec<f64>,
}

/// Looks at quantities whose columns come after the free ones, one by one, by samples at least so far apart \[s\]; `None` where
/// there is no time. What rounding leaves no answer of is not wrong.
pub fn judge(
    of: &Restricted,
    fitted: &FittedErrors,
    kept: &[KeptQuantity],
    apart_s: f64,
    looker: &mut dyn Looker,
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
    let by_noise = of.at(&LikelyErrors::of(
        fitted.errors.processes.map(|of| of.without_wander()),
    ));
    let by_noise = by_noise.unwrap_or_else(|| fitted.clone());
    let mut tried: Vec<usize> = best(fitted, TRIED)
        .chain(best(&by_noise, TRIED_BY_NOISE))
        .collect();
    tried.sort_unstable();
    tried.dedup();
    let is_likely = |one: &WrongQuantity| one.deviations.abs() > WRONG && one.log_odds > ODDS;
    // What would have to leave what is physical explains nothing.
    let may_be = |one: &WrongQuantity| {
        let KeptQuantity {
            room,
            explains_least,
            ..
        } = kept[one.index];
        one.change.clamp(room[0], room[1]) != 0.0 && one.explains >= explains_least
    };
    let mut wrong: Vec<WrongQuantity> = Vec::new();
    let blind = kept.iter().enumerate().filter_map(|(index, of)| {
        let change = of.tried_from.filter(|_| !tried.contains(&index))?;
        Some(WrongQuantity::from(index, change))
    });
    let blind: Vec<WrongQuantity> = blind.collect();
    let rows = of.rows.thinned(apart_s);
    let thin = Restricted { rows: &rows, ..*of };
    let is_any = !tried.is_empty() || !blind.is_empty();
    let fixed = is_any.then(|| thin.likeliest(&fitted.errors));
    if let Some(fixed) = fixed.flatten() {
        for index in tried {
            if looker.should_stop() {
                return None;
            }
            wrong.extend(with_one(&thin, &fixed, index, kept[index].typical));
        }
        let mut retried = |near: Vec<WrongQuantity>| {
            let mut found = Vec::new();
            for near in near {
                if looker.should_stop() {
                    return None;
                }
                found.extend(looker.tried(near, &fixed));
            }
            Some(found)
        };
        let of_blind: Vec<WrongQuantity> = retried(blind)?;
        // Where one is wrong, slopes may not tell which.
        let mut all = wrong.iter().chain(&of_blind);
        if all.any(|one| is_likely(one) && may_be(one)) {
            wrong = retried(wrong)?;
        }
        wrong.extend(of_blind);
    }
    wrong.retain(may_be);
    wrong.sort_by(|a: &WrongQuantity, b| b.log_odds.total_cmp(&a.log_odds));
    let best = wrong.iter().copied().find(is_likely);
    wrong.retain(|one| {
        // What explains nearly as well is not told from it.
        let is_alike = best.is_some_and(|best| one.log_odds > best.log_odds - ALIKE);
        is_likely(one) || is_alike
    });
    Some(Judgement {
        wrong,
        shows: shows.collect(),
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
    let (rows, mut priors) = of.select(&kept);
    priors[(free, free)] += typical.powi(-2);
    let with = Restricted {
        rows: &rows,
        free: free + 1,
        priors: &priors,
        least: of.least,
    };
    let fitted = with.likeliest(&fixed.errors)?;
    let change = -fitted.answer[free];
    Some(WrongQuantity {
        index,
        change,
        deviations: change / fitted.deviation(free),
        log_odds: 0.5 * (fixed.merit - fitted.merit) - typical.ln(),
        explains: explained(&fitted, fixed),
    })
}
