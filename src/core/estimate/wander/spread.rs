//! What errors that are a process make of sums of samples: their covariance `Yᵀ V Y`, in one pass.
//!
//! Of the kernels of a [process](super::process), with `d` from one sample to the next,
//!
//! ```text
//! smooth:  p ← e^{−λd} p + y,   q ← e^{−λd} (q + d p),   a² (p + λ q)
//! rough:   o ← e^{−d/m} o + y,   b² o
//! ```
//!
//! is what `V` without noise makes at a sample of all of them until then.

use nalgebra::{DMatrix, DVector};

use super::process::Process;
use super::series::Series;

/// The covariance of sums of samples: a column of factors for each, of which those of a series are in its rows.
pub fn spread(series: &[Series], columns: &DMatrix<f64>, processes: &[Process; 2]) -> DMatrix<f64> {
    let count = columns.ncols();
    let mut covariance = DMatrix::zeros(count, count);
    for of in series {
        let process = &processes[of.kind];
        let variance = process.covariance(0.0);
        for axis in 0..3 {
            let mut past = PastFactors::new(count);
            let mut last_s = f64::NEG_INFINITY;
            for (taken, row) in of.taken.iter().zip(&of.rows) {
                let factors = columns.row(row + axis).transpose();
                past.go_on(process, taken.time_s - last_s, &factors);
                last_s = taken.time_s;
                let until = past.summed(process);
                let own = process.noise_sd.powi(2) + taken.noise_variance - variance;
                covariance.ger(1.0, &factors, &until, 1.0);
                covariance.ger(1.0, &until, &factors, 1.0);
                covariance.ger(own, &factors, &factors, 1.0);
            }
        }
    }
    covariance
}

/// Factors of samples until now, as far as they still count.
struct PastFactors {
    smooth: DVector<f64>,
    smooth_rate: DVector<f64>,
    rough: DVector<f64>,
}

impl PastFactors {
    fn new(count: usize) -> Self {
        let none = DVector::zeros(count);
        Self {
            smooth: none.clone(),
            smooth_rate: none.clone(),
            rough: none,
        }
    }

    /// Goes on to a sample, so long after the one before \[s\].
    fn go_on(&mut self, process: &Process, after_s: f64, factors: &DVector<f64>) {
        if after_s.is_finite() {
            let smooth = (-process.rate_per_s() * after_s).exp();
            self.smooth_rate
                .axpy(after_s * smooth, &self.smooth, smooth);
            self.smooth *= smooth;
            self.rough *= (-after_s / process.rough_s).exp();
        }
        self.smooth += factors;
        self.rough += factors;
    }

    fn summed(&self, process: &Process) -> DVector<f64> {
        let (smooth, rough) = (process.smooth_sd.powi(2), process.rough_sd.powi(2));
        (&self.smooth + &self.smooth_rate * process.rate_per_s()) * smooth + &self.rough * rough
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::wander::filter::SampleInstant;
    use crate::math::random::Random;
    use crate::motion::TrackIndex;

    /// Against the sum over all pairs of samples.
    #[test]
    fn it_is_the_sum_over_all_pairs() {
        let mut random = Random::default();
        let processes = [0.7, 1.3].map(|size| Process {
            smooth_sd: size,
            smooth_s: 0.4,
            rough_sd: 0.3,
            rough_s: 0.1,
            noise_sd: 0.05,
        });
        let samples = 25;
        let series = [0, 1].map(|kind| Series {
            track: TrackIndex(0),
            kind,
            taken: (0..samples)
                .map(|at| SampleInstant {
                    time_s: 0.03 * at as f64 + 0.01 * random.signed(),
                    noise_variance: 0.01 * at as f64,
                })
                .collect(),
            rows: (0..samples).map(|at| 3 * (samples * kind + at)).collect(),
            unit: 1.0,
        });
        let columns = DMatrix::from_fn(6 * samples, 3, |_, _| random.signed());
        let mut expected = DMatrix::zeros(3, 3);
        for of in &series {
            let process = &processes[of.kind];
            for (one, one_row) in of.taken.iter().zip(&of.rows) {
                for (other, other_row) in of.taken.iter().zip(&of.rows) {
                    let noise = process.noise_sd.powi(2) + one.noise_variance;
                    let own = if one_row == other_row { noise } else { 0.0 };
                    let apart_s = (one.time_s - other.time_s).abs();
                    let both = process.covariance(apart_s) + own;
                    let rows = [one_row, other_row].map(|row| columns.rows(*row, 3));
                    expected += rows[0].transpose() * rows[1] * both;
                }
            }
        }
        let off = (spread(&series, &columns, &processes) - &expected).amax();
        assert!(off < 1e-10 * expected.amax(), "{off}");
    }
}
