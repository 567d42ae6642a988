//! Maps another clock to this machine's by the least delay.

/// A delay that grows by no more than this is taken for drift between the clocks, not for a
/// slow delivery \[s/s\]: ten times a bad crystal's.
const DRIFT: f64 = 1e-3;

/// Follows the lower envelope of arrival less reading: the excess over it is delay of delivery.
///
/// With arrival `r_i`, reading `d_i` and offset `o`:
/// `o ← min(r_i − d_i, o + DRIFT · (r_i − r_{i−1}))`; the stamp is `d_i + o`. It is never later
/// than the arrival, and late by the least delay of delivery, which cannot be observed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Follower {
    offset_ns: i64,
    arrival_ns: i64,
}

impl Follower {
    /// Begins with a reading of the other clock and its arrival on ours \[ns\].
    pub fn new(reading_ns: i64, arrival_ns: i64) -> Self {
        Self {
            offset_ns: arrival_ns.saturating_sub(reading_ns),
            arrival_ns,
        }
    }

    /// The stamp of a reading \[ns\].
    pub fn stamp(&mut self, reading_ns: i64, arrival_ns: i64) -> i64 {
        let elapsed_ns = arrival_ns.saturating_sub(self.arrival_ns).max(0);
        // Rounded up: at 1 kHz, truncation would lose a microsecond with every sample.
        let drift_ns = (elapsed_ns as f64 * DRIFT).ceil() as i64;
        let delay_ns = arrival_ns.saturating_sub(reading_ns);
        self.offset_ns = delay_ns.min(self.offset_ns.saturating_add(drift_ns));
        self.arrival_ns = self.arrival_ns.max(arrival_ns);
        reading_ns.saturating_add(self.offset_ns)
    }

    /// By how much a reading leads \[ns\]: how long before its measurement it would have arrived,
    /// with the offset so far.
    pub fn lead_ns(&self, reading_ns: i64, arrival_ns: i64) -> i64 {
        let delay_ns = arrival_ns.saturating_sub(reading_ns);
        self.offset_ns.saturating_sub(delay_ns)
    }

    /// This machine's clock less the other \[ns\].
    pub fn offset_ns(&self) -> i64 {
        self.offset_ns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_are_taken_off_but_for_the_least() {
        // 1 kHz, another zero, delays of 2 ms and more, one stall of 300 ms.
        let mut follower = Follower::new(0, 5_002_000_000);
        for k in 1..5000_i64 {
            let reading = k * 1_000_000;
            let stall = if k == 3000 { 300_000_000 } else { 0 };
            let delay = 2_000_000 + (k * 7919 % 13) * 500_000 + stall;
            let stamp = follower.stamp(reading, 5_000_000_000 + reading + delay);
            let error = stamp - (5_000_000_000 + reading + 2_000_000);
            // The offset may rise by the drift between two undelayed samples, 13 ms apart, and
            // by that of the stall.
            let allowed = if (3000..3020).contains(&k) {
                320_000
            } else {
                20_000
            };
            assert!((0..=allowed).contains(&error), "{k}: {error}");
        }
    }

    #[test]
    fn an_arrival_before_the_last_one_moves_nothing() {
        let mut follower = Follower::new(0, 5_000_000_000);
        for k in 1..100_i64 {
            follower.stamp(k * 1_000_000, 5_000_000_000 + k * 1_000_000);
        }
        let before = follower.offset_ns();
        // A second back, of a sample from two seconds ago: nothing is known of the delay by it.
        follower.stamp(-1_901_000_000, 4_099_000_000);
        assert_eq!(follower.offset_ns(), before);
        // The next is a millisecond after the last: that is all there may have been of drift.
        follower.stamp(100_000_000, 5_200_000_000);
        let drift_ns = follower.offset_ns() - before;
        assert!((0..=101_000).contains(&drift_ns), "{drift_ns} ns");
    }

    #[test]
    fn a_drifting_clock_is_followed() {
        for drift_ppm in [-200_i64, 200] {
            let mut follower = Follower::new(0, 0);
            let mut worst = 0;
            for k in 1..100_000_i64 {
                let truth = k * 1_000_000;
                let reading = truth + truth / 1_000_000 * drift_ppm;
                worst = worst.max((follower.stamp(reading, truth) - truth).abs());
            }
            assert!(worst < 10_000, "{drift_ppm} ppm: {worst} ns");
        }
    }
}
