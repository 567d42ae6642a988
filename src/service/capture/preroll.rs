//! What came in the last seconds while no take runs: a take begins with it.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use crate::ingest::live::Arrival;

/// Greatest number of samples and marks that are kept: eight trackers at 1 kHz for 30 s.
const KEPT: usize = 240_000;

/// The last samples and marks.
#[derive(Debug)]
pub(super) struct Preroll {
    span: Duration,
    kept: VecDeque<Arrival>,
}

impl Preroll {
    /// Keeps what comes within that span; nothing where it is zero.
    pub(super) fn new(span: Duration) -> Self {
        Self {
            span,
            kept: VecDeque::new(),
        }
    }

    /// Keeps a sample or a mark.
    pub(super) fn keep(&mut self, arrival: Arrival) {
        if self.span.is_zero() {
            return;
        }
        self.forget(arrival.at);
        if self.kept.len() == KEPT {
            self.kept.pop_front();
        }
        self.kept.push_back(arrival);
    }

    /// Hands over what is kept, in order.
    pub(super) fn take(&mut self, now: Instant) -> VecDeque<Arrival> {
        self.forget(now);
        std::mem::take(&mut self.kept)
    }

    fn forget(&mut self, now: Instant) {
        let is_old = |first: &Arrival| now.saturating_duration_since(first.at) > self.span;
        while self.kept.front().is_some_and(is_old) {
            self.kept.pop_front();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ingest::live::{Arrived, MarkRecord, NO_TIME};

    fn mark(at: Instant) -> Arrival {
        let record = MarkRecord {
            sequence: 0,
            available_ns: 0,
            sample_ns: NO_TIME,
            device_ns: NO_TIME,
            event: [0; 256],
            flags: 0,
            session: 0,
        };
        Arrival {
            at,
            what: Arrived::Mark(record),
        }
    }

    #[test]
    fn the_last_seconds_are_kept_and_no_more_than_there_is_room_for() {
        let begun = Instant::now();
        let mut preroll = Preroll::new(Duration::from_secs(2));
        for k in 0..50 {
            preroll.keep(mark(begun + Duration::from_millis(100 * k)));
        }
        let now = begun + Duration::from_millis(4900);
        let kept = preroll.take(now);
        assert_eq!(kept.len(), 21);
        assert!(kept.iter().is_sorted_by_key(|arrival| arrival.at));
        assert!(preroll.take(now).is_empty());
        for _ in 0..KEPT + 10 {
            preroll.keep(mark(now));
        }
        assert_eq!(preroll.take(now).len(), KEPT);
        let mut none = Preroll::new(Duration::ZERO);
        none.keep(mark(now));
        assert!(none.take(now).is_empty());
    }
}
