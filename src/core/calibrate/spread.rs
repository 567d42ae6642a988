//! How far what was estimated may be off.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// How often an interval should contain what it is about.
pub const CONFIDENCE: f64 = 0.95;

/// Most blocks of a jackknife: more take longer and say no more.
const MOST_BLOCKS: usize = 24;

/// Fewest blocks: with fewer, intervals say nothing.
const FEWEST_BLOCKS: usize = 6;

/// Length of a block in correlation times.
const TIMES: f64 = 4.0;

/// A number, or several, with an interval.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The estimate.
    pub value: Vec<f64>,
    /// Its standard deviation.
    pub sd: Vec<f64>,
    /// Half the width of its interval at [`CONFIDENCE`]; infinite where nothing is known of it.
    pub half: Vec<f64>,
}

impl Measured {
    /// An estimate with standard deviations of `freedom` degrees.
    pub fn new(value: Vec<f64>, sd: Vec<f64>, freedom: f64) -> Self {
        let quantile = quantile(freedom);
        let half = sd.iter().map(|sd| quantile * sd).collect();
        Self { value, sd, half }
    }

    /// Whether the interval of each number contains that of `truth`.
    pub fn covers(&self, truth: &[f64]) -> Vec<bool> {
        let numbers = self.value.iter().zip(&self.half).zip(truth);
        let covers = numbers.map(|((value, half), truth)| (value - truth).abs() <= *half);
        covers.collect()
    }

    /// The same in another unit.
    pub fn times(&self, factor: f64) -> Self {
        let scaled = |of: &[f64]| of.iter().map(|x| x * factor).collect();
        Self {
            value: scaled(&self.value),
            sd: scaled(&self.sd),
            half: scaled(&self.half),
        }
    }
}

/// Half the width of an interval at [`CONFIDENCE`], in standard deviations of so many degrees of
/// freedom; infinite without any.
pub(super) fn quantile(freedom: f64) -> f64 {
    let law = StudentsT::new(0.0, 1.0, freedom);
    law.map_or(f64::INFINITY, |law| law.inverse_cdf(0.5 + 0.5 * CONFIDENCE))
}

/// How a time series of residuals is cut into blocks that are independent of each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// Integrated correlation time in samples: `1 + 2 Σ ρ_k`.
    pub correlation: f64,
    /// Number of blocks.
    pub blocks: usize,
    /// Whether the residuals are correlated over so much of the recording that even the
    /// fewest blocks are not independent: intervals are then too narrow.
    pub is_slow: bool,
}

impl Spread {
    /// Looks at residuals of so many numbers per sample, in order of time.
    pub(super) fn of<const N: usize>(residuals: &[[f64; N]]) -> Self {
        let correlation = correlation_time(residuals, |rho| rho);
        let independent = residuals.len() as f64 / (TIMES * correlation);
        Self {
            correlation,
            blocks: (independent as usize).clamp(FEWEST_BLOCKS, MOST_BLOCKS),
            is_slow: independent < FEWEST_BLOCKS as f64,
        }
    }

    /// Which block a sample is in.
    pub(super) fn block(&self, sample: usize, samples: usize) -> usize {
        sample * self.blocks / samples.max(1)
    }
}

/// Lags that are looked at one by one. Greater ones are in pairs of means of two samples, greater ones yet of
/// four, and so on: what is correlated so long changes little from one to the next, and the work is
/// proportional to the number of samples.
const LAGS: usize = 1024;

/// `1 + 2 Σ f(ρ_k)` of the autocorrelation, up to a lag of five times itself (Sokal's window): beyond
/// that the sum is noise.
pub(super) fn correlation_time<const N: usize>(
    residuals: &[[f64; N]],
    of: impl Fn(f64) -> f64,
) -> f64 {
    let count = residuals.len();
    let mut mean = [0.0; N];
    for residual in residuals {
        (0..N).for_each(|axis| mean[axis] += residual[axis] / count as f64);
    }
    let product =
        |a: &[f64; N], b: &[f64; N]| -> f64 { (0..N).map(|axis| a[axis] * b[axis]).sum() };
    let centred = residuals.iter();
    let mut series: Vec<[f64; N]> = centred
        .map(|of| std::array::from_fn(|axis| of[axis] - mean[axis]))
        .collect();
    let square: f64 = series.iter().map(|r| product(r, r)).sum();
    if !(square > 0.0) {
        return 1.0;
    }
    let (mut sum, mut width) = (1.0_f64, 1);
    let mut steps = 1..LAGS;
    loop {
        for step in steps {
            let lag = step * width;
            if lag >= count / 2 {
                return sum.max(1.0);
            }
            let pairs = series.iter().zip(&series[step..]);
            let covariance: f64 = pairs.map(|(a, b)| product(a, b)).sum();
            sum += 2.0 * width as f64 * of(covariance * width as f64 / square);
            if lag as f64 >= 5.0 * sum {
                return sum.max(1.0);
            }
        }
        let mean_of = |pair: &[[f64; N]]| -> [f64; N] {
            std::array::from_fn(|axis| 0.5 * (pair[0][axis] + pair[1][axis]))
        };
        series = series.chunks_exact(2).map(mean_of).collect();
        width *= 2;
        steps = LAGS / 2..LAGS;
    }
}

/// Covariance by the delete-block jackknife, `(K − 1)/K Σ (θ_(b) − θ)(θ_(b) − θ)ᵀ`.
pub(super) fn jackknife(whole: &DVector<f64>, without: &[DVector<f64>]) -> DMatrix<f64> {
    let blocks = without.len() as f64;
    let mut covariance = DMatrix::zeros(whole.len(), whole.len());
    for one in without {
        let change = one - whole;
        covariance += &change * change.transpose();
    }
    covariance * ((blocks - 1.0) / blocks)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;

    #[test]
    fn correlation_times_are_those_of_the_process() {
        // First-order autoregression: 1 + 2 Σ φ^k = (1 + φ)/(1 − φ).
        let mut random = Random::default();
        for phi in [0.0, 0.5, 0.9] {
            let mut x = 0.0;
            let series: Vec<[f64; 1]> = (0..20_000)
                .map(|_| {
                    x = phi * x + random.normal();
                    [x]
                })
                .collect();
            let time = correlation_time(&series, |rho| rho);
            let expected = (1.0 + phi) / (1.0 - phi);
            assert!((time / expected - 1.0).abs() < 0.25, "{phi}: {time}");
        }
    }

    /// Correlated over thousands of samples, of which there are many: as by the sum over every lag.
    #[test]
    fn long_correlations_are_found_by_their_means() {
        let mut random = Random::default();
        let (mut x, phi) = (0.0, 0.999);
        let series: Vec<[f64; 1]> = (0..60_000)
            .map(|_| {
                x = phi * x + random.normal();
                [x]
            })
            .collect();
        let square: f64 = {
            let mean = series.iter().map(|x| x[0]).sum::<f64>() / series.len() as f64;
            series.iter().map(|x| (x[0] - mean).powi(2)).sum()
        };
        let mean = series.iter().map(|x| x[0]).sum::<f64>() / series.len() as f64;
        let every = |of: fn(f64) -> f64| {
            let mut sum = 1.0;
            for lag in 1..series.len() / 2 {
                let pairs = series.iter().zip(&series[lag..]);
                let covariance: f64 = pairs.map(|(a, b)| (a[0] - mean) * (b[0] - mean)).sum();
                sum += 2.0 * of(covariance / square);
                if lag as f64 >= 5.0 * sum {
                    break;
                }
            }
            sum
        };
        for of in [(|rho| rho) as fn(f64) -> f64, |rho| rho * rho] {
            let (found, expected) = (correlation_time(&series, of), every(of));
            assert!(expected > 300.0, "{expected} is short");
            assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
        }
    }

    #[test]
    fn what_wanders_as_slowly_as_it_is_long_is_said() {
        let mut random = Random::default();
        let mut x = 0.0;
        let walk: Vec<[f64; 1]> = (0..600)
            .map(|_| {
                x += random.normal();
                [x]
            })
            .collect();
        assert!(Spread::of(&walk).is_slow);
        let white: Vec<[f64; 1]> = (0..600).map(|_| [random.normal()]).collect();
        let spread = Spread::of(&white);
        assert!(
            !spread.is_slow && spread.blocks == MOST_BLOCKS,
            "{spread:?}"
        );
        assert_eq!(quantile(0.0), f64::INFINITY);
        assert!((quantile(10.0) - 2.228).abs() < 1e-3);
    }
}
