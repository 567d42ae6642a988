//! Detects that a clock was set, from a reading that does not fit its stream.

/// Least step that is detected \[ns\],
const LEAST_NS: f64 = 10e6;

/// and least step as a multiple of the stream's noise.
const NOISES: f64 = 8.0;

/// Weight of the last interval in the exponential means.
const WEIGHT: f64 = 1.0 / 32.0;

/// Number of intervals before a step can be detected.
const SETTLED: u32 = 32;

/// Greatest relative difference of the mean intervals of readings and arrivals in a live stream; a
/// recording played faster differs by more.
const PACE: f64 = 0.1;

/// Greatest deviation of an arrival from its expected time, as a share of the step: more is a late
/// delivery.
const PUNCTUAL: f64 = 0.25;

/// Exponential means of a live, even stream. With `Δd` the difference of readings, `Δr` that of
/// arrivals and `n` that of sequence numbers, it keeps the means of `Δd/n`, `Δr/n` and of the
/// noise `|Δd − Δr| + |Δd − n·mean|`.
///
/// A clock was set where the sample comes on time, `Δr ≈ n·mean`, and its reading does not:
/// `|Δd − Δr|` is greater than 8 times the noise and 10 ms. A stalled delivery changes `Δr`, a hole
/// changes both alike, a recording played fast has another mean: none of them is a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cadence {
    reading_ns: f64,
    arrival_ns: f64,
    noise_ns: f64,
    count: u32,
}

impl Cadence {
    /// Adds an interval to the means and returns `None`; for an interval with a step, returns
    /// instead by how much the clock was set \[ns\]. `numbers` is at least 1.
    pub fn step_ns(&mut self, reading_ns: i64, arrival_ns: i64, numbers: u64) -> Option<i64> {
        let (reading, arrival) = (reading_ns as f64, arrival_ns as f64);
        let numbers = numbers.max(1) as f64;
        let expected = numbers * self.reading_ns;
        let jump = reading - arrival;
        let is_live = self.count >= SETTLED
            && (self.reading_ns - self.arrival_ns).abs() <= PACE * self.reading_ns;
        let is_far = jump.abs() > LEAST_NS.max(NOISES * self.noise_ns);
        let is_punctual = (arrival - expected).abs() <= PUNCTUAL * jump.abs();
        if is_live && is_far && is_punctual {
            return Some(jump as i64);
        }
        // Plain means at the beginning.
        self.count = self.count.saturating_add(1);
        let weight = WEIGHT.max(1.0 / f64::from(self.count));
        let noise = jump.abs() + (reading - expected).abs();
        self.reading_ns += weight * (reading / numbers - self.reading_ns);
        self.arrival_ns += weight * (arrival / numbers - self.arrival_ns);
        if self.count > 1 {
            self.noise_ns += weight * (noise - self.noise_ns);
        }
        None
    }
}
