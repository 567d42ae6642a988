//! What one estimate costs, phase by phase.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use enact::motion::{Observer, Phase};
use serde::Serialize;

use crate::statistics::median;
use enact_tools::case::Case;

/// Phases told apart.
pub const PHASES: [Phase; 7] = [
    Phase::Clean,
    Phase::Marks,
    Phase::ArcFits,
    Phase::Sweep,
    Phase::Multipliers,
    Phase::Finish,
    Phase::Covariance,
];
/// Phases that iterate.
const SOLVER: [Phase; 3] = [Phase::Sweep, Phase::Multipliers, Phase::Finish];
/// Longer runs are not repeated \[s\].
const LONG_S: f64 = 20.0;

/// Adds up the time between announcements, phase by phase.
#[derive(Default)]
struct Stopwatch {
    running: Option<(Phase, Instant)>,
    spent: BTreeMap<Phase, Duration>,
}

impl Stopwatch {
    /// Time spent in a phase so far \[s\].
    fn spent_s(&self, phase: Phase) -> f64 {
        self.spent.get(&phase).map_or(0.0, Duration::as_secs_f64)
    }

    /// Of all phases together \[s\].
    fn total_s(&self) -> f64 {
        self.spent.values().map(Duration::as_secs_f64).sum()
    }
}

impl Observer for Stopwatch {
    fn phase(&mut self, phase: Phase) {
        let now = Instant::now();
        if let Some((last, since)) = self.running.replace((phase, now)) {
            *self.spent.entry(last).or_default() += now - since;
        }
    }
}

/// One estimate, several times.
#[derive(Serialize)]
pub struct Size {
    pub samples: usize,
    pub flights: usize,
    pub verdict: &'static str,
    pub reason: String,
    pub iterations: usize,
    /// Of sweep, multiplier rounds and finish, per iteration \[s\].
    pub per_iteration_s: f64,
    /// Of sweep, multiplier rounds and finish \[s\].
    pub solver_s: f64,
    /// Of everything, the median and the fastest run \[s\].
    pub total_s: f64,
    pub fastest_s: f64,
    /// Medians of [`PHASES`] \[s\].
    pub phases_s: [f64; 7],
}

impl Size {
    /// Medians of several runs; none where there is nothing to estimate from.
    pub fn of(case: &Case, runs: usize) -> Option<Self> {
        let mut watches: Vec<Stopwatch> = Vec::new();
        let mut last = None;
        for _ in 0..runs {
            let mut stopwatch = Stopwatch::default();
            match case.estimated(&mut stopwatch) {
                Ok(outcome) => last = Some(outcome),
                Err(error) => {
                    eprintln!("  {error}");
                    return None;
                }
            }
            watches.push(stopwatch);
            if watches.last().is_some_and(|watch| watch.total_s() > LONG_S) {
                break;
            }
        }
        let outcome = last?;
        let of = |value: &dyn Fn(&Stopwatch) -> f64| {
            median(&watches.iter().map(value).collect::<Vec<f64>>())
        };
        let solver_s = of(&|w| SOLVER.iter().map(|phase| w.spent_s(*phase)).sum());
        let estimate = &outcome.estimate;
        let iterations = estimate.counters.iterations;
        Some(Self {
            samples: outcome.counts.used,
            flights: estimate.arcs.len(),
            verdict: estimate.verdict.as_str(),
            reason: enact::report::reason_text(&outcome.scene, &estimate.reason),
            iterations,
            per_iteration_s: solver_s / iterations.max(1) as f64,
            solver_s,
            total_s: of(&Stopwatch::total_s),
            fastest_s: watches
                .iter()
                .map(Stopwatch::total_s)
                .fold(f64::INFINITY, f64::min),
            phases_s: PHASES.map(|phase| of(&|w| w.spent_s(phase))),
        })
    }
}
