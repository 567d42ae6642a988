//! Ends a run at its deadline, and where Python has a signal.

use std::time::{Duration, Instant};

use enact::motion::{Observer, Phase};
use pyo3::prelude::*;

/// So often it is looked for signals.
const BETWEEN: Duration = Duration::from_millis(20);

/// A deadline in seconds; more than a clock counts is none.
pub fn limit(deadline_s: Option<f64>) -> Option<Duration> {
    deadline_s.and_then(|limit_s| Duration::try_from_secs_f64(limit_s).ok())
}

/// The observer of a run that has let go of the interpreter.
pub struct Watch {
    deadline: Option<Instant>,
    looked: Instant,
    /// Whether the deadline ended it.
    pub is_late: bool,
    /// What a signal raised: `KeyboardInterrupt`.
    pub raised: Option<PyErr>,
    /// What goes on, since when.
    phase: (Phase, Instant),
    /// How long each phase took in all, in the order in which they first began.
    pub spent: Vec<(Phase, Duration)>,
}

impl Watch {
    /// Its time begins now.
    pub fn begin(limit: Option<Duration>) -> Self {
        let now = Instant::now();
        Self {
            deadline: limit.and_then(|limit| now.checked_add(limit)),
            looked: now,
            is_late: false,
            raised: None,
            phase: (Phase::Done, now),
            spent: Vec::new(),
        }
    }
}

impl Observer for Watch {
    fn phase(&mut self, phase: Phase) {
        let now = Instant::now();
        let (last, since) = std::mem::replace(&mut self.phase, (phase, now));
        if last == Phase::Done {
            return;
        }
        match self.spent.iter_mut().find(|(of, _)| *of == last) {
            Some((_, all)) => *all += now - since,
            None => self.spent.push((last, now - since)),
        }
    }

    fn should_stop(&mut self) -> bool {
        let now = Instant::now();
        self.is_late |= self.deadline.is_some_and(|deadline| now >= deadline);
        if self.raised.is_none() && now - self.looked >= BETWEEN {
            // In other threads than the first there are none.
            self.raised = Python::attach(|py| py.check_signals()).err();
            self.looked = Instant::now();
        }
        self.is_late || self.raised.is_some()
    }
}
