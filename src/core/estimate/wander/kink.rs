//! Which samples tell how a hand errs: a hand rounds the kink that a motion has at an impact, which is no error of the process.

use statrs::distribution::{Continuous, ContinuousCDF, Normal};

/// Samples are left out so near to an impact \[s\],
const KINK_S: f64 = 0.06;
/// but no more of a flight at either end than this share.
const KINK_SHARE: f64 = 0.2;
/// Samples of a tracker that are nearer to one another tell next to nothing more \[s\].
pub const APART_S: f64 = 0.0035;
/// How a hand rounds a kink that samples are near to: standard deviation of a Gaussian by which its path is smoothed \[s\].
const ROUNDED_S: f64 = 0.016;

/// How near to an impact samples of a flight of this length are left out \[s\].
pub fn kink_s(flight_s: f64) -> f64 {
    KINK_S.min(KINK_SHARE * flight_s)
}

/// Whether samples of a flight of this length are as near to an impact as a hand rounds it.
pub fn is_near_kinks(flight_s: f64) -> bool {
    kink_s(flight_s) < KINK_S
}

/// How far smoothing leads a sample off so long before or after an impact, per velocity that jumps there \[s\].
///
/// ```text
/// σ (φ(t/σ) − t/σ Φ(−t/σ))
/// ```
pub fn led_off_s(since_s: f64) -> f64 {
    let of_sd = since_s.abs() / ROUNDED_S;
    let law = Normal::standard();
    ROUNDED_S * (law.pdf(of_sd) - of_sd * law.sf(of_sd))
}

/// How a hand rounds kinks, as samples see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounding {
    /// Samples that it rounds alike.
    alike: f64,
}

impl Rounding {
    /// Of samples so far apart \[s\].
    pub fn new(apart_s: f64) -> Self {
        Self {
            alike: (ROUNDED_S / apart_s).max(1.0),
        }
    }

    /// Variance of a sample so long before or after an impact at which velocities jump by so much, as if samples erred by
    /// themselves: the square of how far it is led off, for each that is led off alike.
    pub fn variance(&self, since_s: f64, jump_per_s: f64) -> f64 {
        self.alike * (jump_per_s * led_off_s(since_s)).powi(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A path with a kink, smoothed by a sum over a Gaussian, is as far off as is said.
    #[test]
    fn samples_are_off_as_far_as_smoothing_leads_them() {
        let (jump_m_s, steps) = (1.7, 4000);
        let rounding = Rounding::new(1.0);
        for since_s in [0.0, 0.005, -0.016, 0.03] {
            let weights = (-steps..=steps).map(|at| {
                let deviations = 8.0 * f64::from(at) / f64::from(steps);
                (
                    ROUNDED_S * deviations,
                    (-0.5 * deviations * deviations).exp(),
                )
            });
            let kink = |time_s: f64| jump_m_s * time_s.max(0.0);
            let (sum, weight) = weights.fold((0.0, 0.0), |(sum, all), (by_s, weight)| {
                (sum + weight * kink(since_s + by_s), all + weight)
            });
            let off_m = sum / weight - kink(since_s);
            let said_m = rounding.variance(since_s, jump_m_s).sqrt();
            assert!((said_m - off_m).abs() < 1e-6, "{since_s}: {said_m} {off_m}");
        }
    }
}
