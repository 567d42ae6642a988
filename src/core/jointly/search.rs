//! Rounds: where each take is asked next, from what all of them said.

use nalgebra::{DMatrix, DVector};

use super::parameter::{JointParameter, NORMAL_MEDIAN, lengths};
use super::part::{MeanPart, PlainPart, Total};
use super::spread::TakesField;
use super::weak::{WeakDirection, weak, without};
use crate::motion::TakeShare;

/// A step that changes nothing by more of its length is the last.
const SAME: f64 = 1e-9;
/// Where takes hardly tell a spread rounding moves it without end: so many rounds in which nothing else moves are the last.
const STILL: usize = 3;
/// Greatest step, in lengths: takes are curved.
const FARTHEST: f64 = 0.5;
/// Greatest number of rounds, and how often one step may be halved.
const ROUNDS: usize = 150;
const HALVINGS: usize = 12;
/// How often for a take that says nothing.
const FOR_SILENT: usize = 2;
/// Where takes have kinks, as where friction begins to stick, steps get short without end: one so short is near enough.
const NEAR: f64 = 1e-3;
/// An objective that is greater by less than this share is the same.
const ROUNDING: f64 = 1e-11;
/// How much directions that are not determined are held, relative to the greatest information.
const HELD: f64 = 1e6;

/// What a round leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SearchTurn {
    /// The takes are to be asked again.
    Again,
    /// The optimum is found.
    Found,
    /// It was not found in as many rounds as there may be, or the takes have none.
    Lost,
}

/// A search for the joint optimum.
#[derive(Clone, Debug)]
pub struct JointSearch {
    parameters: Vec<JointParameter>,
    /// In lengths, like all that follows: the joint values, the variances of what is drawn,
    mean: DVector<f64>,
    variances: DVector<f64>,
    /// and where each take is asked.
    asked: Vec<DVector<f64>>,
    /// Which takes take part.
    taking: Vec<bool>,
    /// Directions that are not determined, once that is known.
    held: Option<DMatrix<f64>>,
    weak: Vec<WeakDirection>,
    best: Option<BestSoFar>,
    halvings: usize,
    rounds: usize,
    /// Rounds in a row in which no take was asked elsewhere.
    still: usize,
    /// How far the last step goes, in lengths.
    moved: f64,
    /// Whether it ended near the optimum only.
    is_near_only: bool,
}

/// The best place so far.
#[derive(Clone, Debug)]
struct BestSoFar {
    mean: DVector<f64>,
    asked: Vec<DVector<f64>>,
    objective: f64,
}

impl JointSearch {
    /// A search among takes from what each of them says at its own optimum: from the medians of their own values, each with
    /// the weight of its information. `None`: takes no part until it says something.
    pub fn new(parameters: Vec<JointParameter>, own: &[Option<TakeShare>]) -> Self {
        let mean = DVector::from_iterator(
            parameters.len(),
            parameters.iter().enumerate().map(|(at, parameter)| {
                let values = own.iter().flatten().map(|share| {
                    let value = share.values[at] / parameter.length;
                    (value, told(&parameters, share, at))
                });
                let median = median(values.collect());
                parameter.inside(median.unwrap_or(parameter.initial / parameter.length))
            }),
        );
        let mut begun = Self {
            variances: DVector::zeros(parameters.len()),
            asked: vec![mean.clone(); own.len()],
            taking: own.iter().map(Option::is_some).collect(),
            parameters,
            mean,
            held: None,
            weak: Vec::new(),
            best: None,
            halvings: 0,
            rounds: 0,
            still: 0,
            moved: f64::INFINITY,
            is_near_only: false,
        };
        begun.begin_apart(own);
        begun
    }

    /// Asks each take at its own values of what is drawn: from the mean it may be led to another optimum.
    fn begin_apart(&mut self, own: &[Option<TakeShare>]) {
        let drawn = self.parameters.iter().enumerate();
        for (at, parameter) in drawn.filter(|(_, of)| of.is_drawn) {
            let [lower, upper] = parameter.bounds();
            let value =
                |share: &TakeShare| (share.values[at] / parameter.length).clamp(lower, upper);
            for (asked, share) in self.asked.iter_mut().zip(own) {
                asked[at] = share.as_ref().map_or(asked[at], value);
            }
            let offs = own
                .iter()
                .flatten()
                .map(|of| ((value(of) - self.mean[at]).abs(), 1.0));
            let off = median(offs.collect()).unwrap_or(0.0);
            self.variances[at] = (off / NORMAL_MEDIAN).powi(2);
        }
    }

    /// What is asked for.
    pub fn parameters(&self) -> &[JointParameter] {
        &self.parameters
    }

    /// The values at which a take is to be asked, SI.
    pub fn asked(&self, take: usize) -> DVector<f64> {
        self.asked[take].component_mul(&lengths(&self.parameters))
    }

    /// The joint values, SI.
    pub fn values(&self) -> DVector<f64> {
        self.mean.component_mul(&lengths(&self.parameters))
    }

    /// Whether a take takes part.
    pub fn is_taking_part(&self, take: usize) -> bool {
        self.taking[take]
    }

    /// Takes a take in that has a share at values, SI: the joint ones, and its own of what is drawn.
    pub fn take_in(&mut self, take: usize, values: &DVector<f64>) {
        self.taking[take] = true;
        self.asked[take] = values.component_div(&lengths(&self.parameters));
        (self.best, self.halvings, self.rounds) = (None, 0, 0);
    }

    /// Looks what the takes together tell where they are asked, before anything is solved.
    pub fn look(&mut self, shares: &[Option<TakeShare>]) {
        let parts = self.of_means(&self.parts(shares));
        self.hold_weak(&self.total(&parts));
    }

    /// Holds the directions that are not determined.
    fn hold_weak(&mut self, total: &Total) {
        let (held, weak) = weak(&self.parameters, &total.information);
        (self.held, self.weak) = (Some(held), weak);
    }

    /// What is left of parts about the means.
    pub(super) fn of_means(&self, parts: &[PlainPart]) -> Vec<MeanPart> {
        let parts = parts.iter();
        parts.map(|of| of.of_means(&self.variances)).collect()
    }

    /// The sum of parts, with the priors.
    pub(super) fn total(&self, parts: &[MeanPart]) -> Total {
        Total::of(&self.parameters, &self.mean, parts.iter())
    }

    /// Number of rounds so far.
    pub fn rounds(&self) -> usize {
        self.rounds
    }

    /// Whether it ended near the optimum only, and how far its last step went, in lengths.
    pub fn near_only(&self) -> Option<f64> {
        self.is_near_only.then_some(self.moved)
    }

    /// What the takes do not determine.
    pub fn weak(&self) -> &[WeakDirection] {
        &self.weak
    }

    pub(super) fn mean(&self) -> &DVector<f64> {
        &self.mean
    }

    pub(super) fn variances(&self) -> &DVector<f64> {
        &self.variances
    }

    pub(super) fn held(&self) -> DMatrix<f64> {
        let none = || DMatrix::zeros(self.parameters.len(), 0);
        self.held.clone().unwrap_or_else(none)
    }

    /// The takes that take part, with what each says about the joint values.
    pub(super) fn parts(&self, shares: &[Option<TakeShare>]) -> Vec<PlainPart> {
        let taking = shares.iter().zip(&self.taking);
        let taking = taking.filter_map(|(share, taking)| share.as_ref().filter(|_| *taking));
        taking
            .map(|share| PlainPart::new(&self.parameters, share, &self.mean))
            .collect()
    }

    /// One round, from what the takes say where they were asked. One that says nothing there, as it has no motion, shortens
    /// the step; where that does not help it takes no part any more.
    pub fn turn(&mut self, shares: &[Option<TakeShare>]) -> SearchTurn {
        self.rounds += 1;
        let silent = |(share, taking): (&Option<TakeShare>, &bool)| *taking && share.is_none();
        let is_silent = shares.iter().zip(&self.taking).any(silent);
        let parts = self.parts(shares);
        if parts.is_empty() {
            return SearchTurn::Lost;
        }
        if self.rounds > ROUNDS {
            self.is_near_only = self.moved < NEAR && !is_silent;
            return match self.is_near_only {
                true => SearchTurn::Found,
                false => SearchTurn::Lost,
            };
        }
        let objective = self.objective(&parts);
        let halvings = if is_silent { FOR_SILENT } else { HALVINGS };
        let may_halve = self.best.is_some() && self.halvings < halvings;
        let is_worse = self.best.as_ref().is_some_and(|best| {
            let rounding = ROUNDING * best.objective.abs().max(1.0);
            !(objective <= best.objective + rounding)
        });
        if (is_worse || is_silent) && may_halve {
            self.halve();
            return SearchTurn::Again;
        }
        if is_silent {
            for (taking, share) in self.taking.iter_mut().zip(shares) {
                *taking &= share.is_some();
            }
        }
        // Where no part of a step leads lower the place before is the optimum to rounding.
        let is_stuck = is_worse && !is_silent;
        self.go_on(&parts, objective, is_stuck)
    }

    /// Goes on from an accepted place.
    fn go_on(&mut self, parts: &[PlainPart], objective: f64, is_stuck: bool) -> SearchTurn {
        self.halvings = 0;
        let before = self.variances.clone();
        if self.parameters.iter().any(|of| of.is_drawn) {
            self.variances = self.likeliest(parts);
        }
        let of_means = self.of_means(parts);
        let total = self.total(&of_means);
        if self.held.is_none() {
            self.hold_weak(&total);
        }
        let Some(step) = self.step(&total) else {
            return SearchTurn::Lost;
        };
        let far = step.amax().max(FARTHEST) / FARTHEST;
        let step = step / far;
        let spreads = self.variances.map(f64::sqrt) - before.map(f64::sqrt);
        let mut of_takes = parts.iter().zip(&of_means);
        let mut moved: f64 = step.amax();
        self.best = Some(BestSoFar {
            mean: self.mean.clone(),
            asked: self.asked.clone(),
            objective: if spreads.amax() > 0.0 {
                f64::INFINITY
            } else {
                objective
            },
        });
        self.mean += &step;
        for (asked, taking) in self.asked.iter_mut().zip(&self.taking) {
            let Some((part, own)) = taking.then(|| of_takes.next()).flatten() else {
                continue;
            };
            let mut there = &self.mean + part.own_off(&own.own, &step);
            for (value, parameter) in there.iter_mut().zip(&self.parameters) {
                let [lower, upper] = parameter.bounds();
                *value = value.clamp(lower, upper);
            }
            moved = moved.max((&there - &*asked).amax());
            *asked = there;
        }
        self.still = if moved < SAME { self.still + 1 } else { 0 };
        self.moved = moved.max(spreads.amax());
        let is_still = self.moved < SAME || self.still >= STILL;
        match is_still || is_stuck {
            true => SearchTurn::Found,
            false => SearchTurn::Again,
        }
    }

    /// Goes half the way back.
    fn halve(&mut self) {
        self.halvings += 1;
        self.moved *= 0.5;
        let Some(best) = &self.best else { return };
        self.mean = 0.5 * (&self.mean + &best.mean);
        for (asked, before) in self.asked.iter_mut().zip(&best.asked) {
            *asked = 0.5 * (&*asked + before);
        }
    }

    /// `Σ f_k + ½ Σ bᵀT⁻¹b` with the priors: what a step must not increase.
    fn objective(&self, parts: &[PlainPart]) -> f64 {
        let of_take = |part: &PlainPart| {
            let off = part.off.iter().zip(&self.variances);
            let drawn = off.filter(|(_, variance)| **variance > 0.0);
            part.cost
                + 0.5
                    * drawn
                        .map(|(off, variance)| off * off / variance)
                        .sum::<f64>()
        };
        let takes: f64 = parts.iter().map(of_take).sum();
        let priors = self.parameters.iter().zip(&self.mean);
        let priors = priors.map(|(of, mean)| of.prior() * (mean - of.initial / of.length).powi(2));
        takes + 0.5 * priors.sum::<f64>()
    }

    fn likeliest(&self, parts: &[PlainPart]) -> DVector<f64> {
        let field = TakesField {
            parameters: &self.parameters,
            mean: &self.mean,
            parts,
        };
        // From a spread that is there: none may stay none.
        const SOME: f64 = 1e-2;
        let parameters = self.parameters.iter().zip(&self.variances);
        let start = parameters.map(|(of, variance)| match of.is_drawn {
            true => variance.max(SOME * SOME),
            false => 0.0,
        });
        field.likeliest(&DVector::from_iterator(self.parameters.len(), start))
    }

    /// Newton's step within the bounds; directions that are not determined stay. Bounds that the step meets hold it
    /// (Nocedal and Wright, *Numerical Optimization*, chapter 16).
    fn step(&self, total: &Total) -> Option<DVector<f64>> {
        let count = self.parameters.len();
        let held = self.held();
        let open = without(&held);
        let most = total.information.diagonal().amax().max(1.0);
        let information =
            &open * &total.information * &open + &held * held.transpose() * (HELD * most);
        let gradient = &open * &total.gradient;
        // Each bounded parameter moves to its bound, or is free.
        let mut fixed: Vec<Option<f64>> = self.at_bounds(&gradient);
        for _ in 0..=2 * count {
            let step = constrained(&information, &gradient, &fixed)?;
            let broken = self.parameters.iter().enumerate().filter_map(|(at, of)| {
                let [lower, upper] = of.bounds().map(|bound| bound - self.mean[at]);
                let beyond = (step[at] - upper).max(lower - step[at]);
                let to = if step[at] > upper { upper } else { lower };
                (fixed[at].is_none() && beyond > 1e-13).then_some((at, to, beyond))
            });
            match broken.max_by(|a, b| a.2.total_cmp(&b.2)) {
                Some((at, to, _)) => fixed[at] = Some(to),
                None => return Some(step),
            }
        }
        None
    }

    /// Parameters at a bound beyond which the objective falls: they stay there.
    fn at_bounds(&self, gradient: &DVector<f64>) -> Vec<Option<f64>> {
        let near = 1e-12;
        let each = self.parameters.iter().enumerate().map(|(at, of)| {
            let [lower, upper] = of.bounds().map(|bound| bound - self.mean[at]);
            let is_held =
                lower >= -near && gradient[at] > 0.0 || upper <= near && gradient[at] < 0.0;
            is_held.then_some(0.0)
        });
        each.collect()
    }

    /// Parameters that are at a bound of theirs.
    pub(super) fn bounded(&self) -> Vec<bool> {
        let near = 1e-9;
        let each = self.parameters.iter().zip(&self.mean).map(|(of, mean)| {
            let [lower, upper] = of.bounds();
            mean - lower <= near || upper - mean <= near
        });
        each.collect()
    }
}

/// The least of a quadratic model where some unknowns are given.
fn constrained(
    information: &DMatrix<f64>,
    gradient: &DVector<f64>,
    fixed: &[Option<f64>],
) -> Option<DVector<f64>> {
    let given = fixed.iter().map(|of| of.unwrap_or(0.0));
    let mut step = DVector::from_iterator(fixed.len(), given);
    let free: Vec<usize> = (0..fixed.len()).filter(|at| fixed[*at].is_none()).collect();
    if free.is_empty() {
        return Some(step);
    }
    let slope = gradient + information * &step;
    let inner = information.select_rows(&free).select_columns(&free);
    let solved = inner.cholesky()?.solve(&slope.select_rows(&free));
    for (at, by) in free.iter().zip(solved.iter()) {
        step[*at] = -by;
    }
    Some(step)
}

/// How much a take's own share tells of one parameter, with next to nothing known beforehand.
fn told(parameters: &[JointParameter], share: &TakeShare, at: usize) -> f64 {
    let mean = share.values.component_div(&lengths(parameters));
    let part = PlainPart::new(parameters, share, &mean);
    let variance = part.alone().map_or(1.0, |of| of[(at, at)]);
    (variance.max(1e-12).recip() - 1.0).max(1e-9)
}

/// The value with half of the weight on each side.
fn median(mut weighed: Vec<(f64, f64)>) -> Option<f64> {
    weighed.retain(|(value, _)| value.is_finite());
    weighed.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * weighed.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut below = 0.0;
    let mut least = weighed.iter().filter(|(_, weight)| {
        below += weight;
        below >= half
    });
    least.next().map(|(value, _)| *value)
}
