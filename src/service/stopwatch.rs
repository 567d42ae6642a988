//! Measures how long each phase of a run takes, ends one that takes too long and says on a terminal what goes on; the
//! core itself has no clock.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::deadline::Deadline;
use crate::motion::{Observer, Phase};

/// Runs that are over sooner show no progress.
const PATIENCE: Duration = Duration::from_secs(1);

/// Whether what goes on is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Progress {
    /// On stderr, if that is a terminal.
    Shown,
    /// Not here.
    Hidden,
}

/// Wall time by phase. Times of a phase that begins several times are added.
pub(super) struct Stopwatch {
    has_ended_it: bool,
    begun: Instant,
    current: Option<(Phase, Instant)>,
    phases: Vec<(Phase, Duration)>,
    progress: Progress,
    bar: Option<ProgressBar>,
    deadline: Deadline,
}

impl Stopwatch {
    /// Starts, and ends the run at the deadline.
    pub(super) fn start(deadline: Deadline, progress: Progress) -> Self {
        Self {
            has_ended_it: false,
            begun: Instant::now(),
            current: None,
            phases: Vec::new(),
            progress,
            bar: None,
            deadline,
        }
    }

    /// Whether the run was told to end because its time was over.
    pub(super) fn has_ended_it(&self) -> bool {
        self.has_ended_it
    }

    /// Seconds since the start, in all and by phase in the order in which phases first began.
    pub(super) fn stop(mut self) -> (f64, Vec<(Phase, f64)>) {
        let now = Instant::now();
        self.close(now);
        if let Some(progress) = self.bar.take() {
            progress.finish_and_clear();
        }
        let phases = self.phases.into_iter();
        (
            (now - self.begun).as_secs_f64(),
            phases
                .map(|(phase, spent)| (phase, spent.as_secs_f64()))
                .collect(),
        )
    }

    /// Shows the phase and the time since the start, once that is long.
    fn show(&mut self) {
        if self.progress == Progress::Hidden || self.begun.elapsed() < PATIENCE {
            return;
        }
        let begun = self.begun;
        let progress = self.bar.get_or_insert_with(|| {
            let style = ProgressStyle::with_template("{spinner} {elapsed} {wide_msg}");
            let bar = ProgressBar::new_spinner().with_elapsed(begun.elapsed());
            bar.enable_steady_tick(Duration::from_millis(100));
            match style {
                Ok(style) => bar.with_style(style),
                Err(error) => unreachable!("the template is constant: {error}"),
            }
        });
        if let Some((phase, _)) = self.current {
            progress.set_message(phase.as_str());
        }
    }

    fn close(&mut self, now: Instant) {
        let Some((phase, since)) = self.current.take() else {
            return;
        };
        let spent = now - since;
        match self.phases.iter_mut().find(|(known, _)| *known == phase) {
            Some((_, total)) => *total += spent,
            None => self.phases.push((phase, spent)),
        }
    }
}

impl Observer for Stopwatch {
    fn phase(&mut self, phase: Phase) {
        let now = Instant::now();
        self.close(now);
        if phase != Phase::Done {
            tracing::debug!(phase = phase.as_str(), "begins");
            self.current = Some((phase, now));
        }
        self.show();
    }

    fn should_stop(&mut self) -> bool {
        self.show();
        self.has_ended_it |= self.deadline.is_over();
        self.has_ended_it
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_are_listed_once_in_order_and_sum_to_no_more_than_the_whole() {
        let mut stopwatch = Stopwatch::start(Deadline::begin(None), Progress::Hidden);
        for phase in [Phase::Clean, Phase::Sweep, Phase::Clean, Phase::Done] {
            stopwatch.phase(phase);
        }
        let (whole_s, phases) = stopwatch.stop();
        let names: Vec<Phase> = phases.iter().map(|(phase, _)| *phase).collect();
        assert_eq!(names, [Phase::Clean, Phase::Sweep]);
        assert!(phases.iter().map(|(_, s)| s).sum::<f64>() <= whole_s);
    }

    #[test]
    fn the_run_is_stopped_at_the_deadline_alone() {
        let mut never = Stopwatch::start(Deadline::begin(None), Progress::Hidden);
        assert!(!never.should_stop() && !never.has_ended_it());
        let mut at_once = Stopwatch::start(Deadline::begin(Some(Duration::ZERO)), Progress::Hidden);
        assert!(!at_once.has_ended_it() && at_once.should_stop() && at_once.has_ended_it());
    }
}
