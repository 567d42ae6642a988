//! What errors of the samples may be: white noise, and a wander of the hand over them.
//!
//! Means over bins of samples have, series by series and axis by axis, the covariance `V = σ² N⁻¹ + a² K`, with the
//! white noise's variance `σ²` as second differences show it. One performance does not tell shape and size of a wander, so
//! several are weighed, by their restricted likelihood (Patterson and Thompson, Biometrika 58, 1971) of the residuals
//! beyond what the motion may follow:
//!
//! ```text
//! A = (J Z)ᵀ V⁻¹ J Z,   P = V⁻¹ − V⁻¹ J Z A⁻¹ (J Z)ᵀ V⁻¹
//! log L = −½ (log |V| + log |A| − log |(J Z)ᵀ J Z| + rᵀ P r)
//! ```

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::linear::{self, Linear};
use crate::estimate::adequacy::hand::{self, EXPONENTS};
use crate::estimate::covariance::bins::{Bin, Bins, Residuals};
use crate::estimate::covariance::noise;
use crate::estimate::tree::program::REGULARISER;
use crate::estimate::wander::series::Series;

/// Greatest number of bins of a series, and of all.
const BINS: [usize; 2] = [32, 64];
/// Sizes of a wander, in weights of the samples: a hand strays by no more than ten.
const SIZES: [f64; 7] = [0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0];
/// Least variance of white noise, in squared weights: what numbers in files are rounded to.
const LEAST: f64 = 1e-10;

/// How a wander's errors at two times go together.
#[derive(Clone, Copy, Debug)]
enum WanderShape {
    /// As a hand's do that acts so many times as slowly as the motion is.
    Hand(f64),
    /// As those of a filter, or of what a scene leaves out, with this correlation time \[s\].
    Rough(f64),
}

const SHAPES: [WanderShape; 3] = [
    WanderShape::Hand(1.0),
    WanderShape::Hand(3.0),
    WanderShape::Rough(0.1),
];

/// Bins of one series.
struct Binned {
    bins: Bins,
    kind: usize,
    /// Rows of each bin's samples.
    rows: Vec<Vec<usize>>,
    /// Variance of white noise.
    white: f64,
}

/// One covariance.
struct ErrorModel {
    log_prior: f64,
    /// Of each series.
    factors: Vec<Cholesky<f64, Dyn>>,
    log_determinant: f64,
}

/// Errors of the samples of a motion.
pub(super) struct TreeErrors {
    binned: Vec<Binned>,
    /// The first is white noise alone.
    models: Vec<ErrorModel>,
    /// Rows of priors, which follow those of samples.
    first_prior: usize,
}

/// What is left under one model beyond what the motion may follow.
pub(super) struct Left {
    /// Which one.
    model: usize,
    /// Logarithm of prior and restricted likelihood.
    pub(super) log: f64,
    /// `[U r]ᵀ P [U r]`.
    pub(super) products: DMatrix<f64>,
}

impl TreeErrors {
    /// As the residuals of a motion may be.
    pub(super) fn new(linear: &Linear) -> Self {
        let most = (BINS[1] / linear.series.len().max(1)).min(BINS[0]).max(1);
        let series = linear.series.iter();
        let binned: Vec<Binned> = series.map(|of| Binned::new(of, linear, most)).collect();
        let share = (SHAPES.len() * SIZES.len()) as f64;
        let wanders = SHAPES
            .iter()
            .flat_map(|shape| SIZES.map(|size| Some((*shape, size))));
        let all = std::iter::once(None).chain(wanders);
        let models = all.filter_map(|wander| {
            let mut factors = Vec::new();
            for of in &binned {
                factors.push(of.covariance(wander).cholesky()?);
            }
            let logs = factors
                .iter()
                .map(|factor| 6.0 * factor.l_dirty().diagonal().map(f64::ln).sum());
            Some(ErrorModel {
                log_prior: wander.map_or(0.0, |_| -share.ln()),
                log_determinant: logs.sum(),
                factors,
            })
        });
        Self {
            models: models.collect(),
            binned,
            first_prior: linear.sample_rows(),
        }
    }

    /// Degrees of freedom of the estimates of white noise.
    pub(super) fn degrees(&self) -> f64 {
        // Each second difference of three samples tells about half of what a sample would.
        let counts = self.binned.iter().map(|of| {
            let samples: usize = of.bins.bins.iter().map(|bin| bin.samples).sum();
            samples.saturating_sub(2)
        });
        1.5 * counts.sum::<usize>() as f64
    }

    /// What white noise leaves of the objective.
    pub(super) fn floor(&self) -> f64 {
        let each = self.binned.iter().map(|of| {
            let samples: usize = of.bins.bins.iter().map(|bin| bin.samples).sum();
            1.5 * samples as f64 * of.white
        });
        each.sum()
    }

    /// Root mean square distance \[m\] and angle \[rad\] that white noise makes of samples of these series.
    pub(super) fn white_rms(&self, series: &[Series]) -> [f64; 2] {
        let mut whites = self.binned.iter().map(|of| of.white);
        let squares: Vec<f64> = series
            .iter()
            .map(|of| 3.0 * of.rows.len() as f64 * whites.next().unwrap_or_default())
            .collect();
        linear::rms(series, |of| {
            let at = series.iter().position(|other| other == of);
            at.map_or(0.0, |at| squares[at])
        })
    }

    /// What is left under every model of columns and of residuals, where the motion follows `free`; `information` is
    /// that of a squared unit.
    pub(super) fn left(
        &self,
        free: &DMatrix<f64>,
        columns: &[DVector<f64>],
        residuals: &DVector<f64>,
        information: f64,
    ) -> Vec<Left> {
        let mut all = free.clone();
        all = all.resize_horizontally(free.ncols() + columns.len() + 1, 0.0);
        for (at, column) in columns.iter().enumerate() {
            all.set_column(free.ncols() + at, column);
        }
        all.set_column(free.ncols() + columns.len(), residuals);
        let scale = {
            let mut square = free.tr_mul(free);
            regularise(&mut square, information);
            square.cholesky().map_or(0.0, |of| of.ln_determinant())
        };
        let binned: Vec<[DMatrix<f64>; 3]> = self.binned.iter().map(|of| of.means(&all)).collect();
        let priors = all.rows(self.first_prior, all.nrows() - self.first_prior);
        let of_priors = priors.tr_mul(&priors);
        let count = free.ncols();
        let models = self.models.iter().enumerate();
        let models = models.filter_map(|(index, model)| {
            let mut gram = of_priors.clone();
            for (means, factor) in binned.iter().zip(&model.factors) {
                for axis in means {
                    let mut white = axis.clone();
                    factor.l_dirty().solve_lower_triangular_mut(&mut white);
                    gram.gemm_tr(1.0, &white, &white, 1.0);
                }
            }
            let others = gram.ncols() - count;
            let mut followed = gram.view((0, 0), (count, count)).into_owned();
            regularise(&mut followed, information);
            let across = gram.view((0, count), (count, others)).into_owned();
            let followed = followed.cholesky()?;
            let kept = gram.view((count, count), (others, others))
                - across.tr_mul(&followed.solve(&across));
            let square = kept[(others - 1, others - 1)];
            let log = model.log_prior
                - 0.5 * (model.log_determinant + followed.ln_determinant() - scale + square);
            Some(Left {
                model: index,
                log,
                products: kept,
            })
        });
        models.collect()
    }

    /// Variance of what responds so to each row, with the covariance that the models have in the mean, as the residuals make
    /// them likely: `yᵀ Σ y`, of rows of priors as they are.
    pub(super) fn variance(&self, left: &[Left], response: &DVector<f64>) -> f64 {
        let best = left
            .iter()
            .map(|of| of.log)
            .fold(f64::NEG_INFINITY, f64::max);
        let (mut sum, mut weights) = (0.0, 0.0);
        for of in left {
            let model = &self.models[of.model];
            let weight = (of.log - best).exp();
            weights += weight;
            sum += weight * self.variance_if(model, response);
        }
        let priors = response.rows(self.first_prior, response.len() - self.first_prior);
        sum / weights + priors.norm_squared()
    }

    /// The part of samples, under one model.
    fn variance_if(&self, model: &ErrorModel, response: &DVector<f64>) -> f64 {
        let mut sum = 0.0;
        for (of, factor) in self.binned.iter().zip(&model.factors) {
            let mut sums = DMatrix::zeros(of.rows.len(), 3);
            for (bin, rows) in of.rows.iter().enumerate() {
                for (row, axis) in rows
                    .iter()
                    .flat_map(|row| [0, 1, 2].map(|axis| (row, axis)))
                {
                    let by = response[row + axis];
                    sums[(bin, axis)] += by;
                    sum += of.white * by * by;
                }
            }
            // `L Lᵀ` has the white noise of each bin's mean, which is counted sample by sample.
            sum += (factor.l().transpose() * &sums).norm_squared();
            for (row, bin) in sums.row_iter().zip(&of.bins.bins) {
                sum -= of.white / bin.samples as f64 * row.norm_squared();
            }
        }
        sum
    }

    /// Number of binned rows and of priors.
    pub(super) fn row_count(&self, linear: &Linear) -> usize {
        let bins: usize = self.binned.iter().map(|of| of.bins.count()).sum();
        3 * bins + linear.residuals.len() - self.first_prior
    }
}

/// Holds what nothing tells.
pub(super) fn regularise(matrix: &mut DMatrix<f64>, information: f64) {
    for at in 0..matrix.nrows() {
        matrix[(at, at)] += REGULARISER * information;
    }
}

impl Binned {
    fn new(series: &Series, linear: &Linear, most: usize) -> Self {
        let kinds = [series.kind == 0, series.kind == 1];
        let count = series.rows.len();
        let bins_count = count.min(most);
        let mut bins: Vec<Bin> = Vec::new();
        let mut rows: Vec<Vec<usize>> = vec![Vec::new(); bins_count];
        let mut of_samples = Vec::new();
        let mut each = Vec::new();
        for (index, row) in series.rows.iter().enumerate() {
            let bin = index * bins_count / count;
            rows[bin].push(*row);
            of_samples.push(bin);
            let mut six = [0.0; 6];
            for axis in 0..3 {
                six[3 * series.kind + axis] = linear.residuals[row + axis];
            }
            each.push(six);
        }
        let mut samples = series.taken.iter().map(|of| &of.time_s);
        for rows in &rows {
            let times = samples.by_ref().take(rows.len());
            let time_s = times.sum::<f64>() / rows.len() as f64;
            bins.push(Bin {
                track: series.track,
                kinds,
                time_s,
                acted_s: time_s,
                samples: rows.len(),
            });
        }
        let span_s = series.taken[count - 1].time_s - series.taken[0].time_s;
        let white = noise::white(&[Residuals { kinds, each }])[series.kind];
        Self {
            bins: Bins {
                bins,
                of_samples,
                flight_s: span_s,
            },
            kind: series.kind,
            rows,
            white: white.max(LEAST),
        }
    }

    fn covariance(&self, wander: Option<(WanderShape, f64)>) -> DMatrix<f64> {
        let bins = &self.bins.bins;
        let mut covariance = match wander {
            Some((WanderShape::Hand(slowness), size)) => {
                let mut acted = self.bins.clone();
                for bin in &mut acted.bins {
                    bin.acted_s = slowness * bin.time_s;
                }
                hand::correlation(&acted, EXPONENTS[self.kind]) * (size * size)
            }
            Some((WanderShape::Rough(time_s), size)) => {
                DMatrix::from_fn(bins.len(), bins.len(), |a, b| {
                    let apart_s = (bins[a].time_s - bins[b].time_s).abs();
                    size * size * (-apart_s / time_s).exp()
                })
            }
            None => DMatrix::zeros(bins.len(), bins.len()),
        };
        for (at, bin) in bins.iter().enumerate() {
            covariance[(at, at)] += self.white / bin.samples as f64;
        }
        covariance
    }

    /// Means over the bins of columns over all rows, axis by axis.
    fn means(&self, columns: &DMatrix<f64>) -> [DMatrix<f64>; 3] {
        [0, 1, 2].map(|axis| {
            DMatrix::from_fn(self.rows.len(), columns.ncols(), |bin, column| {
                let rows = self.rows[bin].iter();
                let sum: f64 = rows.map(|row| columns[(row + axis, column)]).sum();
                sum / self.rows[bin].len() as f64
            })
        })
    }
}
