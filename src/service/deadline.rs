//! How long a job may take.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::bail;

/// How much longer a job may take that has heard of the end of its time: to write the best so far.
pub fn leeway(limit: Duration) -> Duration {
    Duration::from_secs(1).saturating_add(limit / 4)
}

/// The end of the time that a job was given, if it was.
#[derive(Clone, Copy, Debug)]
pub(super) struct Deadline {
    limit: Option<Duration>,
    begun: Instant,
    /// Set from outside when it is over.
    told: Option<&'static AtomicBool>,
}

impl Deadline {
    /// The time begins now.
    pub(super) fn begin(limit: Option<Duration>) -> Self {
        Self {
            limit,
            begun: Instant::now(),
            told: None,
        }
    }

    /// The same, but over once the job is told to end, too.
    pub(super) fn or_told(self, told: &'static AtomicBool) -> Self {
        Self {
            told: Some(told),
            ..self
        }
    }

    /// Whether the job was told to end from outside.
    pub(super) fn is_told(&self) -> bool {
        self.told.is_some_and(|told| told.load(Ordering::Relaxed))
    }

    /// The same, but so much earlier as writing will take: about as long as reading took, and a third of all at most.
    pub(super) fn with_time_to_write(self) -> Self {
        let spent = self.begun.elapsed();
        let reserved = |limit: Duration| limit.saturating_sub(spent.min(limit / 3));
        Self {
            limit: self.limit.map(reserved),
            ..self
        }
    }

    /// When it is over; `None` if never.
    pub(super) fn instant(&self) -> Option<Instant> {
        self.begun.checked_add(self.limit?)
    }

    /// How long it is \[s\].
    pub(super) fn limit_s(&self) -> Option<f64> {
        self.limit.map(|limit| limit.as_secs_f64())
    }

    /// How long the job has taken so far.
    pub(super) fn elapsed(&self) -> Duration {
        self.begun.elapsed()
    }

    /// Whether it is over.
    pub(super) fn is_over(&self) -> bool {
        let is_late = |limit| self.begun.elapsed() >= limit;
        self.limit.is_some_and(is_late) || self.is_told()
    }

    /// Fails where it is over before all of a recording was read.
    pub(super) fn check(&self, path: &Path) -> anyhow::Result<()> {
        if self.is_told() {
            bail!("{}: told to end before it was estimated", path.display());
        }
        if self.is_over() {
            bail!(
                "{}: the deadline of {} was over before all of it was read; nothing was \
                 written, give it more by --deadline",
                path.display(),
                self.words()
            );
        }
        Ok(())
    }

    /// How long it is.
    pub(super) fn words(&self) -> String {
        humantime::format_duration(self.limit.unwrap_or_default()).to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_limit_it_is_never_over_and_with_none_left_at_once() {
        let path = Path::new("a.mcap");
        let none = Deadline::begin(None);
        assert!(!none.is_over() && none.instant().is_none() && none.check(path).is_ok());
        let over = Deadline::begin(Some(Duration::ZERO));
        assert!(over.is_over() && over.instant().is_some_and(|at| at <= Instant::now()));
        let error = over.check(path).expect_err("over").to_string();
        assert!(error.starts_with("a.mcap: the deadline of 0s"), "{error}");
        // A limit longer than the clock counts is none.
        assert!(!Deadline::begin(Some(Duration::MAX)).is_over());
    }
}
