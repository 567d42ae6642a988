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
use super::series::WhitenedProducts;

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
        let numbers: Vec<NumberOfHand> = kinds
            .flat_map(|kind| (0..OF_HAND).map(move |number| NumberOfHand { kind, number }))
            .collect();
        let size = numbers.len();
        if size == 0 {
            return None;
        }
        let of_kind = |kind: usize, off: &LogProcess| {
            let mut logs = processes[kind].logs();
            for (log, off) in logs.iter_mut().zip(off) {
                *log += off;
            }
            let process = Process::of_logs(&logs);
            KindOfErrors {
                products: self.rows.products(kind, &process),
                process,
            }
        };
        let with = |[one, other]: [&KindOfErrors; 2]| {
            let processes = [one.process, other.process];
            self.with(&processes, [&one.products, &other.products])
        };
        let still = [0, 1].map(|kind| of_kind(kind, &[0.0; Process::COUNT]));
        let here = with(still.each_ref())?;
        // One kind beside the other as it is.
        let merit = |kind: usize, off: &LogProcess| {
            let changed = of_kind(kind, off);
            let mut both = still.each_ref();
            both[kind] = &changed;
            let merit = with(both)?.merit;
            Some((changed, merit))
        };
        let mut ahead = Vec::new();
        let mut curvature = DMatrix::zeros(size, size);
        for (at, of) in numbers.iter().enumerate() {
            let (changed, next) = merit(of.kind, &of.off(STEP))?;
            let (_, before) = merit(of.kind, &of.off(-STEP))?;
            curvature[(at, at)] = (next + before - 2.0 * here.merit) / (STEP * STEP);
            ahead.push((changed, next));
        }
        for row in 0..size {
            for column in 0..row {
                let [(one, at_one), (other, at_other)] = [&ahead[column], &ahead[row]];
                let [first, second] = [numbers[column], numbers[row]];
                let both = match first.kind == second.kind {
                    true => {
                        let mut off = first.off(STEP);
                        off[second.number] = STEP;
                        merit(first.kind, &off)?.1
                    }
                    // Positions come first.
                    false => with([one, other])?.merit,
                };
                let mixed = both - at_one - at_other + here.merit;
                curvature[(row, column)] = mixed / (STEP * STEP);
                curvature[(column, row)] = curvature[(row, column)];
            }
        }
        let at = |off: &[f64]| {
            let mut of_kinds = [[0.0; Process::COUNT]; 2];
            for (of, off) in numbers.iter().zip(off) {
                of_kinds[of.kind][of.number] = *off;
            }
            let both = [0, 1].map(|kind| of_kind(kind, &of_kinds[kind]));
            with(both.each_ref())
        };
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

/// A number of a process of one kind of errors.
#[derive(Clone, Copy)]
struct NumberOfHand {
    kind: usize,
    number: usize,
}

impl NumberOfHand {
    /// It alone is off, by its logarithm.
    fn off(self, by: f64) -> LogProcess {
        let mut off = [0.0; Process::COUNT];
        off[self.number] = by;
        off
    }
}

/// Errors of one kind, and products of samples with them.
struct KindOfErrors {
    process: Process,
    products: WhitenedProducts,
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
    use crate::estimate::wander::likelihood::LikelyErrors;
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
        let fitted = of.likeliest(&LikelyErrors::EXPECTED).expect("a likelihood");
        let more = of.vague(&fitted.errors.processes).expect("a hand");
        let variance = fitted.information.inverse();
        for axis in 0..3 {
            let share = more[(axis, axis)] / variance[(axis, axis)];
            // At most each of four numbers by half, in its logarithm.
            assert!((0.01..4.0).contains(&share), "{share}");
        }
        let still = fitted.errors.processes.map(|of| of.without_wander());
        assert!(of.vague(&still).is_none());
    }
}
