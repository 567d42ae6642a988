//! Counts of one tracker's samples: lost, late, duplicated or invalid, by their sequence numbers.

use serde::Serialize;

use crate::wire::live::PoseRecord;

/// How many sequence numbers back duplicates are recognised; older samples count as late.
const WINDOW: u64 = 1024;
const WORDS: usize = (WINDOW / 64) as usize;

/// Longest hole that is believed: half an hour at 1 kHz. A number further ahead is a *leap*: the
/// publisher is believed to count on from there only once its next sample does.
const LEAP: u64 = 1 << 21;

/// Number of publishers of one tracker that are told apart.
const SESSIONS: usize = 4;

/// Counts of one tracker.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct TallyCounts {
    /// All samples that arrived.
    pub received: u64,
    /// Holes in the sequence.
    pub gaps: u64,
    /// Sequence numbers that never arrived.
    pub missing: u64,
    /// Sequence numbers that were missing at some time, also if they arrived later.
    pub skipped: u64,
    /// Samples with a number too far ahead to be believed, and publishers that went on there.
    pub leaps: u64,
    /// Holes that an overflow of the subscriber's buffer likely caused. One may be before the first
    /// sample of a publisher: how many were lost there nobody knows.
    pub overflows: u64,
    /// Samples that arrived after one with a greater number.
    pub late: u64,
    /// Samples that had arrived before.
    pub duplicated: u64,
    /// Samples that the tracker does not vouch for.
    pub invalid: u64,
    /// Poses with invalid numbers: not finite, or no unit quaternion.
    pub malformed: u64,
    /// Stamps that no message can hold: before 1970 or after 2106.
    pub unstampable: u64,
    /// Samples with the pose of the one before, bit for bit.
    pub frozen: u64,
    /// Publishers that started after the first.
    pub restarts: u64,
}

impl TallyCounts {
    /// The counts of what may be wrong with samples, by name.
    pub fn troubles(&self) -> [(&'static str, u64); 10] {
        [
            ("missing", self.missing),
            ("overflows", self.overflows),
            ("late", self.late),
            ("duplicated", self.duplicated),
            ("invalid", self.invalid),
            ("malformed", self.malformed),
            ("unstampable", self.unstampable),
            ("frozen", self.frozen),
            ("restarts", self.restarts),
            ("leaps", self.leaps),
        ]
    }

    /// Whether a sample that was sent never arrived.
    pub fn lacks_samples(&self) -> bool {
        self.missing > 0 || self.overflows > 0
    }

    /// Adds the counts of another take.
    pub fn add(&mut self, other: &Self) {
        self.received += other.received;
        self.gaps += other.gaps;
        self.missing += other.missing;
        self.skipped += other.skipped;
        self.leaps += other.leaps;
        self.overflows += other.overflows;
        self.late += other.late;
        self.duplicated += other.duplicated;
        self.invalid += other.invalid;
        self.malformed += other.malformed;
        self.unstampable += other.unstampable;
        self.frozen += other.frozen;
        self.restarts += other.restarts;
    }
}

/// What becomes of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It is used.
    Used,
    /// It is not valid: kept in the raw stream only.
    Invalid,
    /// It has arrived before: kept in the raw stream only.
    Duplicate,
}

/// The publisher and the number of a sample that came before a take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Before {
    session: u32,
    sequence: u64,
}

impl Before {
    /// Of a sample.
    pub fn of(record: &PoseRecord) -> Self {
        Self {
            session: record.session,
            sequence: record.sequence,
        }
    }
}

/// Counts the samples of one tracker.
#[derive(Clone, Debug, Default)]
pub struct SequenceCounts {
    counts: TallyCounts,
    /// The last sample that came before those that are counted.
    before: Option<Before>,
    sessions: Vec<Session>,
    last_pose: Option<[u64; 7]>,
}

/// One publisher: the greatest number that arrived, and which of those below it arrived.
#[derive(Clone, Debug)]
struct Session {
    session: u32,
    first: u64,
    greatest: u64,
    /// The last number that was too far ahead.
    leap: Option<u64>,
    /// Bit `k` of the whole stands for `greatest − k`.
    seen: [u64; WORDS],
}

impl SequenceCounts {
    /// Counts what comes after that sample: a hole right after it is one.
    pub fn after(before: Option<Before>) -> Self {
        Self {
            before,
            ..Self::default()
        }
    }

    /// Counts a sample.
    pub fn count(&mut self, record: &PoseRecord, is_overflow: bool) -> Fate {
        self.counts.received += 1;
        if self.is_duplicate(record, is_overflow) {
            self.counts.duplicated += 1;
            return Fate::Duplicate;
        }
        if !record.is_valid() {
            self.counts.invalid += 1;
            return Fate::Invalid;
        }
        let numbers = || record.position_m.iter().chain(&record.quaternion_xyzw);
        let norm2: f64 = record.quaternion_xyzw.iter().map(|x| x * x).sum();
        // False for a norm that is NaN, too.
        let is_unit = (norm2.sqrt() - 1.0).abs() <= 0.01;
        if !is_unit || numbers().any(|x| !x.is_finite()) {
            self.counts.malformed += 1;
        }
        let mut pose = [0; 7];
        for (bits, number) in pose.iter_mut().zip(numbers()) {
            *bits = number.to_bits();
        }
        self.counts.frozen += u64::from(self.last_pose == Some(pose));
        self.last_pose = Some(pose);
        Fate::Used
    }

    /// Counts a stamp that no message can hold.
    pub fn unstampable(&mut self) {
        self.counts.unstampable += 1;
    }

    /// The counts so far.
    pub fn counts(&self) -> TallyCounts {
        self.counts
    }

    fn is_duplicate(&mut self, record: &PoseRecord, is_overflow: bool) -> bool {
        let session = record.session;
        if let Some(before) = self.before.take_if(|before| before.session == session) {
            self.sessions.push(Session::new(session, before.sequence));
        }
        let known = self.sessions.iter().position(|s| s.session == session);
        let Some(at) = known else {
            self.counts.restarts += u64::from(!self.sessions.is_empty());
            let is_cut = is_overflow && record.sequence > 0;
            self.counts.gaps += u64::from(is_cut);
            self.counts.overflows += u64::from(is_cut);
            if self.sessions.len() == SESSIONS {
                self.sessions.remove(0);
            }
            self.sessions.push(Session::new(session, record.sequence));
            return false;
        };
        let session = &mut self.sessions[at];
        if record.sequence > session.greatest {
            let ahead = record.sequence - session.greatest;
            if ahead > LEAP {
                self.counts.leaps += 1;
                let follows = |leap| record.sequence > leap && record.sequence - leap <= LEAP;
                if session.leap.is_some_and(follows) {
                    *session = Session::new(record.session, record.sequence);
                } else {
                    session.leap = Some(record.sequence);
                }
                return false;
            }
            session.advance(ahead);
            if ahead > 1 {
                self.counts.gaps += 1;
                self.counts.missing += ahead - 1;
                self.counts.skipped += ahead - 1;
                self.counts.overflows += u64::from(is_overflow);
            }
            return false;
        }
        let back = session.greatest - record.sequence;
        if back < WINDOW && session.has(back) {
            return true;
        }
        if back < WINDOW {
            session.set(back);
        }
        self.counts.late += 1;
        // What came before the first was never missed.
        if record.sequence > session.first {
            self.counts.missing = self.counts.missing.saturating_sub(1);
        }
        false
    }
}

impl Session {
    fn new(session: u32, greatest: u64) -> Self {
        let mut seen = [0; WORDS];
        seen[0] = 1;
        Self {
            session,
            first: greatest,
            greatest,
            leap: None,
            seen,
        }
    }

    fn has(&self, back: u64) -> bool {
        self.seen[(back / 64) as usize] >> (back % 64) & 1 == 1
    }

    fn set(&mut self, back: u64) {
        self.seen[(back / 64) as usize] |= 1 << (back % 64);
    }

    /// Raises the greatest number, which has arrived, by `ahead`.
    fn advance(&mut self, ahead: u64) {
        self.greatest += ahead;
        self.leap = None;
        if ahead >= WINDOW {
            self.seen = [0; WORDS];
        } else {
            let (words, bits) = ((ahead / 64) as usize, ahead % 64);
            for at in (0..WORDS).rev() {
                let from = |at: Option<usize>| at.map_or(0, |at| self.seen[at]);
                let low = from(at.checked_sub(words + 1));
                let high = from(at.checked_sub(words));
                self.seen[at] = if bits == 0 {
                    high
                } else {
                    high << bits | low >> (64 - bits)
                };
            }
        }
        self.set(0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(session: u32, sequence: u64) -> PoseRecord {
        PoseRecord {
            position_m: [sequence as f64, f64::from(session), 0.0],
            session,
            ..PoseRecord::numbered(sequence)
        }
    }

    fn counted(sequences: &[u64]) -> TallyCounts {
        let mut tally = SequenceCounts::default();
        for sequence in sequences {
            tally.count(&record(1, *sequence), false);
        }
        tally.counts()
    }

    #[test]
    fn an_unbroken_sequence_counts_nothing_but_samples() {
        let all: Vec<u64> = (7..3007).collect();
        let expected = TallyCounts {
            received: 3000,
            ..TallyCounts::default()
        };
        assert_eq!(counted(&all), expected);
    }

    #[test]
    fn holes_late_ones_and_doubles_are_told_apart() {
        let counts = counted(&[1, 2, 5, 3, 3, 5, 70, 4, 69]);
        assert_eq!((counts.gaps, counts.missing), (2, 63));
        assert_eq!((counts.late, counts.duplicated), (3, 2));
        // Every number sent twice, in any order within the window, is a double once.
        let mut twice: Vec<u64> = (0..1000).collect();
        twice.extend((0..1000).rev());
        assert_eq!(counted(&twice).duplicated, 1000);
    }

    #[test]
    fn numbers_at_the_end_of_their_range_do_not_overflow() {
        let counts = counted(&[0, u64::MAX, 5, u64::MAX - 1, u64::MAX]);
        assert_eq!((counts.missing, counts.leaps), (4, 3));
    }

    #[test]
    fn a_bogus_number_counts_as_one_and_what_follows_is_neither_late_nor_missing() {
        for bogus in [u64::MAX, 1 << 63, LEAP + 3] {
            let counts = counted(&[0, 1, 2, bogus, 3, 4, 5, 7]);
            let found = (counts.leaps, counts.gaps, counts.missing, counts.late);
            assert_eq!(found, (1, 1, 1, 0), "{bogus}");
        }
        // A publisher that counts on from there is followed.
        let far = 1 << 40;
        let counts = counted(&[0, 1, far, far + 1, far + 2, far + 4]);
        let found = (counts.leaps, counts.missing, counts.late);
        assert_eq!(found, (2, 1, 0));
    }

    #[test]
    fn a_hole_right_after_what_came_before_is_one() {
        let after = |sequence, next: &[u64]| {
            let mut tally = SequenceCounts::after(Some(Before::of(&record(1, sequence))));
            for next in next {
                tally.count(&record(1, *next), true);
            }
            let counts = tally.counts();
            (counts.received, counts.gaps, counts.missing, counts.late)
        };
        assert_eq!(after(10, &[11, 12]), (2, 0, 0, 0));
        assert_eq!(after(10, &[15, 16]), (2, 1, 4, 0));
        // What was late came before or is no longer missing; a double is no sample.
        assert_eq!(after(10, &[9, 11, 10]), (3, 0, 0, 1));
        assert_eq!(after(10, &[15, 12]), (2, 1, 3, 1));
        // Another publisher begins where it wants to, and is no restart; it was cut where it came
        // from a full buffer.
        for (sequence, is_overflow, cut) in [(500, false, 0), (0, true, 0), (500, true, 1)] {
            let mut tally = SequenceCounts::after(Some(Before::of(&record(1, 10))));
            tally.count(&record(2, sequence), is_overflow);
            let counts = tally.counts();
            assert_eq!((counts.restarts, counts.missing), (0, 0));
            assert_eq!((counts.gaps, counts.overflows), (cut, cut));
        }
    }

    proptest::proptest! {
        /// Whatever numbers come: what is counted never falls, but for what was missing and came
        /// late, and nothing that is missing was not skipped.
        #[test]
        fn counts_never_fall(
            numbers in proptest::collection::vec(
                proptest::prop_oneof![0..4000_u64, proptest::num::u64::ANY],
                1..200,
            ),
        ) {
            let mut tally = SequenceCounts::default();
            let mut before = TallyCounts::default();
            for number in numbers {
                tally.count(&record(1, number), false);
                let now = tally.counts();
                let pairs = before.troubles().into_iter().zip(now.troubles());
                for ((what, before), (_, now)) in pairs {
                    proptest::prop_assert!(what == "missing" || before <= now, "{}", what);
                }
                proptest::prop_assert!(before.skipped <= now.skipped);
                proptest::prop_assert!(now.missing <= now.skipped && now.skipped < 200 * LEAP);
                before = now;
            }
        }
    }

    #[test]
    fn restarts_invalid_frozen_and_malformed_ones_are_counted() {
        let mut tally = SequenceCounts::default();
        assert_eq!(tally.count(&record(1, 100), false), Fate::Used);
        assert_eq!(tally.count(&record(2, 0), false), Fate::Used);
        let frozen = PoseRecord {
            sequence: 1,
            ..record(2, 0)
        };
        assert_eq!(tally.count(&frozen, false), Fate::Used);
        let invalid = PoseRecord {
            flags: 0,
            ..record(2, 2)
        };
        assert_eq!(tally.count(&invalid, false), Fate::Invalid);
        let malformed = PoseRecord {
            position_m: [f64::NAN; 3],
            ..record(2, 3)
        };
        assert_eq!(tally.count(&malformed, false), Fate::Used);
        assert_eq!(tally.count(&record(2, 9), true), Fate::Used);
        let counts = tally.counts();
        let found = [
            counts.restarts,
            counts.frozen,
            counts.invalid,
            counts.malformed,
            counts.overflows,
        ];
        assert_eq!(found, [1; 5]);
    }
}
