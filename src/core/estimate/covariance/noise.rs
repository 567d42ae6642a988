//! Covariance of the residuals: white noise, and the wander of a hand.
//!
//! The variance of white noise is estimated from second differences of neighbouring residuals,
//! `σ² = mean (r_{i−1} − 2 r_i + r_{i+1})²/6`, to which a slow wander contributes nothing. The
//! wander is a Gaussian process of unknown size, roughness and correlation time: Matérn's kernels
//! of order ½ and 5⁄2 with times from a third of a flight to five flights (a hand's power falls
//! with the third to fifth power of frequency, theirs with the second and sixth). One take does not
//! determine which, so none is selected: each is weighted by its restricted likelihood, and the
//! variance of an estimate is computed with the mean covariance `K̄`.

use super::bins::{Bins, Residuals, Six};
use super::likelihood::{Columns, Cosines, Gram, log_likelihood};
use super::trace::Trace;

/// Correlation times, in flights.
const TIMES: [f64; 3] = [0.3, 1.2, 5.0];
/// Variances of the wander, in mean square residuals. Of a slow wander, the fit absorbs a multiple
/// of what remains.
const SIZES: [f64; 4] = [0.125, 1.0, 8.0, 64.0];
/// Exponent of the prior of a variance. Few contrasts inform about the slowest wander, and their
/// likelihood is biased to small sizes; with a half, 95 % intervals hold (see
/// `tools/results`).
const PRIOR_POWER: f64 = 0.5;
/// Logarithm of the prior of no wander.
const PRIOR_NONE: f64 = 1.1;
/// Least number of contrasts after the fit, or residuals are not informative.
const CONTRASTS_MIN: usize = 6;

/// Roughness of a wander: Matérn's order.
#[derive(Clone, Copy, Debug)]
enum NoiseOrder {
    Half,
    FiveHalves,
}

impl NoiseOrder {
    const ALL: [Self; 2] = [Self::Half, Self::FiveHalves];

    /// Correlation at a distance, in correlation times.
    fn correlation(self, distance: f64) -> f64 {
        match self {
            Self::Half => (-distance).exp(),
            Self::FiveHalves => {
                let x = 5_f64.sqrt() * distance;
                (1.0 + x + x * x / 3.0) * (-x).exp()
            }
        }
    }
}

/// Covariance of residuals, of positions and of orientations, in squared units.
#[derive(Clone, Debug)]
pub struct Noise {
    /// Variance of the white part.
    pub white: [f64; 2],
    /// Covariance of the bins' wander, row by row; empty without wander.
    wander: [Vec<f64>; 2],
}

/// One covariance of one kind, with the residuals' Gram matrix under it.
struct NoiseCandidate {
    /// Index of the correlation.
    shape: usize,
    /// Variance of the wander.
    size: f64,
    log_prior: f64,
    gram: Gram,
}

impl Noise {
    /// White noise of one unit, as the weights state.
    pub fn stated() -> Self {
        Self::white_only([1.0; 2])
    }

    fn white_only(white: [f64; 2]) -> Self {
        Self {
            white,
            wander: [Vec::new(), Vec::new()],
        }
    }

    /// The covariance estimated from the residuals, of which the fit has absorbed the directions
    /// `absorbed`, orthonormal columns over the bins. [`Noise::stated`] where they are too few.
    pub fn of(bins: &Bins, residuals: &[Residuals], absorbed: &[Vec<Six>]) -> Self {
        if absorbed.len() + CONTRASTS_MIN > bins.dimension() {
            return Self::stated();
        }
        let white = white(residuals);
        let squares = mean_squares(residuals);
        let means = bins.mean_residuals(residuals);
        let shapes = shapes(bins);
        let columns = absorbed.iter().map(Vec::as_slice).chain([means.as_slice()]);
        let columns: Vec<&[Six]> = columns.collect();
        let is_same = bins.bins.iter().all(|bin| bin.kinds[0] == bin.kinds[1]);
        let spectra_of = |kind: usize| {
            let cosines = Cosines::new(bins, kind);
            let spectra = shapes.iter().map(|shape| cosines.variances(shape));
            let spectra: Vec<Vec<f64>> = spectra.collect();
            let per_sample = cosines.variances(&one_per_sample(bins));
            (cosines, spectra, per_sample)
        };
        let of_positions = spectra_of(0);
        let of_others = (!is_same).then(|| spectra_of(1));
        let of_orientations = of_others.as_ref().unwrap_or(&of_positions);
        let [positions, orientations] = [0, 1].map(|kind| {
            let of_kind = [&of_positions, of_orientations][kind];
            let (cosines, spectra, per_sample) = of_kind;
            let columns = Columns::new(cosines, &columns, kind);
            candidates(spectra, per_sample, &columns, white[kind], squares[kind])
        });
        if positions.is_empty() || orientations.is_empty() {
            return Self::white_only(squares);
        }
        let against = |one: &[NoiseCandidate], other: &NoiseCandidate| -> Vec<f64> {
            let each = one.iter();
            each.map(|one| one.log_prior + log_likelihood([&one.gram, &other.gram]))
                .collect()
        };
        // Positions and orientations are coupled only by what the fit absorbs, so each is weighted
        // with the best candidate of the other.
        let middle = &orientations[orientations.len() / 2];
        let of_positions = against(&positions, middle);
        let of_orientations = against(&orientations, &positions[largest(&of_positions)]);
        let weights = [of_positions, of_orientations];
        let is_told = |logs: &Vec<f64>| logs[largest(logs)].is_finite();
        if !weights.iter().all(is_told) {
            return Self::white_only(squares);
        }
        let mean = |candidates: &[NoiseCandidate], logs: &[f64]| {
            mean_covariance(&shapes, candidates, logs)
        };
        Self {
            white,
            wander: [
                mean(&positions, &weights[0]),
                mean(&orientations, &weights[1]),
            ],
        }
    }

    /// `K̄ y` of changes `y`, summed over bins.
    pub(super) fn strayed(&self, sums: &[Six]) -> Vec<Six> {
        let mut strayed = vec![[0.0; 6]; sums.len()];
        for (kind, wander) in self.wander.iter().enumerate() {
            for (row, strayed) in wander.chunks_exact(sums.len()).zip(&mut strayed) {
                for (entry, sum) in row.iter().zip(sums) {
                    for axis in 3 * kind..3 * kind + 3 {
                        strayed[axis] += entry * sum[axis];
                    }
                }
            }
        }
        strayed
    }

    /// `yᵀ Σ y`: variance of the sum of all residuals, weighted by `trace`.
    pub fn variance(&self, trace: &Trace) -> f64 {
        let sums = &trace.sums;
        let of_kind = |kind: usize| {
            let rows = self.wander[kind].chunks_exact(sums.len());
            let wander: f64 = rows
                .zip(sums)
                .map(|(row, left)| {
                    let pairs = row.iter().zip(sums);
                    let dot = |right: &Six| -> f64 {
                        (3 * kind..3 * kind + 3)
                            .map(|axis| left[axis] * right[axis])
                            .sum()
                    };
                    pairs.map(|(entry, right)| entry * dot(right)).sum::<f64>()
                })
                .sum();
            self.white[kind] * trace.squares[kind] + wander
        };
        of_kind(0) + of_kind(1)
    }
}

/// Correlations of the bins, row by row, for every roughness and time. Bodies wander independently.
fn shapes(bins: &Bins) -> Vec<Vec<f64>> {
    let all = NoiseOrder::ALL.iter().flat_map(|order| {
        let count = bins.count();
        TIMES.map(|time| {
            let time_s = time * bins.flight_s;
            let mut shape = vec![0.0; count * count];
            for (row, a) in bins.bins.iter().enumerate() {
                shape[row * count + row] = 1.0;
                let before = bins.bins[..row].iter().enumerate();
                for (column, b) in before.filter(|(_, b)| b.track == a.track && time_s > 0.0) {
                    let entry = order.correlation((a.time_s - b.time_s).abs() / time_s);
                    shape[row * count + column] = entry;
                    shape[column * count + row] = entry;
                }
            }
            shape
        })
    });
    all.collect()
}

/// Covariance of the bins' means of white noise of variance one, row by row.
fn one_per_sample(bins: &Bins) -> Vec<f64> {
    let count = bins.count();
    let mut covariance = vec![0.0; count * count];
    for (bin, of) in bins.bins.iter().enumerate() {
        covariance[bin * count + bin] = (of.samples as f64).recip();
    }
    covariance
}

/// The candidates: every size of every shape, and no wander.
fn candidates(
    spectra: &[Vec<f64>],
    per_sample: &[f64],
    columns: &Columns,
    white: f64,
    square: f64,
) -> Vec<NoiseCandidate> {
    // Keeps variances positive where there is no noise at all.
    let floor = 1e-9 * square + 1e-300;
    let candidate = |shape: usize, size: f64, log_prior: f64| {
        let each = spectra[shape].iter().zip(per_sample);
        let variances = each.map(|(wander, one)| size * wander + white * one + floor);
        Some(NoiseCandidate {
            shape,
            size,
            log_prior,
            gram: columns.gram(variances)?,
        })
    };
    let wanders = (0..spectra.len()).flat_map(|shape| SIZES.map(|size| (shape, size)));
    let wanders = wanders
        .filter_map(|(shape, size)| candidate(shape, size * square, PRIOR_POWER * size.ln()));
    let none = PRIOR_NONE + (spectra.len() as f64).ln();
    wanders.chain(candidate(0, 0.0, none)).collect()
}

/// The mean covariance of the candidates, weighted by prior and likelihood.
fn mean_covariance(shapes: &[Vec<f64>], candidates: &[NoiseCandidate], logs: &[f64]) -> Vec<f64> {
    let most = logs[largest(logs)];
    let weights: Vec<f64> = logs.iter().map(|log| (log - most).exp()).collect();
    let total: f64 = weights.iter().sum();
    let mut mean = vec![0.0; shapes[0].len()];
    for (candidate, weight) in candidates.iter().zip(&weights) {
        let size = candidate.size * weight / total;
        for (mean, entry) in mean.iter_mut().zip(&shapes[candidate.shape]) {
            *mean += size * entry;
        }
    }
    mean
}

fn largest(values: &[f64]) -> usize {
    let all = values.iter().enumerate();
    all.max_by(|a, b| a.1.total_cmp(b.1))
        .map_or(0, |(at, _)| at)
}

/// Mean square residuals of positions and of orientations, per axis; zero where none are seen.
pub(in crate::estimate) fn mean_squares(residuals: &[Residuals]) -> [f64; 2] {
    let of_each = residuals.iter().map(|of| (of.kinds, of.each.iter()));
    mean_of_squares(of_each)
}

/// Variance of white noise: a sixth of the mean square of second differences along the views, or the
/// mean square residual where none has three samples.
pub(in crate::estimate) fn white(residuals: &[Residuals]) -> [f64; 2] {
    let second = |three: &[Six]| -> Six {
        std::array::from_fn(|axis| three[0][axis] - 2.0 * three[1][axis] + three[2][axis])
    };
    let differences = residuals.iter();
    let differences = differences.map(|of| (of.kinds, of.each.windows(3).map(second)));
    let of_differences = mean_of_squares(differences).map(|square| square / 6.0);
    let of_all = mean_squares(residuals);
    [0, 1].map(|kind| {
        let has_three = |of: &Residuals| of.kinds[kind] && of.each.len() >= 3;
        if residuals.iter().any(has_three) {
            of_differences[kind]
        } else {
            of_all[kind]
        }
    })
}

fn mean_of_squares<S: std::borrow::Borrow<Six>>(
    series: impl Iterator<Item = ([bool; 2], impl Iterator<Item = S>)>,
) -> [f64; 2] {
    let (mut counts, mut sums) = ([0_usize; 2], [0.0; 2]);
    for (kinds, each) in series {
        for six in each {
            for kind in 0..2 {
                counts[kind] += usize::from(kinds[kind]);
            }
            for (axis, value) in six.borrow().iter().enumerate() {
                sums[axis / 3] += value * value;
            }
        }
    }
    [0, 1].map(|kind| sums[kind] / (3 * counts[kind].max(1)) as f64)
}
