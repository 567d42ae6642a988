//! Stamps for an even stream from its arrivals, with the jitter filtered out.

/// Time constant of the filter \[s\].
const CONSTANT_S: f64 = 1.0;

/// A second-order tracking loop, critically damped: phase and period of an even stream from its
/// arrivals.
///
/// With `n` periods `T` since the last stamp `t`, arrival `r`, prediction `p = t + n T` and error
/// `e = r − p`: `t ← p + α e`, `T ← T + β e / n`; `α = 2 x`, `β = x²`,
/// `x = min(n T / CONSTANT_S, 1/2)`. At the beginning it averages: at the `i`-th sample `x` is at
/// least `2/i`, about the gains of a line fitted to all samples so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoother {
    /// The first arrival \[ns\]; later times are relative to it, so that floats are precise.
    origin_ns: i64,
    stamp_s: f64,
    period_s: Option<f64>,
    count: u64,
}

impl Smoother {
    /// Begins with an arrival \[ns\].
    pub fn new(arrival_ns: i64) -> Self {
        Self {
            origin_ns: arrival_ns,
            stamp_s: 0.0,
            period_s: None,
            count: 0,
        }
    }

    /// The stamp of an arrival `steps` samples after the last one \[ns\]. Never before the last.
    pub fn stamp(&mut self, arrival_ns: i64, steps: u64) -> i64 {
        let steps = steps.max(1) as f64;
        let arrival_s = arrival_ns.saturating_sub(self.origin_ns) as f64 * 1e-9;
        self.count += 1;
        let Some(period_s) = self.period_s else {
            self.period_s = Some(((arrival_s - self.stamp_s) / steps).max(0.0));
            self.stamp_s = self.stamp_s.max(arrival_s);
            return self.stamp_ns();
        };
        let predicted_s = self.stamp_s + steps * period_s;
        let error_s = arrival_s - predicted_s;
        let least = 2.0 / (self.count as f64);
        let x = (steps * period_s / CONSTANT_S).max(least).min(0.5);
        self.stamp_s = (predicted_s + 2.0 * x * error_s).max(self.stamp_s);
        self.period_s = Some((period_s + x * x * error_s / steps).max(0.0));
        self.stamp_ns()
    }

    /// Arrival less expected arrival \[ns\].
    pub fn surprise_ns(&self, arrival_ns: i64, steps: u64) -> i64 {
        let period_s = self.period_s.unwrap_or(0.0);
        let arrival_s = arrival_ns.saturating_sub(self.origin_ns) as f64 * 1e-9;
        ((arrival_s - self.stamp_s - steps.max(1) as f64 * period_s) * 1e9) as i64
    }

    fn stamp_ns(&self) -> i64 {
        self.origin_ns
            .saturating_add((self.stamp_s * 1e9).round() as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pattern of delays with mean zero \[ns\].
    fn jitter(k: i64) -> i64 {
        (k * 7919 % 101 - 50) * 60_000
    }

    #[test]
    fn jitter_is_reduced_by_an_order_and_order_is_kept() {
        let mut smoother = Smoother::new(1_700_000_000_000_000_000);
        let (mut before, mut after, mut last) = (0.0, 0.0, i64::MIN);
        for k in 1..4000_i64 {
            let truth = 1_700_000_000_000_000_000 + k * 5_000_000;
            let stamp = smoother.stamp(truth + jitter(k), 1);
            assert!(stamp >= last);
            last = stamp;
            if k > 600 {
                before += (jitter(k) as f64).powi(2);
                after += ((stamp - truth) as f64).powi(2);
            }
        }
        assert!(
            after < before / 100.0,
            "{} of {}",
            after.sqrt(),
            before.sqrt()
        );
    }

    #[test]
    fn an_arrival_before_the_last_one_is_not_stamped_before_it() {
        let mut smoother = Smoother::new(0);
        let mut last = 0;
        for k in 1..2000_i64 {
            let early = if k % 500 == 0 { 3_000_000_000 } else { 0 };
            let stamp = smoother.stamp(k * 5_000_000 - early, 1);
            assert!(stamp >= last, "{k}: {stamp} after {last}");
            last = stamp;
        }
    }

    #[test]
    fn a_hole_in_the_sequence_is_a_hole_in_the_stamps() {
        let mut smoother = Smoother::new(0);
        for k in 1..1000_i64 {
            smoother.stamp(k * 5_000_000, 1);
        }
        let stamp = smoother.stamp(1049 * 5_000_000, 50);
        assert!((stamp - 1049 * 5_000_000).abs() < 1000, "{stamp}");
    }
}
