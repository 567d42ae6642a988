//! Measures how long each phase of a run takes, ends one that takes too long and passes on what goes on; the core itself
//! has no clock.

use std::time::{Duration, Instant};

use super::deadline::Deadline;
use super::working::Working;
use crate::motion::{Observer, Phase};

/// Wall time by phase. Times of a phase that begins several times are added.
pub(super) struct Stopwatch<'a> {
    has_ended_it: bool,
    begun: Instant,
    current: Option<(Phase, Instant)>,
    phases: Vec<(Phase, Duration)>,
    working: &'a Working,
    deadline: Deadline,
}

impl<'a> Stopwatch<'a> {
    /// Starts, and ends the run at the deadline.
    pub(super) fn start(deadline: Deadline, working: &'a Working) -> Self {
        Self {
            has_ended_it: false,
            begun: Instant::now(),
            current: None,
            phases: Vec::new(),
            working,
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
        let phases = self.phases.into_iter();
        (
            (now - self.begun).as_secs_f64(),
            phases
                .map(|(phase, spent)| (phase, spent.as_secs_f64()))
                .collect(),
        )
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

impl Observer for Stopwatch<'_> {
    fn phase(&mut self, phase: Phase) {
        let now = Instant::now();
        self.close(now);
        if phase != Phase::Done {
            tracing::debug!(phase = phase.as_str(), "begins");
            self.working.now(phase.as_str().replace('_', " "));
            self.current = Some((phase, now));
        }
    }

    fn should_stop(&mut self) -> bool {
        self.has_ended_it |= self.deadline.is_over();
        self.has_ended_it
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_are_listed_once_in_order_and_sum_to_no_more_than_the_whole() {
        let hidden = Working::hidden();
        let mut stopwatch = Stopwatch::start(Deadline::begin(None), &hidden);
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
        let hidden = Working::hidden();
        let mut never = Stopwatch::start(Deadline::begin(None), &hidden);
        assert!(!never.should_stop() && !never.has_ended_it());
        let mut at_once = Stopwatch::start(Deadline::begin(Some(Duration::ZERO)), &hidden);
        assert!(!at_once.has_ended_it() && at_once.should_stop() && at_once.has_ended_it());
    }
}
