//! Errors of one setting beside the least that any unbiased estimate can have.

use std::ops::Range;

use enact::motion::Verdict;
use nalgebra::DMatrix;
use serde::Serialize;

use super::rms_by_kind;
use super::sweep::Setting;
use crate::figure::Mark;
use crate::statistics::{INTERVALS, rms};
use enact_tools::case::{Case, Posed};
use enact_tools::dense::{self, Uncertainty};

/// What became of a setting.
#[derive(Serialize)]
pub struct Level {
    /// Across.
    pub x: f64,
    /// Performances.
    pub seeds: usize,
    /// Estimates that converged to a physical motion.
    pub estimated: usize,
    /// Samples used, of the last.
    samples: usize,
    /// Rms error and bound of the first event's time \[s\].
    pub event_s: [f64; 2],
    /// Rms errors of each kind of unknown, and their bounds.
    pub errors: [f64; 5],
    pub bounds: [f64; 5],
    /// Of all event times: how many there are, how many have no standard deviation, how many lie
    /// within each interval.
    pub events: usize,
    without_sd: usize,
    pub covered: [usize; 3],
}

/// Errors and bounds of every performance.
#[derive(Default)]
struct All {
    event: [Vec<f64>; 2],
    errors: [Vec<f64>; 5],
    bounds: [Vec<f64>; 5],
}

impl Level {
    /// All performances of a setting.
    pub fn of(setting: &Setting, seeds: Range<u64>) -> Self {
        let mut level = Self {
            x: setting.x,
            seeds: seeds.clone().count(),
            estimated: 0,
            samples: 0,
            event_s: [f64::NAN; 2],
            errors: [f64::NAN; 5],
            bounds: [f64::NAN; 5],
            events: 0,
            without_sd: 0,
            covered: [0; 3],
        };
        let mut all = All::default();
        for seed in seeds {
            level.add(&setting.case(seed), &mut all);
        }
        level.event_s = all.event.map(|values| rms(&values));
        level.errors = all.errors.map(|values| rms(&values));
        level.bounds = all.bounds.map(|values| rms(&values));
        level
    }

    fn add(&mut self, case: &Case, all: &mut All) {
        let Ok(outcome) = case.estimated(&mut ()) else {
            return;
        };
        let estimate = &outcome.estimate;
        if estimate.verdict != Verdict::Physical {
            return;
        }
        self.estimated += 1;
        self.samples = outcome.counts.used;
        let posed = Posed::new(case.scene(), &outcome.sketch);
        let offset_s = case.offset_s(&posed, &outcome.sketch);
        for event in &estimate.events {
            if !posed.problem.event_is_free[event.event] {
                continue;
            }
            let true_s = case.performance.truth.event_times_s[event.event] + offset_s;
            let error_s = (event.time_s - true_s).abs();
            self.events += 1;
            self.without_sd += usize::from(event.sd_s.is_none());
            for (covered, (_, width)) in self.covered.iter_mut().zip(INTERVALS) {
                let holds = event.sd_s.is_some_and(|sd_s| error_s <= width * sd_s);
                *covered += usize::from(holds);
            }
        }
        let bound = dense::bound(case, &posed, &outcome.sketch);
        let uncertainty = Uncertainty::of(case, &posed, offset_s);
        if let (Some(bound), Some(uncertainty)) = (bound, uncertainty) {
            all.add(&posed, &bound, &uncertainty);
        }
    }

    /// A point with the spread of an rms of that many normal errors, 95 %.
    pub fn mark(&self, y: f64) -> Mark {
        let share = INTERVALS[2].1 / (2.0 * self.estimated as f64).sqrt();
        let all = self.estimated == self.seeds;
        Mark {
            spread: Some([y * (1.0 - share).max(0.0), y * (1.0 + share)]),
            failed: 2 * self.estimated < self.seeds,
            setting: (!all).then(|| format!("{} of {}", self.estimated, self.seeds)),
            ..Mark::at(self.x, y)
        }
    }
}

impl All {
    fn add(&mut self, posed: &Posed, bound: &DMatrix<f64>, uncertainty: &Uncertainty) {
        let sd = |at: usize| bound[(at, at)].max(0.0).sqrt();
        if let Some(at) = posed.layout.events[0] {
            self.event[0].push(uncertainty.error[at]);
            self.event[1].push(sd(at));
        }
        let errors = rms_by_kind(posed, |at| uncertainty.error[at]);
        let bounds = rms_by_kind(posed, sd);
        for kind in 0..5 {
            self.errors[kind].push(errors[kind]);
            self.bounds[kind].push(bounds[kind]);
        }
    }
}
