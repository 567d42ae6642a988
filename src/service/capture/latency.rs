//! Statistics of latencies by a histogram.

use serde::Serialize;

/// Width of a bin \[ms\].
const BIN_MS: f64 = 0.05;
const BINS: usize = 2000;

/// A histogram of latencies up to 100 ms; longer ones are in the last bin.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Latencies {
    bins: Vec<u64>,
    count: u64,
    max_ms: f64,
}

/// A summary of latencies \[ms\]. Quantiles are the upper ends of their bins of 0.05 ms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct LatencyLine {
    /// The median.
    pub p50: f64,
    /// The 99th percentile.
    pub p99: f64,
    /// The maximum.
    pub max: f64,
}

impl Default for Latencies {
    fn default() -> Self {
        Self {
            bins: vec![0; BINS],
            count: 0,
            max_ms: 0.0,
        }
    }
}

impl Latencies {
    pub(super) fn add(&mut self, latency: std::time::Duration) {
        let latency_ms = latency.as_secs_f64() * 1e3;
        self.bins[((latency_ms / BIN_MS) as usize).min(BINS - 1)] += 1;
        self.count += 1;
        self.max_ms = self.max_ms.max(latency_ms);
    }

    /// Adds the latencies of another histogram.
    pub(super) fn merge(&mut self, other: &Self) {
        for (bin, count) in self.bins.iter_mut().zip(&other.bins) {
            *bin += count;
        }
        self.count += other.count;
        self.max_ms = self.max_ms.max(other.max_ms);
    }

    /// The bins that are not empty: upper end \[s\] and count; the last bin ends at the maximum.
    pub(super) fn bins_s(&self) -> impl Iterator<Item = (f64, u64)> {
        let held = self
            .bins
            .iter()
            .enumerate()
            .filter(|(_, count)| **count > 0);
        held.map(|(bin, count)| {
            let upper_ms = if bin + 1 == BINS {
                self.max_ms
            } else {
                BIN_MS * (bin + 1) as f64
            };
            (upper_ms * 1e-3, *count)
        })
    }

    pub(super) fn line(&self) -> LatencyLine {
        LatencyLine {
            p50: self.quantile_ms(0.5),
            p99: self.quantile_ms(0.99),
            max: self.max_ms,
        }
    }

    fn quantile_ms(&self, share: f64) -> f64 {
        let wanted = (share * self.count as f64).ceil() as u64;
        let mut below = 0;
        for (bin, count) in self.bins.iter().enumerate() {
            below += count;
            if below >= wanted.max(1) {
                return (BIN_MS * (bin + 1) as f64).min(self.max_ms);
            }
        }
        0.0
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn quantiles_are_right_to_a_bin() {
        let mut latencies = Latencies::default();
        assert_eq!(latencies.line(), LatencyLine::default());
        for k in 1..=1000 {
            latencies.add(Duration::from_micros(10 * k));
        }
        latencies.add(Duration::from_secs(3));
        let line = latencies.line();
        assert!((line.p50 - 5.0).abs() <= 0.06, "{line:?}");
        assert!((line.p99 - 9.9).abs() <= 0.06, "{line:?}");
        assert_eq!(line.max, 3000.0);
    }
}
