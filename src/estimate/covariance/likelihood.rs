//! How likely the residuals are under white noise and a wander of one size and shape.
//!
//! The residuals' means `r` in the bins have the covariance `S = a² K + σ² N⁻¹`, `N` the numbers of
//! samples, less what the fit has absorbed: `A`, the tangent directions as the bins see them. The
//! restricted likelihood (REML; Patterson and Thompson, Biometrika 58, 1971) is that of all
//! contrasts that the fit cannot touch:
//!
//! ```text
//! −2 log L = log|S| + log|G| + rᵀS⁻¹r − hᵀG⁻¹h,    G = AᵀS⁻¹A,  h = AᵀS⁻¹r
//! ```
//!
//! With `S` of block shape, positions and orientations by themselves and their axes alike, `G`,
//! `h` and `rᵀS⁻¹r` are sums over both kinds: entries of one Gram matrix of `[A r]`, whose
//! Cholesky factor holds everything.

/// Columns `[A r]` of one kind: `rows[bin][axis]` of so many columns each.
pub struct Columns {
    bins: usize,
    count: usize,
    rows: Vec<f64>,
}

/// What the likelihood needs of one kind under one covariance.
pub struct Gram {
    /// `[A r]ᵀ S⁻¹ [A r]`, row by row.
    entries: Vec<f64>,
    /// `log|S|` over the three axes.
    log_determinant: f64,
}

impl Columns {
    /// From columns that have three axes in every bin, the residual's last.
    pub fn new<'c>(columns: impl ExactSizeIterator<Item = &'c [[f64; 6]]>, kind: usize) -> Self {
        let count = columns.len();
        let mut rows = Vec::new();
        let mut bins = 0;
        for (index, column) in columns.enumerate() {
            bins = column.len();
            rows.resize(3 * bins * count, 0.0);
            for (bin, six) in column.iter().enumerate() {
                for axis in 0..3 {
                    rows[(3 * bin + axis) * count + index] = six[3 * kind + axis];
                }
            }
        }
        Self { bins, count, rows }
    }

    /// Under the covariance `S` of the bins, row by row; `None` where it is not positive definite.
    pub fn gram(&self, covariance: &[f64]) -> Option<Gram> {
        let (bins, width) = (self.bins, 3 * self.count);
        let mut factor = covariance.to_vec();
        let determinant = factorise(&mut factor, bins)?;
        let mut rows = self.rows.clone();
        for bin in 0..bins {
            let (before, rest) = rows.split_at_mut(bin * width);
            let row = &mut rest[..width];
            for (other, earlier) in before.chunks_exact(width).enumerate() {
                let share = factor[bin * bins + other];
                for (entry, earlier) in row.iter_mut().zip(earlier) {
                    *entry -= share * earlier;
                }
            }
            let scale = factor[bin * bins + bin].recip();
            row.iter_mut().for_each(|entry| *entry *= scale);
        }
        let mut entries = vec![0.0; self.count * self.count];
        for row in rows.chunks_exact(self.count) {
            for (at, left) in row.iter().enumerate() {
                let into = &mut entries[at * self.count..][..=at];
                for (entry, right) in into.iter_mut().zip(row) {
                    *entry += left * right;
                }
            }
        }
        Some(Gram {
            entries,
            log_determinant: 3.0 * determinant,
        })
    }
}

/// The logarithm of the restricted likelihood of both kinds' residuals, up to a constant.
pub fn log_likelihood(kinds: [&Gram; 2]) -> f64 {
    let [a, b] = kinds;
    let size = (a.entries.len() as f64).sqrt().round() as usize;
    let mut sum: Vec<f64> = a
        .entries
        .iter()
        .zip(&b.entries)
        .map(|(a, b)| a + b)
        .collect();
    let rest = size - 1;
    let square = sum[rest * size + rest];
    // The last pivot is what of the residual's square the fit leaves.
    sum[rest * size + rest] += 1e-12 * square + f64::MIN_POSITIVE;
    let Some(all) = factorise(&mut sum, size) else {
        return f64::NEG_INFINITY;
    };
    let left = sum[rest * size + rest].powi(2);
    let absorbed = all - left.ln();
    -0.5 * (a.log_determinant + b.log_determinant + absorbed + left)
}

/// Cholesky's factor in the lower triangle, and the logarithm of the determinant.
fn factorise(matrix: &mut [f64], size: usize) -> Option<f64> {
    let mut determinant = 0.0;
    for row in 0..size {
        let (above, rest) = matrix.split_at_mut(row * size);
        let current = &mut rest[..size];
        for column in 0..row {
            let other = &above[column * size..][..size];
            let product: f64 = (0..column).map(|k| current[k] * other[k]).sum();
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
