//! A hand's wander as the flights by themselves show it.
//!
//! Means of the residuals over bins of some samples each have the covariance
//!
//! ```text
//! a² K + σ² N⁻¹,   K_ij = Σ_f P(f) cos 2πf(t_i − t_j)/Σ_f P(f),   P(f) ~ f⁻ᵖ from 0.2 to 4 Hz
//! ```
//!
//! with the hand's spectrum `P` over acted time, as measured on a camera held in the hand (positions
//! `p = 4`, orientations `p = 3`, without a corner above 0.2 Hz), the white noise's variance `σ²` and the numbers of
//! samples `N`. The wander's size `a` is not determined well by a take, so that sizes are weighted by their restricted
//! likelihood (Patterson and Thompson, Biometrika 58, 1971) and the mean covariance is used; none is beyond what any hand
//! strays. One flight tells next to nothing of it, so that there sizes are weighted, too, by how usual they are for the
//! scene's weights. Directions that the flights' own fits absorb are left out of the likelihood.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use crate::estimate::covariance::bins::{Bin, Bins, Six};
use crate::math::span::Span;

/// Band of a hand's wander \[Hz\], and the exponents of its power for positions and orientations.
const BAND_HZ: [f64; 2] = [0.2, 4.0];
pub(in crate::estimate) const EXPONENTS: [f64; 2] = [4.0, 3.0];
/// Number of frequencies for the band.
const LINES: usize = 12;
/// Sizes of the wander, in standard deviations of a sample's white noise.
const SIZES: [f64; 9] = [1.0, 2.5, 6.0, 16.0, 40.0, 100.0, 250.0, 600.0, 1600.0];

/// Greatest size of a hand's wander \[m\] \[rad\], and of one that a scene expects to stray farther than a usual hand
/// in units of its weights: what would need a hand that strays by more is no hand's doing.
const MOST: [f64; 2] = [0.5, 5.0];
const MOST_UNITS: f64 = 50.0;

/// Which sizes of a wander are expected before anything is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Expected {
    /// Any.
    Any,
    /// Those of a usual hand, in the scene's weights.
    Usual,
}

/// Size of a usual hand's wander, in units of the scene's weights, and the spread of its logarithm.
const USUAL: f64 = 2.0;
const USUAL_SPREAD: f64 = 1.5;

/// A pivot below which a direction depends on others.
const DEPENDENT: f64 = 1e-6;

/// Covariance of one kind's residuals: white noise and wander.
pub(super) struct Wander {
    /// Correlations of the bins, row by row.
    correlation: DMatrix<f64>,
    /// Variance of the wander, in squared units.
    pub(super) variance: f64,
    /// Logarithm of the odds that there is a wander, given the flights by themselves.
    pub(super) log_odds: f64,
}

/// Position or orientation.
#[derive(Clone, Copy)]
pub(super) enum ResidualKind {
    Position = 0,
    Orientation = 1,
}

impl ResidualKind {
    pub(super) const ALL: [Self; 2] = [Self::Position, Self::Orientation];

    /// Its entries of a residual.
    pub(super) fn of(self, six: &Six) -> &[f64] {
        &six[3 * self as usize..][..3]
    }
}

impl Wander {
    /// The wander of one kind that the bins' mean residuals show, of which the directions `absorbed`
    /// are left out; `white` is the variance of a sample's white noise, and `unit` one unit \[m or rad\]. Sizes are as
    /// `expected`.
    pub(super) fn of(
        bins: &Bins,
        kind: ResidualKind,
        means: &[Six],
        absorbed: &[Vec<Six>],
        white: f64,
        unit: f64,
        expected: Expected,
    ) -> Self {
        let correlation = correlation(bins, EXPONENTS[kind as usize]);
        let floor = white.max(1e-18);
        let contrasts = Contrasts::new(bins, kind, &correlation, means, absorbed);
        let likelihood = |size: f64| contrasts.log_likelihood(floor, size * size);
        let none = likelihood(0.0);
        let most = (MOST[kind as usize] / unit).max(MOST_UNITS) / floor.sqrt();
        let sizes = SIZES.map(|size| size.min(most));
        let logs: Vec<f64> = sizes.iter().map(|size| likelihood(*size)).collect();
        let most = logs.iter().fold(none, |most, log| most.max(*log));
        let priors = sizes.map(|size| expected.density(size * floor.sqrt()));
        let all: f64 = priors.iter().sum();
        let weights = logs.iter().zip(priors);
        let weights: Vec<f64> = weights
            .map(|(log, prior)| (log - most).exp() * prior / all)
            .collect();
        let some: f64 = weights.iter().sum();
        let squares = weights.iter().zip(&sizes);
        let variance =
            squares.map(|(w, size)| w * size * size).sum::<f64>() / some.max(f64::MIN_POSITIVE);
        Self {
            correlation,
            variance: variance * floor,
            log_odds: some.ln() - (none - most),
        }
    }

    /// A wander of a given variance.
    pub(super) fn of_variance(bins: &Bins, kind: ResidualKind, variance: f64) -> Self {
        Self {
            correlation: correlation(bins, EXPONENTS[kind as usize]),
            variance,
            log_odds: 0.0,
        }
    }

    /// Slow errors of a tracker where there was no hand: as large as the scene's weights say, over half a flight.
    pub(super) fn of_tracker(bins: &Bins) -> Self {
        let time_s = (0.5 * bins.flight_s).max(f64::MIN_POSITIVE);
        let count = bins.count();
        let between = |a: &Bin, b: &Bin| match a.track == b.track {
            true => (-(a.time_s - b.time_s).abs() / time_s).exp(),
            false => 0.0,
        };
        Self {
            correlation: DMatrix::from_fn(count, count, |row, column| {
                between(&bins.bins[row], &bins.bins[column])
            }),
            variance: 1.0,
            log_odds: 0.0,
        }
    }

    /// Covariance of the means of two bins.
    pub(super) fn between(&self, row: usize, column: usize) -> f64 {
        self.variance * self.correlation[(row, column)]
    }

    /// `yᵀ Σ z` of the wander, of two weightings with the given sums over the bins.
    pub(super) fn covariance(&self, kind: ResidualKind, y: &[Six], z: &[Six]) -> f64 {
        let mut sum = 0.0;
        for (row, left) in y.iter().enumerate() {
            for (column, right) in z.iter().enumerate() {
                let pairs = kind.of(left).iter().zip(kind.of(right));
                sum += self.correlation[(row, column)] * pairs.map(|(a, b)| a * b).sum::<f64>();
            }
        }
        self.variance * sum
    }
}

impl Expected {
    /// Density of a wander's size, in units, up to a factor, over its logarithm.
    fn density(self, size: f64) -> f64 {
        let off = (size / USUAL).ln() / USUAL_SPREAD;
        match self {
            Self::Any => 1.0,
            Self::Usual => (-0.5 * off * off).exp(),
        }
    }
}

/// Correlations of the bins of each track under a power law.
pub(in crate::estimate) fn correlation(bins: &Bins, exponent: f64) -> DMatrix<f64> {
    let ratio = (BAND_HZ[1] / BAND_HZ[0]).powf(1.0 / LINES as f64);
    let lines: Vec<[f64; 2]> = (0..LINES)
        .map(|line| {
            let hz = BAND_HZ[0] * ratio.powf(line as f64 + 0.5);
            // Bandwidths are in proportion to the frequencies.
            [TAU * hz, hz.powf(1.0 - exponent)]
        })
        .collect();
    let total: f64 = lines.iter().map(|[_, power]| power).sum();
    let between = |lag_s: f64| -> f64 {
        let each = lines
            .iter()
            .map(|[rate, power]| power * (rate * lag_s).cos());
        each.sum::<f64>() / total
    };
    let count = bins.count();
    let mut correlation = DMatrix::identity(count, count);
    for (row, a) in bins.bins.iter().enumerate() {
        for (column, b) in bins.bins[..row].iter().enumerate() {
            if a.track == b.track {
                correlation[(row, column)] = between(a.acted_s - b.acted_s);
                correlation[(column, row)] = correlation[(row, column)];
            }
        }
    }
    correlation
}

/// What of the means is left by the directions that are absorbed, in coordinates in which its
/// covariance is diagonal whatever the size of the wander: with `Q` orthonormal and orthogonal to `N^½`
/// times those directions, and `Qᵀ N^½ K N^½ Q = U Λ Uᵀ`, the coordinates `Uᵀ Qᵀ N^½` of the means have
/// `a² Λ + σ²`.
struct Contrasts {
    values: DVector<f64>,
    /// `Λ`.
    shares: DVector<f64>,
}

impl Contrasts {
    fn new(
        bins: &Bins,
        kind: ResidualKind,
        correlation: &DMatrix<f64>,
        means: &[Six],
        absorbed: &[Vec<Six>],
    ) -> Self {
        let count = bins.count();
        // What a track does not show is as if it had no samples.
        let root = |row: usize| {
            let bin = &bins.bins[row % count];
            let is_seen = bin.kinds[kind as usize];
            if is_seen {
                (bin.samples as f64).sqrt()
            } else {
                0.0
            }
        };
        // Three axes, one below the other.
        let flat = |column: &[Six]| {
            DVector::from_fn(3 * count, |row, _| {
                kind.of(&column[row % count])[row / count] * root(row)
            })
        };
        let absorbed: Vec<DVector<f64>> = absorbed.iter().map(|column| flat(column)).collect();
        let span = Span::of(&absorbed, 3 * count, DEPENDENT);
        let wander = DMatrix::from_fn(3 * count, 3 * count, |row, column| {
            let is_same = row / count == column / count;
            let share = if is_same {
                correlation[(row % count, column % count)]
            } else {
                0.0
            };
            share * root(row) * root(column)
        });
        let left = span.beyond(DMatrix::from_columns(&[flat(means)]));
        if left.is_empty() {
            // Flights with so few samples fit whatever comes.
            return Self {
                values: DVector::zeros(0),
                shares: DVector::zeros(0),
            };
        }
        let wander = span.beyond(span.beyond(wander).transpose());
        let eigen = wander.symmetric_eigen();
        Self {
            values: eigen.eigenvectors.tr_mul(&left).column(0).into_owned(),
            shares: eigen.eigenvalues.map(|share| share.max(0.0)),
        }
    }

    /// The logarithm of their likelihood up to a constant, for a variance of the white noise and the
    /// wander's in units of it.
    fn log_likelihood(&self, white: f64, wander: f64) -> f64 {
        let each = self.values.iter().zip(&self.shares).map(|(value, share)| {
            let variance = 1.0 + wander * share;
            variance.ln() + value * value / (white * variance)
        });
        -0.5 * each.sum::<f64>()
    }
}
