//! Measures how long each phase of a run takes, ends one that takes too long and says on a terminal what goes on; the
//! core itself has no clock.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::motion::{Observer, Phase};

/// Runs that are over sooner show no progress.
const PATIENCE: Duration = Duration::from_secs(1);

/// How a run is watched.
#[derive(Clone, Copy, Debug, Default)]
pub struct Watching {
    /// It ends after so long with the best that it has by then.
    pub deadline: Option<Duration>,
    /// Whether what goes on is shown on stderr, if that is a terminal.
    pub shows_progress: bool,
}

/// Wall time by phase. Times of a phase that begins several times are added.
pub(super) struct Stopwatch {
    watching: Watching,
    has_ended_it: bool,
    begun: Instant,
    current: Option<(Phase, Instant)>,
    phases: Vec<(Phase, Duration)>,
    progress: Option<ProgressBar>,
}

impl Stopwatch {
    pub(super) fn start(watching: Watching) -> Self {
        Self {
            watching,
            has_ended_it: false,
            begun: Instant::now(),
            current: None,
            phases: Vec::new(),
            progress: None,
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
        if let Some(progress) = self.progress.take() {
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
        if !self.watching.shows_progress || self.begun.elapsed() < PATIENCE {
            return;
        }
        let begun = self.begun;
        let progress = self.progress.get_or_insert_with(|| {
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
        let deadline = self.watching.deadline;
        let is_over = deadline.is_some_and(|deadline| self.begun.elapsed() >= deadline);
        self.has_ended_it |= is_over;
        is_over
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_are_listed_once_in_order_and_sum_to_no_more_than_the_whole() {
        let mut stopwatch = Stopwatch::start(Watching::default());
        for phase in [Phase::Clean, Phase::Sweep, Phase::Clean, Phase::Done] {
            stopwatch.phase(phase);
        }
        let (whole_s, phases) = stopwatch.stop();
        let names: Vec<Phase> = phases.iter().map(|(phase, _)| *phase).collect();
        assert_eq!(names, [Phase::Clean, Phase::Sweep]);
        assert!(phases.iter().map(|(_, s)| s).sum::<f64>() <= whole_s);
    }
}
