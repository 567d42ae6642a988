//! Goals of the time of an event, or of the interval between two: what is known of both is in unknowns of the whole motion,
//! their times and the log-paces.

use nalgebra::Vector3;

use super::event::StampedEvent;
use super::goal::TreeGoal;
use super::point::TreePoint;
use super::problem::TreeProblem;
use super::time_line::TimeLine;
use crate::optimise::block::{Block, BlockPattern};

/// A row of a goal that weighs: how far it is off, in deviations, with its derivatives by unknowns.
pub(super) struct WeighedRow {
    pub(super) off: f64,
    pub(super) by: Vec<(usize, f64)>,
}

impl TreeGoal {
    /// Whether it is of a time.
    pub(super) fn is_timed(&self) -> bool {
        self.condition.quantity.is_time()
    }

    fn stamped(&self) -> StampedEvent {
        StampedEvent {
            event: self.event,
            acted_s: self.acted_s,
        }
    }
}

impl TreeProblem {
    /// The pattern of the rows of a goal of a time.
    pub(super) fn timed_pattern(&self, goal: &TreeGoal) -> BlockPattern {
        BlockPattern::dense(goal.row_count(), self.timed_unknowns(goal))
    }

    fn timed_unknowns(&self, goal: &TreeGoal) -> Vec<usize> {
        let both = [Some(goal.stamped()), goal.since];
        let mut all = Vec::new();
        for of in both.into_iter().flatten() {
            match self.events.iter().position(|event| event.event == of.event) {
                Some(within) => all.push(self.unknown_of_event(within)),
                None => all.extend((0..self.pace_count()).map(|of| self.unknown_of_pace(of))),
            }
        }
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The time of an event \[s\], with its derivatives by unknowns.
    fn time_of(
        &self,
        point: &TreePoint,
        line: &TimeLine,
        of: &StampedEvent,
    ) -> (f64, Vec<(usize, f64)>) {
        match self.events.iter().position(|event| event.event == of.event) {
            Some(within) => {
                let unknown = self.unknown_of_event(within);
                (point.event_times_s[within], vec![(unknown, 1.0)])
            }
            None => (line.time_s(of.acted_s), line.moment(self, of.acted_s)),
        }
    }

    /// Fills the rows of the hard goals of times, and tells those of the others, which weigh.
    pub(super) fn fill_timed(
        &self,
        point: &TreePoint,
        patterns: &[BlockPattern],
        blocks: &mut [Block],
    ) -> Vec<WeighedRow> {
        let line = &point.time_line(self);
        let goals = self.goals.iter().enumerate();
        let mut weighed = Vec::new();
        for (index, goal) in goals.filter(|(_, goal)| goal.is_timed()) {
            let (mut time_s, mut by) = self.time_of(point, line, &goal.stamped());
            if let Some(since) = &goal.since {
                let (since_s, by_since) = self.time_of(point, line, since);
                time_s -= since_s;
                by.extend(by_since.into_iter().map(|(unknown, by)| (unknown, -by)));
            }
            let unknowns = self.timed_unknowns(goal);
            let by_unknown = unknowns.iter().map(|unknown| {
                let own = by.iter().filter(|(of, _)| of == unknown);
                (*unknown, own.map(|(_, by)| by).sum::<f64>())
            });
            let by_unknown: Vec<(usize, f64)> = by_unknown.collect();
            let (pattern, block) = (&patterns[index], &mut blocks[index]);
            block.reset(pattern);
            let rows = goal.rows(&Vector3::new(time_s, 0.0, 0.0));
            let scaled = |factor: f64| {
                let by = by_unknown
                    .iter()
                    .map(|(unknown, by)| (*unknown, by * factor));
                by.collect::<Vec<(usize, f64)>>()
            };
            match goal.condition.sd {
                Some(sd_s) => weighed.extend(rows.iter().map(|of| WeighedRow {
                    off: (of.value - of.value.clamp(of.bounds.0, of.bounds.1)) / sd_s,
                    by: scaled(of.by.x / sd_s),
                })),
                None => {
                    let unit = goal.unit();
                    for (row, of) in rows.iter().enumerate() {
                        block.values[row] = of.value / unit;
                        block.bounds[row] = (of.bounds.0 / unit, of.bounds.1 / unit);
                        let entries = block.derivatives_mut(pattern, row).iter_mut();
                        for (entry, (_, by)) in entries.zip(scaled(of.by.x / unit)) {
                            *entry = by;
                        }
                    }
                }
            }
        }
        weighed
    }
}
