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
    begun: Instant,
    looked: Instant,
    /// After which time the deadline, or whoever is told, ended it.
    pub ended_after: Option<Duration>,
    /// What a signal raised, `KeyboardInterrupt`, or whoever is told.
    pub raised: Option<PyErr>,
    /// Who is told the phase now and then, and says whether to stop.
    told: Option<Py<PyAny>>,
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
            begun: now,
            looked: now,
            ended_after: None,
            raised: None,
            told: None,
            phase: (Phase::Done, now),
            spent: Vec::new(),
        }
    }
}

impl Watch {
    /// The same that tells somebody.
    pub fn telling(self, told: Option<Py<PyAny>>) -> Self {
        Self { told, ..self }
    }

    fn end(&mut self, now: Instant) {
        self.ended_after.get_or_insert(now - self.begun);
    }

    /// Tells the phase; whether that is to stop the run.
    fn tell(&self) -> PyResult<bool> {
        Python::attach(|py| {
            // In other threads than the first there are none.
            py.check_signals()?;
            match &self.told {
                Some(told) => told.call1(py, (self.phase.0.as_str(),))?.is_truthy(py),
                None => Ok(false),
            }
        })
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
        if self.deadline.is_some_and(|deadline| now >= deadline) {
            self.end(now);
        }
        if self.raised.is_none() && now - self.looked >= BETWEEN {
            match self.tell() {
                Ok(is_stopped) => {
                    if is_stopped {
                        self.end(now);
                    }
                }
                Err(raised) => self.raised = Some(raised),
            }
            self.looked = Instant::now();
        }
        self.ended_after.is_some() || self.raised.is_some()
    }
}
