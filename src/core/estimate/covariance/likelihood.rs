//! Likelihood of the residuals under white noise and a wander of given size and shape.
//!
//! The residuals' means `r` in the bins have the covariance `S = a² K + σ² N⁻¹`, with the numbers
//! of samples `N`, projected by the fit along the columns of `A`: the tangent directions of the
//! free unknowns in the bins. The restricted likelihood (REML; Patterson and Thompson, Biometrika
//! 58, 1971) is that of all contrasts that the fit cannot change:
//!
//! ```text
//! −2 log L = log|S| + log|G| + rᵀS⁻¹r − hᵀG⁻¹h,    G = AᵀS⁻¹A,  h = AᵀS⁻¹r
//! ```
//!
//! `S` is taken as diagonal in the cosine basis of each track's bins, which is nearly true of
//! processes whose correlation falls with the distance (Whittle's likelihood, 1953). Each size and
//! shape then costs a sum over frequencies. `S` is block-diagonal, with positions and orientations
//! independent and their axes equal, so that `G`, `h` and `rᵀS⁻¹r` are entries of one Gram matrix
//! of `[A r]`, a sum over both kinds, and follow from its Cholesky factor.

use std::f64::consts::PI;
use std::ops::Range;

use super::bins::Bins;

/// The cosine basis (DCT II) of the bins, track by track.
pub struct Cosines {
    /// For every frequency: the bins of its track, and its values there, of unit norm.
    frequencies: Vec<(Range<usize>, Vec<f64>)>,
    /// Number of all bins.
    bins: usize,
}

impl Cosines {
    /// The basis of the bins that show one kind, ordered by track.
    pub fn new(bins: &Bins, kind: usize) -> Self {
        let mut frequencies = Vec::with_capacity(bins.count());
        let mut first = 0;
        for track in bins
            .bins
            .chunk_by(|a, b| (a.track, a.kinds) == (b.track, b.kinds))
        {
            let count = track.len();
            let seen = if track[0].kinds[kind] { count } else { 0 };
            for frequency in 0..seen {
                let norm = if frequency == 0 { 1.0_f64 } else { 2.0 } / count as f64;
                let step = PI * frequency as f64 / count as f64;
                let values = (0..count).map(|bin| norm.sqrt() * (step * (bin as f64 + 0.5)).cos());
                frequencies.push((first..first + count, values.collect()));
            }
            first += count;
        }
        Self {
            frequencies,
            bins: bins.count(),
        }
    }

    /// Variance at each frequency under a covariance of the bins, given row by row.
    pub fn variances(&self, covariance: &[f64]) -> Vec<f64> {
        let each = self.frequencies.iter().map(|(bins, values)| {
            let rows = bins.clone().zip(values);
            rows.map(|(row, left)| {
                let row = &covariance[row * self.bins..][bins.clone()];
                let pairs = row.iter().zip(values);
                left * pairs.map(|(entry, right)| entry * right).sum::<f64>()
            })
            .sum()
        });
        each.collect()
    }
}

/// Columns `[A r]` of one kind: `[A r]ᵀ [A r]` at each frequency, lower triangles row by row.
pub struct Columns {
    count: usize,
    squares: Vec<Vec<f64>>,
}

/// The Gram matrix of one kind of residual under one covariance.
pub struct Gram {
    count: usize,
    /// Lower triangle of `[A r]ᵀ S⁻¹ [A r]`, row by row.
    entries: Vec<f64>,
    /// `log|S|` over the three axes.
    log_determinant: f64,
}

impl Columns {
    /// The columns of one kind, with three axes in every bin; the residual is the last.
    pub fn new(cosines: &Cosines, columns: &[&[[f64; 6]]], kind: usize) -> Self {
        let count = columns.len();
        let mut row = vec![0.0; count];
        let squares = cosines.frequencies.iter().map(|(bins, values)| {
            let mut square = vec![0.0; count * (count + 1) / 2];
            for axis in 3 * kind..3 * kind + 3 {
                for (entry, column) in row.iter_mut().zip(columns) {
                    let pairs = column[bins.clone()].iter().zip(values);
                    *entry = pairs.map(|(six, value)| six[axis] * value).sum();
                }
                let mut rest = square.as_mut_slice();
                for (at, left) in row.iter().enumerate() {
                    let (own, after) = rest.split_at_mut(at + 1);
                    let pairs = own.iter_mut().zip(&row);
                    pairs.for_each(|(entry, right)| *entry += left * right);
                    rest = after;
                }
            }
            square
        });
        Self {
            squares: squares.collect(),
            count,
        }
    }

    /// The Gram matrix under given variances of the frequencies; `None` where one is not positive.
    pub fn gram(&self, variances: impl Iterator<Item = f64>) -> Option<Gram> {
        let mut entries = vec![0.0; self.count * (self.count + 1) / 2];
        let mut log_determinant = 0.0;
        for (square, variance) in self.squares.iter().zip(variances) {
            // Written so that NaN fails too.
            if !(variance > 0.0) {
                return None;
            }
            let weight = variance.recip();
            let pairs = entries.iter_mut().zip(square);
            pairs.for_each(|(entry, square)| *entry += weight * square);
            log_determinant += 3.0 * variance.ln();
        }
        Some(Gram {
            count: self.count,
            entries,
            log_determinant,
        })
    }
}

/// The logarithm of the restricted likelihood of both kinds' residuals, up to a constant.
pub fn log_likelihood(kinds: [&Gram; 2]) -> f64 {
    let [a, b] = kinds;
    let pairs = a.entries.iter().zip(&b.entries);
    let mut sum: Vec<f64> = pairs.map(|(a, b)| a + b).collect();
    let last = sum.len() - 1;
    // The last pivot is `rᵀS⁻¹r − hᵀG⁻¹h`.
    sum[last] += 1e-12 * sum[last] + f64::MIN_POSITIVE;
    let Some(all) = factorise(&mut sum, a.count) else {
        return f64::NEG_INFINITY;
    };
    let left = sum[last].powi(2);
    let absorbed = all - left.ln();
    -0.5 * (a.log_determinant + b.log_determinant + absorbed + left)
}

/// Cholesky's factor of a lower triangle, and the logarithm of the determinant.
fn factorise(triangle: &mut [f64], size: usize) -> Option<f64> {
    let start = |row: usize| row * (row + 1) / 2;
    let mut determinant = 0.0;
    for row in 0..size {
        let (above, rest) = triangle.split_at_mut(start(row));
        let current = &mut rest[..=row];
        for column in 0..row {
            let other = &above[start(column)..=start(column) + column];
            let pairs = current[..column].iter().zip(other);
            let product: f64 = pairs.map(|(a, b)| a * b).sum();
            current[column] = (current[column] - product) / other[column];
        }
        let square: f64 = current[..row].iter().map(|entry| entry * entry).sum();
        let pivot = current[row] - square;
        // Written so that NaN fails too.
        if !(pivot > 0.0) {
            return None;
        }
        current[row] = pivot.sqrt();
        determinant += pivot.ln();
    }
    Some(determinant)
}
