//! How certain the estimate is: the inverse of the Hessian on the constraints' tangent space.
//!
//! With residuals that are independent and of one unit, the covariance of the unknowns is
//! `Z (Zᵀ H Z)⁻¹ Zᵀ`, `Z` spanning the directions the constraints leave free; it is the limit
//! of `(H + w JᵀJ)⁻¹` for large `w`, and the finish has that matrix factorised. It is scaled
//! by the mean square residual, so that the unit of the weights does not matter, and by the
//! time over which residuals stay alike: a hand wanders smoothly, so that a hundred samples of
//! it know no more than the few wanders they span.

use nalgebra::{DMatrix, DVector};

use super::finish::{DAMPING, Kkt};
use super::system::{Frame, System};

/// Share of an unknown's information that may come from the damping before it counts as
/// undetermined.
const DAMPING_SHARE_MAX: f64 = 0.1;

/// Covariances at an optimum.
pub struct Covariance<'a> {
    frame: &'a Frame<'a>,
    system: &'a System,
    kkt: Kkt,
    /// Mean square residual per degree of freedom, times [`correlation_samples`].
    pub variance_factor: f64,
}

/// Samples over which residuals stay alike: `1 + 2 Σ ρ_k`, with the autocorrelation `ρ_k` of the
/// residuals along their arcs at `k` samples' distance, summed while it stands out from what
/// white noise would show. One for white noise.
pub fn correlation_samples(arcs: &[Vec<[f64; 6]>]) -> f64 {
    let square: f64 = arcs.iter().flatten().flatten().map(|r| r * r).sum();
    let count: usize = arcs.iter().map(|arc| 6 * arc.len()).sum();
    if square <= 0.0 {
        return 1.0;
    }
    let correlation = |lag: usize| {
        let pairs = arcs
            .iter()
            .flat_map(|arc| arc.iter().zip(arc.iter().skip(lag)));
        let products = pairs.map(|(a, b)| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>());
        products.sum::<f64>() / square
    };
    let longest = arcs.iter().map(Vec::len).max().unwrap_or(0);
    let noise = 2.0 / (count as f64).sqrt();
    let (mut samples, mut last, mut before) = (1.0, 0, 1.0);
    loop {
        // Ever longer lags, linear between them: the cost stays near that of one pass.
        let lag = last + (last / 4).max(1);
        if 2 * lag > longest {
            return samples;
        }
        let now = correlation(lag);
        if now < noise {
            return samples;
        }
        samples += (lag - last) as f64 * (before + now) + (now - before);
        (last, before) = (lag, now);
    }
}

impl<'a> Covariance<'a> {
    /// `None` where the matrix cannot be factorised.
    ///
    /// `residuals` are those of every sample, arc by arc, in units.
    pub fn new(
        frame: &'a Frame<'a>,
        system: &'a System,
        multipliers: &[f64],
        residuals: &[Vec<[f64; 6]>],
    ) -> Option<Self> {
        let kkt = Kkt::new(frame, system, multipliers)?;
        let problem = frame.problem;
        let tempo_rows = if problem.times_are_unknown() {
            problem.nodes_acted_s.len().saturating_sub(2)
        } else {
            0
        };
        let priors = problem
            .parameters
            .iter()
            .filter(|free| free.prior_sd.is_some())
            .count();
        let rows = 6 * problem.sample_count() + tempo_rows + priors + kkt.acting_rows();
        let freedom = rows as f64 - frame.layout.size() as f64;
        let mean_square = if freedom >= 1.0 {
            2.0 * system.cost / freedom
        } else {
            1.0
        };
        let variance_factor = mean_square * correlation_samples(residuals);
        Some(Self {
            frame,
            system,
            kkt,
            variance_factor,
        })
    }

    /// Covariance of the unknowns `at`, in their units.
    pub fn of(&self, at: &[usize]) -> DMatrix<f64> {
        let mut result = DMatrix::zeros(at.len(), at.len());
        for (column, unknown) in at.iter().enumerate() {
            let mut x = DVector::zeros(self.frame.layout.size());
            x[*unknown] = 1.0;
            self.kkt.solve(self.frame, &mut x);
            for (row, other) in at.iter().enumerate() {
                result[(row, column)] = self.variance_factor * x[*other];
            }
        }
        result
    }

    /// Standard deviation of one unknown; `None` where the performance does not determine it.
    pub fn sd(&self, at: usize) -> Option<f64> {
        self.sd_of(&[(at, 1.0)])
    }

    /// Standard deviation of a sum of unknowns, each with its factor; `None` where the performance
    /// does not determine it.
    pub fn sd_of(&self, sum: &[(usize, f64)]) -> Option<f64> {
        let mut x = DVector::zeros(self.frame.layout.size());
        for (at, factor) in sum {
            x[*at] += factor;
        }
        self.kkt.solve(self.frame, &mut x);
        let square: f64 = sum.iter().map(|(at, factor)| factor * x[*at]).sum();
        let pattern = &self.frame.layout.pattern;
        // What the damping alone would leave of the sum.
        let held: f64 = sum
            .iter()
            .map(|(at, factor)| {
                let damping = DAMPING * (1.0 + self.system.hessian.get(pattern, *at, *at));
                factor * factor / damping
            })
            .sum();
        let determined = square < DAMPING_SHARE_MAX * held;
        determined.then(|| (self.variance_factor * square).max(0.0).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A repeatable stand-in for noise, uniform in ±1.
    fn noise(count: usize) -> Vec<f64> {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        (0..count)
            .map(|_| {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
            })
            .collect()
    }

    #[test]
    fn white_residuals_count_one_by_one() {
        let values = noise(6 * 400);
        let arc: Vec<[f64; 6]> = values
            .chunks_exact(6)
            .map(|six| std::array::from_fn(|i| six[i]))
            .collect();
        let samples = correlation_samples(&[arc[..200].to_vec(), arc[200..].to_vec()]);
        assert!((samples - 1.0).abs() < 0.15, "{samples}");
    }

    #[test]
    fn residuals_that_stay_alike_count_by_their_spans() {
        let values = noise(6 * 100);
        // Each value lasts ten samples: the sum over lags is 1 + 2·(0.9 + … + 0.1) = 10.
        let arc: Vec<[f64; 6]> = (0..1000)
            .map(|sample| std::array::from_fn(|i| values[6 * (sample / 10) + i]))
            .collect();
        // Six hundred independent values leave about a fifth.
        let samples = correlation_samples(&[arc]);
        assert!((samples - 10.0).abs() < 2.5, "{samples}");
    }

    #[test]
    fn a_perfect_fit_has_nothing_to_correlate() {
        assert_eq!(correlation_samples(&[vec![[0.0; 6]; 20]]), 1.0);
        assert_eq!(correlation_samples(&[]), 1.0);
    }
}
