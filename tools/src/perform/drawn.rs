//! Hands drawn at random, for studies that want all kinds of them.

use rand::RngExt;

use super::acting::Acting;
use super::streams::{Role, stream};

/// Least and greatest rounding of kinks [s, acted].
const KINK_S: [f64; 2] = [0.004, 0.02];
/// Least and greatest factor on the wanders.
const DISTORTION: [f64; 2] = [0.25, 2.0];
/// Least and greatest pace of the wanders.
const PACE: [f64; 2] = [0.3, 3.0];
/// Slowdowns: from twice as fast as the motion to a quarter of its speed.
const SLOWDOWNS: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
/// Rates of trackers, from cameras to the fastest \[Hz\].
const RATES_HZ: [f64; 7] = [30.0, 60.0, 100.0, 120.0, 240.0, 500.0, 1000.0];

impl Acting {
    /// A hand drawn at random, before a tracker of a rate drawn at random: how it rounds kinks (4 to 20 ms,
    /// uniform), how much it wanders (a factor of 0.25 to 2) and how fast (0.3 to 3; both uniform in the
    /// logarithm), its slowdown (0.5, 1, 2 or 4) and the rate (one of seven, 30 to 1000 Hz). All other
    /// knobs are the default's. A seed always gives the same hand, apart from what it gives a performance.
    pub fn drawn(seed: u64) -> Self {
        let mut rng = stream(seed, Role::Knobs, 0);
        let [least_s, most_s] = KINK_S;
        let kink_s = rng.random_range(least_s..=most_s);
        let mut log_uniform =
            |[least, most]: [f64; 2]| rng.random_range(least.ln()..=most.ln()).exp();
        let [distortion, wander_pace] = [DISTORTION, PACE].map(&mut log_uniform);
        let mut one_of = |choices: &[f64]| choices[rng.random_range(0..choices.len())];
        Self {
            kink_s,
            distortion,
            wander_pace,
            slowdown: one_of(&SLOWDOWNS),
            rate_hz: one_of(&RATES_HZ),
            ..Self::default()
        }
    }
}
