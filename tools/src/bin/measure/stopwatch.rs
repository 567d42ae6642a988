//! How long each phase of a run takes.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use enact::motion::{Observer, Phase};

/// Adds up the time between announcements, phase by phase.
#[derive(Default)]
pub struct Stopwatch {
    running: Option<(Phase, Instant)>,
    spent: BTreeMap<Phase, Duration>,
}

impl Stopwatch {
    /// Time spent in a phase so far \[s\].
    pub fn spent_s(&self, phase: Phase) -> f64 {
        self.spent.get(&phase).map_or(0.0, Duration::as_secs_f64)
    }

    /// Of all phases together \[s\].
    pub fn total_s(&self) -> f64 {
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
