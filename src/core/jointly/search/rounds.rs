//! Rounds: where each take is asked next, from what all of them said.

use nalgebra::DVector;

use super::super::part::PlainPart;
use super::super::spread::TakesField;
use super::super::step::BoundedStep;
use super::{BestSoFar, JointSearch, SearchTurn};
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

impl JointSearch {
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
        let objective = self.field(&parts).objective(&self.variances);
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
        let bounded = BoundedStep {
            parameters: &self.parameters,
            mean: &self.mean,
            held: &self.held(),
        };
        let Some(step) = bounded.newton(&total) else {
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

    fn field<'a>(&'a self, parts: &'a [PlainPart]) -> TakesField<'a> {
        TakesField {
            parameters: &self.parameters,
            mean: &self.mean,
            parts,
        }
    }

    fn likeliest(&self, parts: &[PlainPart]) -> DVector<f64> {
        // From a spread that is there: none may stay none.
        const SOME: f64 = 1e-2;
        let parameters = self.parameters.iter().zip(&self.variances);
        let start = parameters.map(|(of, variance)| match of.is_drawn {
            true => variance.max(SOME * SOME),
            false => 0.0,
        });
        let start = DVector::from_iterator(self.parameters.len(), start);
        self.field(parts).likeliest(&start)
    }
}
