//! How much a page may send: so much at once, and so much a second from then on.

use std::time::Instant;

/// What is left of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Allowance {
    per_second: f64,
    at_once: f64,
    left: f64,
    counted: Instant,
}

impl Allowance {
    pub(super) fn new(per_second: f64, at_once: f64, now: Instant) -> Self {
        Self {
            per_second,
            at_once,
            left: at_once,
            counted: now,
        }
    }

    /// Takes so many of it; whether there were as many.
    pub(super) fn take(&mut self, count: usize, now: Instant) -> bool {
        let since_s = now.saturating_duration_since(self.counted).as_secs_f64();
        self.counted = now;
        self.left = (self.left + since_s * self.per_second).min(self.at_once);
        let is_enough = self.left >= count as f64;
        if is_enough {
            self.left -= count as f64;
        }
        is_enough
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn what_was_held_up_may_come_at_once_and_more_than_the_rate_may_not() {
        let begun = Instant::now();
        let mut allowance = Allowance::new(1000.0, 2000.0, begun);
        assert!(allowance.take(2000, begun) && !allowance.take(1, begun));
        // At the rate for a minute, then twice as fast: that lasts as long as what was saved.
        let mut now = begun + Duration::from_secs(5);
        for _ in 0..6000 {
            now += Duration::from_millis(10);
            assert!(allowance.take(10, now));
        }
        let mut taken = 0;
        while allowance.take(20, now) {
            taken += 20;
            now += Duration::from_millis(10);
        }
        assert!((3900..=4100).contains(&taken), "{taken}");
    }
}
