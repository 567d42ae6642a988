//! What came in the last seconds while no take runs: a take begins with it.

use std::collections::{BTreeMap, VecDeque};
use std::time::{Duration, Instant};

use crate::ingest::live::{Arrival, Arrived, Before};

/// Greatest number of samples and marks that are kept: eight trackers at 1 kHz for 30 s.
const KEPT: usize = 240_000;

/// The last samples and marks.
#[derive(Debug)]
pub(super) struct Preroll {
    span: Duration,
    kept: VecDeque<Arrival>,
    /// The last sample of each stream that is not kept.
    before: BTreeMap<usize, Before>,
}

impl Preroll {
    /// Keeps what comes within that span; nothing where it is zero.
    pub(super) fn new(span: Duration) -> Self {
        Self {
            span,
            kept: VecDeque::new(),
            before: BTreeMap::new(),
        }
    }

    /// Keeps a sample or a mark.
    pub(super) fn keep(&mut self, arrival: Arrival) {
        if self.span.is_zero() {
            return self.pass(&arrival);
        }
        self.forget(arrival.at);
        if self.kept.len() == KEPT {
            self.forget_first();
        }
        self.kept.push_back(arrival);
    }

    /// Notes what is not kept: it is in a take, or nobody wants it.
    pub(super) fn pass(&mut self, arrival: &Arrival) {
        if let Arrived::Pose { stream, record, .. } = &arrival.what {
            self.before.insert(*stream, Before::of(record));
        }
    }

    /// Hands over what is kept, in order.
    pub(super) fn take(&mut self, now: Instant) -> VecDeque<Arrival> {
        self.forget(now);
        std::mem::take(&mut self.kept)
    }

    /// The last sample of a stream before what is kept and what comes: after it, holes are counted.
    pub(super) fn before(&self, stream: usize) -> Option<Before> {
        self.before.get(&stream).copied()
    }

    /// Forgets what is too old by then.
    pub(super) fn forget(&mut self, now: Instant) {
        let span = self.span;
        let is_old = |first: &Arrival| now.saturating_duration_since(first.at) > span;
        while self.kept.front().is_some_and(is_old) {
            self.forget_first();
        }
    }

    fn forget_first(&mut self) {
        if let Some(first) = self.kept.pop_front() {
            self.pass(&first);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ingest::live::{MarkRecord, NO_TIME, PoseRecord};

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

    fn pose(at: Instant, sequence: u64) -> Arrival {
        let what = Arrived::Pose {
            stream: 1,
            record: PoseRecord::numbered(sequence),
            is_overflow: false,
        };
        Arrival { at, what }
    }

    #[test]
    fn the_last_sample_that_is_not_kept_is_known() {
        let begun = Instant::now();
        let of = |sequence| match pose(begun, sequence).what {
            Arrived::Pose { record, .. } => Some(Before::of(&record)),
            _ => None,
        };
        let mut preroll = Preroll::new(Duration::from_secs(2));
        assert_eq!(preroll.before(1), None);
        for k in 0..50 {
            preroll.keep(pose(begun + Duration::from_millis(100 * k), k));
        }
        let kept = preroll.take(begun + Duration::from_millis(4900));
        assert_eq!((kept.len(), preroll.before(1)), (21, of(28)));
        preroll.pass(&pose(begun, 60));
        assert_eq!((preroll.before(1), preroll.before(0)), (of(60), None));
        let mut none = Preroll::new(Duration::ZERO);
        none.keep(pose(begun, 3));
        assert_eq!(none.before(1), of(3));
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
