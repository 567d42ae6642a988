//! One tracker's samples, counted and stamped.

use super::sequence_counts::{Before, Fate, SequenceCounts, TallyCounts};
use crate::ingest::clock::{ClockQuality, StampReading, StreamClock};
use crate::motion::{PoseSample, Stamp, StampSource};
use crate::wire::live::payload::{self, MarkRecord, PoseRecord};

/// Stamps that a message can hold: from 1970 to 2106. Zero stands for no stamp.
const STAMPS: std::ops::Range<i64> = 1..(1 << 32) * 1_000_000_000;

/// One tracker's stream on its way into a take.
#[derive(Clone, Debug)]
pub struct Stream {
    clock: StreamClock,
    tally: SequenceCounts,
}

/// The result of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Streamed {
    /// A pose for the take; its numbers are as sent, possibly not finite.
    Sample(PoseSample),
    /// No pose: not valid, a duplicate, or with a stamp that no message can hold. It is counted.
    Refused,
}

impl Stream {
    /// Stamps by the given source; without one, the first valid sample decides.
    pub fn new(source: Option<StampSource>) -> Self {
        Self::after(None, source)
    }

    /// The same, where that sample came before the first: a hole between them is counted.
    pub fn after(before: Option<Before>, source: Option<StampSource>) -> Self {
        Self {
            clock: StreamClock::new(source),
            tally: SequenceCounts::after(before),
        }
    }

    /// Counts and stamps a sample that arrived at `receipt_ns` on this machine's clock.
    pub fn take(&mut self, record: &PoseRecord, receipt_ns: i64, is_overflow: bool) -> Streamed {
        if self.tally.count(record, is_overflow) != Fate::Used {
            return Streamed::Refused;
        }
        let stamp = self.clock.stamp(&StampReading {
            session: record.session,
            sequence: record.sequence,
            sample_ns: payload::time(record.sample_ns),
            device_ns: payload::time(record.device_ns),
            receipt_ns,
        });
        if !STAMPS.contains(&stamp.0) {
            self.tally.unstampable();
            return Streamed::Refused;
        }
        Streamed::Sample(record.pose(stamp))
    }

    /// The counts so far.
    pub fn counts(&self) -> TallyCounts {
        self.tally.counts()
    }

    /// How good the stamps are so far.
    pub fn quality(&self) -> ClockQuality {
        self.clock.quality()
    }
}

/// The stamp of a mark: the publisher's own time on the clock of the samples, else its arrival;
/// `None` where no message can hold it.
pub fn stamp_mark(record: &MarkRecord, receipt_ns: i64) -> Option<Stamp> {
    let stamp_ns = payload::time(record.sample_ns).unwrap_or(receipt_ns);
    STAMPS.contains(&stamp_ns).then_some(Stamp(stamp_ns))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::live::NO_TIME;

    #[test]
    fn garbage_is_refused_and_counted_and_never_breaks_anything() {
        let mut stream = Stream::new(None);
        let numbers = [f64::NAN, f64::INFINITY, f64::MAX, -0.0, 1.0];
        let times = [
            i64::MIN,
            i64::MIN + 1,
            -1,
            0,
            1_700_000_000_000_000_000,
            i64::MAX,
        ];
        let mut sent = 0;
        for (k, sample_ns) in times.into_iter().cycle().take(600).enumerate() {
            let record = PoseRecord {
                sequence: (k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15),
                available_ns: times[k % 5],
                sample_ns,
                device_ns: times[k % 6],
                position_m: [numbers[k % 5]; 3],
                quaternion_xyzw: [numbers[k % 4], 0.0, 0.0, numbers[(k + 1) % 5]],
                flags: (k % 4) as u32,
                session: (k % 9) as u32,
            };
            sent += 1;
            if let Streamed::Sample(sample) = stream.take(&record, k as i64, k % 3 == 0) {
                assert!(STAMPS.contains(&sample.stamp.0));
            }
        }
        let counts = stream.counts();
        assert_eq!(counts.received, sent);
        assert!(counts.invalid >= 250 && counts.unstampable > 0 && counts.malformed > 0);
    }

    #[test]
    fn marks_without_a_time_of_their_own_are_stamped_on_arrival() {
        let mark = MarkRecord {
            sequence: 0,
            available_ns: 3,
            sample_ns: NO_TIME,
            device_ns: NO_TIME,
            event: [0; 256],
            flags: 0,
            session: 0,
        };
        assert_eq!(stamp_mark(&mark, 7), Some(Stamp(7)));
        let given = MarkRecord {
            sample_ns: 5,
            ..mark
        };
        assert_eq!(stamp_mark(&given, 7), Some(Stamp(5)));
        let absurd = MarkRecord {
            sample_ns: -5,
            ..mark
        };
        assert_eq!(stamp_mark(&absurd, 7), None);
    }
}
