//! A motion whose samples err in time: solved again with the errors that are expected of a hand, then with those that its
//! residuals make likely.

use std::collections::BTreeMap;

use super::adequacy::linearised::Linearised;
use super::modes::walked;
use super::optimum::{Solved, finished};
use super::point::TreePoint;
use super::problem::TreeProblem;
use crate::estimate::wander::kink::{APART_S, kink_s};
use crate::estimate::wander::likelihood::LikelyErrors;
use crate::estimate::wander::process;
use crate::motion::{Observer, TrackIndex, TreeTouch};
use crate::optimise::Schedule;
use crate::optimise::finish::Tolerances;

/// How often errors are told from residuals.
const ROUNDS: usize = 3;
/// Greatest number of steps to an optimum near by: of a motion that is hardly determined they could go on for long.
const STEPS: usize = 12;
/// Errors are told well where no logarithm of their sizes and times changes by more.
const SAME: f64 = 0.05;

impl Solved {
    /// Goes on to the motion with the likeliest errors of a hand, from that at which each sample errs by itself: where a direction
    /// is weak, to the lowest optimum along it. This one stays where it is no optimum, and where that leads to none.
    pub fn refine(&mut self, observer: &mut dyn Observer) {
        if !self.solution.finished.converged {
            return;
        }
        let Some(near) = self.erring(LikelyErrors::EXPECTED, observer) else {
            return;
        };
        let mut work = near.solution.work;
        let near = near.likeliest(observer);
        let cost = near.cost();
        let lowest = walked(near, &mut work, observer);
        *self = match lowest.cost() < cost {
            true => lowest.likeliest(observer),
            false => lowest,
        };
    }

    /// The optimum near by with the errors that its residuals make likeliest, of one that has some.
    fn likeliest(mut self, observer: &mut dyn Observer) -> Self {
        for _ in 0..ROUNDS {
            let Some(errors) = self.problem.errors.filter(|_| !observer.should_stop()) else {
                break;
            };
            let linearised = Linearised::new(&self.problem, &self.solution);
            let Some(likely) = linearised.and_then(|of| of.fitted(&errors)) else {
                break;
            };
            let is_same = process::change(&errors.processes, &likely.errors.processes) < SAME;
            let again = (!is_same).then(|| self.erring(likely.errors, observer));
            let Some(again) = again.flatten() else {
                break;
            };
            self = again;
        }
        self
    }

    /// Whether the motion shows that a hand acted it: in an unknown tempo, and by residuals that noise does not explain.
    pub fn shows_hand(&self) -> bool {
        let linearised = || Linearised::new(&self.problem, &self.solution);
        self.problem.tempo.is_some() || linearised().is_some_and(|of| of.shows_hand())
    }

    /// The optimum near by with such errors; `None` where there is none.
    fn erring(&self, errors: LikelyErrors, observer: &mut dyn Observer) -> Option<Self> {
        let point = &self.solution.point;
        let problem = self.problem.erring(errors, point);
        let near_by = Schedule {
            tolerances: Tolerances {
                steps: STEPS,
                ..Tolerances::default()
            },
            ..Schedule::default().from_the_last()
        };
        let mut work = self.solution.work;
        let near = finished(&problem, point, &near_by, &mut work, observer);
        near.solution.finished.converged.then_some(near)
    }
}

impl TreeProblem {
    /// The same problem where samples err in time, with events at these times of a point \[s\]; those near impacts of what is
    /// struck are left out. What else is known counts once, beside samples that count as often as they tell something.
    fn erring(&self, errors: LikelyErrors, at: &TreePoint) -> Self {
        let mut problem = self.clone();
        let line = at.time_line(self);
        let mut last_s: BTreeMap<(TrackIndex, usize), f64> = BTreeMap::new();
        for sample in &mut problem.samples {
            let time_s = line.time_s(sample.acted_s);
            let [from_s, to_s] = self.counted_s(sample.place, time_s, at);
            let last_s = last_s.entry((sample.track, sample.kind()));
            let last_s = last_s.or_insert(f64::NEG_INFINITY);
            let is_next = sample.acted_s >= *last_s + APART_S;
            sample.whitening = None;
            sample.is_counted = is_next && (from_s..=to_s).contains(&time_s);
            if sample.is_counted {
                *last_s = sample.acted_s;
            }
        }
        for event in &mut problem.events {
            event.mark.iter_mut().for_each(|mark| mark.counted = 1.0);
        }
        problem.tempo.iter_mut().for_each(|of| of.counted = 1.0);
        Self {
            errors: Some(errors),
            ..problem
        }
    }

    /// Between which physical times about one samples of a link count \[s\]: from a while after the impact before to a while
    /// before the next one.
    fn counted_s(&self, place: usize, time_s: f64, at: &TreePoint) -> [f64; 2] {
        let (tree, _) = self.forest.tree_of(place);
        let is_struck = |touch: &TreeTouch| {
            let mut places = touch.at.places();
            places.any(|of| self.forest.tree_of(of).0 == tree)
        };
        let events = self.events.iter().zip(&at.event_times_s);
        let impacts = events.filter(|(of, _)| of.touch.as_ref().is_some_and(is_struck));
        let impacts_s = || impacts.clone().map(|(_, impact_s)| *impact_s);
        let before_s = impacts_s().filter(|impact_s| *impact_s <= time_s);
        let before_s = before_s.reduce(f64::max);
        let after_s = impacts_s().filter(|impact_s| *impact_s > time_s);
        let after_s = after_s.reduce(f64::min);
        let [begin_s, end_s] = at.time_line(self).physical_span_s();
        let kink_s = kink_s(after_s.unwrap_or(end_s) - before_s.unwrap_or(begin_s));
        [
            before_s.map_or(f64::NEG_INFINITY, |before_s| before_s + kink_s),
            after_s.map_or(f64::INFINITY, |after_s| after_s - kink_s),
        ]
    }
}
