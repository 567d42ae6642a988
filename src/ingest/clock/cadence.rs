//! Whether a reading is out of step with the stream it belongs to.

/// Steps that are less go unnoticed \[ns\].
const LEAST_NS: f64 = 10e6;

/// So are steps of less than this many times the stream's noise.
const NOISES: f64 = 8.0;

/// Weight of the last interval in all means.
const WEIGHT: f64 = 1.0 / 32.0;

/// Intervals before anything is judged.
const SETTLED: u32 = 32;

/// Share by which the paces of readings and arrivals may differ in a stream that is live, and
/// not a recording played faster.
const PACE: f64 = 0.1;

/// Share of a step by which an arrival may be off its time: more is a late delivery.
const PUNCTUAL: f64 = 0.25;

/// The means of a live, even stream: with `Δd` from reading to reading, `Δr` from arrival to
/// arrival, and `n` the difference of the sequence numbers, it follows `Δd/n`, `Δr/n` and the
/// noise `|Δd − Δr| + |Δd − n·mean|`.
///
/// A clock was set where the sample comes on time, `Δr ≈ n·mean`, and its reading does not,
/// `|Δd − Δr|` beyond 8 times the noise and 10 ms. A stall of delivery is off in
/// `Δr`, a hole in both alike, a recording played fast in its pace: none of them is a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cadence {
    reading_ns: f64,
    arrival_ns: f64,
    noise_ns: f64,
    count: u32,
}

impl Cadence {
    /// Takes in an interval, unless it has a step: by how much the clock was set then \[ns\].
    /// `numbers` is at least 1.
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
        // At first, plain means.
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
