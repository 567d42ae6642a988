//! Ends a run at its deadline, and where Python has a signal.

use std::time::{Duration, Instant};

use enact::motion::Observer;
use pyo3::prelude::*;

/// So often it is looked for signals.
const BETWEEN: Duration = Duration::from_millis(20);

/// The observer of a run that has let go of the interpreter.
pub struct Watch {
    deadline: Option<Instant>,
    looked: Instant,
    /// Whether the deadline ended it.
    pub is_late: bool,
    /// What a signal raised: `KeyboardInterrupt`.
    pub raised: Option<PyErr>,
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
        }
    }
}

impl Observer for Watch {
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
