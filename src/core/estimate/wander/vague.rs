//! What residuals leave open of the errors they have: a hand's size and pace are told by a few contrasts only.
//!
//! With the numbers `θ` of a process, by their logarithms, normal about the likeliest ones with a covariance from second
//! derivatives of `−2 log L`, an answer `x(θ)` of variance `A⁻¹(θ)` has on the whole the variance
//!
//! ```text
//! E A⁻¹ + cov x ≈ A⁻¹ + Σ_k ½ Σ_± [A⁻¹(±σ_k) − A⁻¹ + δx δxᵀ]
//! ```
//!
//! along the principal axes of that covariance (Kass and Steffey, Journal of the American Statistical Association 84, 1989).

use nalgebra::{DMatrix, SymmetricEigen};

use super::likelihood::{FittedErrors, Restricted};
use super::process::{LogProcess, Process};

/// Step of second differences.
const STEP: f64 = 0.1;
/// The farthest that a number is taken to be off, by its logarithm: where nothing tells it, the least usual hands would rule.
const FARTHEST: f64 = 0.5;
/// Of the numbers of a process, those of a hand; noise is told by every sample.
const OF_HAND: usize = 4;

impl Restricted<'_> {
    /// What the variance of the free directions is more for that; `None` where nothing strays, and where a number is none.
    pub fn vague(&self, processes: &[Process; 2]) -> Option<DMatrix<f64>> {
        let kinds = (0..2).filter(|kind| self.rows.shows(*kind) && processes[*kind].wanders());
        let numbers: Vec<[usize; 2]> = kinds
            .flat_map(|kind| (0..OF_HAND).map(move |number| [kind, number]))
            .collect();
        let size = numbers.len();
        let at = |off: &[f64]| {
            let mut logs: [LogProcess; 2] = processes.map(|of| of.logs());
            for ([kind, number], off) in numbers.iter().zip(off) {
                logs[*kind][*number] += off;
            }
            self.at(&logs.map(|of| Process::of_logs(&of)))
        };
        if size == 0 {
            return None;
        }
        let here = self.at(processes)?;
        let merit = |off: &[(usize, f64)]| {
            let mut all = vec![0.0; size];
            for (number, by) in off {
                all[*number] += by;
            }
            Some(at(&all)?.merit)
        };
        let mut ahead = Vec::new();
        let mut curvature = DMatrix::zeros(size, size);
        for number in 0..size {
            let (next, before) = (merit(&[(number, STEP)])?, merit(&[(number, -STEP)])?);
            curvature[(number, number)] = (next + before - 2.0 * here.merit) / (STEP * STEP);
            ahead.push(next);
        }
        for row in 0..size {
            for column in 0..row {
                let both = merit(&[(row, STEP), (column, STEP)])?;
                let mixed = both - ahead[row] - ahead[column] + here.merit;
                curvature[(row, column)] = mixed / (STEP * STEP);
                curvature[(column, row)] = curvature[(row, column)];
            }
        }
        let axes = SymmetricEigen::new(curvature);
        let variance = here.information.inverse();
        let mut more = DMatrix::zeros(self.free, self.free);
        for (axis, curvature) in axes.eigenvectors.column_iter().zip(axes.eigenvalues.iter()) {
            let least = 2.0 / (FARTHEST * FARTHEST);
            let sd = (2.0 / curvature.max(least)).sqrt();
            for side in [-sd, sd] {
                let off: Vec<f64> = axis.iter().map(|along| side * along).collect();
                more += 0.5 * (at(&off)?.apart(&here) - &variance);
            }
        }
        Some(more)
    }
}

impl FittedErrors {
    /// Variance of the free directions about another answer.
    fn apart(&self, other: &Self) -> DMatrix<f64> {
        let off = &self.answer - &other.answer;
        self.information.inverse() + &off * off.transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::wander::filter::SampleInstant;
    use crate::estimate::wander::series::{Series, SeriesRows};
    use crate::math::random::Random;
    use crate::motion::TrackIndex;

    /// Samples of noise about a constant, each axis with its own.
    fn about_constant(samples: usize) -> SeriesRows {
        let mut random = Random::default();
        let taken = (0..samples).map(|at| SampleInstant {
            time_s: 0.03 * at as f64,
            noise_variance: 0.0,
        });
        let series = Series {
            track: TrackIndex(0),
            kind: 0,
            taken: taken.collect(),
            rows: (0..samples).map(|row| 3 * row).collect(),
            unit: 1.0,
        };
        let columns = DMatrix::from_fn(3 * samples, 4, |row, column| match column {
            3 => random.normal(),
            axis => f64::from(u8::from(row % 3 == axis)),
        });
        SeriesRows::new(&[series], &columns)
    }

    /// A variance is more where samples show a wander, by a share that the farthest numbers bound, and no more where none strays.
    #[test]
    fn a_variance_is_more_for_what_is_open_of_a_size() {
        let rows = about_constant(60);
        let priors = DMatrix::zeros(4, 4);
        let of = Restricted {
            rows: &rows,
            free: 3,
            priors: &priors,
            least: 0.0,
        };
        let fitted = of.likeliest(&[Process::EXPECTED; 2]).expect("a likelihood");
        let more = of.vague(&fitted.processes).expect("a hand");
        let variance = fitted.information.inverse();
        for axis in 0..3 {
            let share = more[(axis, axis)] / variance[(axis, axis)];
            // At most each of four numbers by half, in its logarithm.
            assert!((0.01..4.0).contains(&share), "{share}");
        }
        let still = fitted.processes.map(|of| of.without_wander());
        assert!(of.vague(&still).is_none());
    }
}
