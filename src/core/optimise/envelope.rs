//! Cholesky factorisation `A = L Lᵀ` of sparse symmetric matrices in envelope (skyline) storage.
//!
//! Row `i` of the lower triangle is stored from its first possible nonzero to the diagonal
//! (its envelope), and the factor has no nonzeros outside it (George and Liu, *Computer Solution
//! of Large Sparse Positive Definite Systems*, chapter 4). Ordered along time, the normal
//! matrix of an estimation is a band with a few long rows for the unknowns that all arcs share, so
//! that the cost is linear in the number of arcs and of samples, without a symbolic phase.

use nalgebra::DVector;
use thiserror::Error;

/// The envelope: where the rows of the lower triangle begin. Fixed once per problem.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern {
    /// First column of every row.
    first: Vec<usize>,
    /// Position of the row's diagonal in the storage.
    diagonal: Vec<usize>,
}

impl Pattern {
    /// The envelope that holds the couplings `(i, j)` and the diagonal.
    pub fn new(size: usize, couplings: impl IntoIterator<Item = (usize, usize)>) -> Self {
        let mut first: Vec<usize> = (0..size).collect();
        for (i, j) in couplings {
            let (row, column) = (i.max(j), i.min(j));
            first[row] = first[row].min(column);
        }
        let mut diagonal = Vec::with_capacity(size);
        let mut length = 0;
        for (row, column) in first.iter().enumerate() {
            length += row - column + 1;
            diagonal.push(length - 1);
        }
        Self { first, diagonal }
    }

    /// Number of unknowns.
    pub fn size(&self) -> usize {
        self.first.len()
    }

    /// Number of stored entries.
    pub fn stored(&self) -> usize {
        self.diagonal.last().map_or(0, |last| last + 1)
    }
}

/// A symmetric matrix within a [`Pattern`], or its Cholesky factor.
#[derive(Clone, Debug)]
pub struct Envelope {
    values: Vec<f64>,
    /// Reciprocals of the factor's diagonal, once factorised.
    inverse: Vec<f64>,
}

/// The matrix is not positive definite.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("pivot {pivot:e} of row {row} is not positive")]
pub struct NotPositiveDefinite {
    /// Row of the first pivot that is not positive.
    pub row: usize,
    /// That pivot; NaN where an entry is.
    pub pivot: f64,
}

impl Envelope {
    /// A zero matrix.
    pub fn zeros(pattern: &Pattern) -> Self {
        Self {
            values: vec![0.0; pattern.stored()],
            inverse: vec![0.0; pattern.size()],
        }
    }

    /// Sets every entry to zero.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Copies the entries of another matrix of the same pattern.
    pub fn copy_from(&mut self, other: &Envelope) {
        self.values.copy_from_slice(&other.values);
    }

    /// Adds to the entry at row `i`, column `j ≤ i` (its mirror is the same entry).
    ///
    /// # Panics
    /// In debug builds, where the entry lies outside the envelope.
    #[inline]
    pub fn add(&mut self, pattern: &Pattern, i: usize, j: usize, value: f64) {
        debug_assert!(
            j <= i && j >= pattern.first[i],
            "({i}, {j}) outside the envelope"
        );
        self.values[pattern.diagonal[i] + j - i] += value;
    }

    /// Row `i` of the lower triangle within the envelope, and its first column.
    #[inline]
    pub fn row_mut(&mut self, pattern: &Pattern, i: usize) -> (usize, &mut [f64]) {
        let (first, diagonal) = (pattern.first[i], pattern.diagonal[i]);
        (first, &mut self.values[diagonal + first - i..=diagonal])
    }

    /// The entry at row `i`, column `j ≤ i`.
    pub fn get(&self, pattern: &Pattern, i: usize, j: usize) -> f64 {
        if j < pattern.first[i] {
            0.0
        } else {
            self.values[pattern.diagonal[i] + j - i]
        }
    }

    /// The entries as rows, columns (`column ≤ row`) and values.
    pub fn triplets<'s>(
        &'s self,
        pattern: &'s Pattern,
    ) -> impl Iterator<Item = (usize, usize, f64)> + 's {
        (0..pattern.size()).flat_map(move |row| {
            (pattern.first[row]..=row)
                .map(move |column| (row, column, self.get(pattern, row, column)))
        })
    }

    /// Replaces the matrix by its Cholesky factor `L`, `A = L Lᵀ`. Fails at the first pivot that is
    /// not positive; the matrix is then partly overwritten.
    pub fn factorise(&mut self, pattern: &Pattern) -> Result<(), NotPositiveDefinite> {
        self.factorise_repaired(pattern, |_, _| None)
    }

    /// [`Envelope::factorise`] of the matrix with shifts on its diagonal: of a row whose pivot is
    /// negative `shift(row, pivot)` may raise it. Fails where the pivot is not positive then.
    pub fn factorise_repaired(
        &mut self,
        pattern: &Pattern,
        mut shift: impl FnMut(usize, f64) -> Option<f64>,
    ) -> Result<(), NotPositiveDefinite> {
        for row in 0..pattern.size() {
            let first = pattern.first[row];
            let start = pattern.diagonal[row] + first - row;
            let (above, rest) = self.values.split_at_mut(start);
            let current = &mut rest[..=row - first];
            let columns = pattern.first[first..row].iter();
            let columns = columns.zip(&pattern.diagonal[first..row]);
            for (index, ((column_first, diagonal), inverse)) in
                columns.zip(&self.inverse[first..row]).enumerate()
            {
                // Entries of this row before the column, as far as that column's row reaches.
                let skipped = column_first.saturating_sub(first);
                let (before, entry) = current.split_at_mut(index);
                let reached = &before[skipped..];
                let product = dot(reached, &above[diagonal - reached.len()..*diagonal]);
                entry[0] = (entry[0] - product) * inverse;
            }
            let (off_diagonal, pivot) = current.split_at_mut(row - first);
            let mut value = pivot[0] - dot(off_diagonal, off_diagonal);
            if value < 0.0 {
                value += shift(row, value).unwrap_or(0.0);
            }
            // Written so that NaN fails too.
            if !(value > 0.0) {
                return Err(NotPositiveDefinite { row, pivot: value });
            }
            pivot[0] = value.sqrt();
            self.inverse[row] = pivot[0].recip();
        }
        Ok(())
    }

    /// Solves `L Lᵀ x = b` in place, given the factor.
    pub fn solve(&self, pattern: &Pattern, b: &mut DVector<f64>) {
        let b = b.as_mut_slice();
        for row in 0..pattern.size() {
            let first = pattern.first[row];
            let diagonal = pattern.diagonal[row];
            let length = row - first;
            let product = dot(&self.values[diagonal - length..diagonal], &b[first..row]);
            b[row] = (b[row] - product) / self.values[diagonal];
        }
        for row in (0..pattern.size()).rev() {
            let first = pattern.first[row];
            let diagonal = pattern.diagonal[row];
            let value = b[row] / self.values[diagonal];
            b[row] = value;
            for (x, l) in b[first..row]
                .iter_mut()
                .zip(&self.values[diagonal + first - row..])
            {
                *x -= l * value;
            }
        }
    }

    /// `y += A x` for a matrix that is not factorised.
    pub fn multiply_add(&self, pattern: &Pattern, x: &DVector<f64>, y: &mut DVector<f64>) {
        let (x, y) = (x.as_slice(), y.as_mut_slice());
        for row in 0..pattern.size() {
            let first = pattern.first[row];
            let diagonal = pattern.diagonal[row];
            let values = &self.values[diagonal + first - row..diagonal];
            y[row] += dot(values, &x[first..row]) + self.values[diagonal] * x[row];
            for (entry, value) in y[first..row].iter_mut().zip(values) {
                *entry += value * x[row];
            }
        }
    }
}

/// `a·b` in four partial sums, whose additions do not wait for each other.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (fours_a, tail_a) = a.as_chunks::<4>();
    let (fours_b, tail_b) = b.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (x, y) in fours_a.iter().zip(fours_b) {
        for k in 0..4 {
            sums[k] += x[k] * y[k];
        }
    }
    let mut sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
    for (x, y) in tail_a.iter().zip(tail_b) {
        sum += x * y;
    }
    sum
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;

    /// A positive definite chain of blocks with two rows that couple to everything.
    fn example() -> (Pattern, Envelope, DMatrix<f64>) {
        let size = 40usize;
        let mut couplings = Vec::new();
        for i in 0..size {
            for j in i.saturating_sub(5)..i {
                couplings.push((i, j));
            }
        }
        couplings.extend((0..size - 2).flat_map(|j| [(size - 2, j), (j, size - 1)]));
        let pattern = Pattern::new(size, couplings.iter().copied());
        let mut matrix = Envelope::zeros(&pattern);
        let mut dense = DMatrix::zeros(size, size);
        let mut put = |i: usize, j: usize, value: f64| {
            matrix.add(&pattern, i.max(j), i.min(j), value);
            dense[(i, j)] += value;
            if i != j {
                dense[(j, i)] += value;
            }
        };
        for (k, (i, j)) in couplings.iter().enumerate() {
            put(*i, *j, ((k * 7919) % 13) as f64 / 13.0 - 0.5);
        }
        for i in 0..size {
            put(i, i, 30.0 + i as f64);
        }
        (pattern, matrix, dense)
    }

    #[test]
    fn rows_are_those_of_the_matrix() {
        let (pattern, mut matrix, dense) = example();
        for i in 0..pattern.size() {
            let (first, row) = matrix.row_mut(&pattern, i);
            assert_eq!(first + row.len(), i + 1);
            for (entry, j) in row.iter().zip(first..) {
                assert_eq!(*entry, dense[(i, j)], "({i}, {j})");
            }
        }
    }

    #[test]
    fn solves_as_a_dense_factorisation_does() {
        let (pattern, mut matrix, dense) = example();
        let b = DVector::from_fn(pattern.size(), |i, _| (i as f64).sin());
        let expected = dense.cholesky().unwrap().solve(&b);
        matrix.factorise(&pattern).unwrap();
        let mut x = b.clone();
        matrix.solve(&pattern, &mut x);
        assert!((x - expected).norm() < 1e-14);
    }

    #[test]
    fn multiplies_as_a_dense_matrix_does() {
        let (pattern, matrix, dense) = example();
        let x = DVector::from_fn(pattern.size(), |i, _| (i as f64).cos());
        let mut y = DVector::zeros(pattern.size());
        matrix.multiply_add(&pattern, &x, &mut y);
        assert!((y - dense * x).norm() < 1e-12);
    }

    #[test]
    fn a_shift_of_the_pivot_is_one_of_the_diagonal() {
        let (pattern, mut matrix, mut dense) = example();
        matrix.add(&pattern, 17, 17, -1e3);
        dense[(17, 17)] -= 1e3;
        let mut shifts = Vec::new();
        let repaired = matrix.factorise_repaired(&pattern, |row, pivot| {
            shifts.push((row, -2.0 * pivot));
            Some(-2.0 * pivot)
        });
        repaired.unwrap();
        let [(17, shift)] = shifts[..] else {
            panic!("{shifts:?}")
        };
        dense[(17, 17)] += shift;
        let b = DVector::from_fn(pattern.size(), |i, _| (i as f64).sin());
        let mut x = b.clone();
        matrix.solve(&pattern, &mut x);
        assert!((dense * x - b).norm() < 1e-12);
    }

    #[test]
    fn refuses_what_is_not_positive_definite_and_what_is_not_a_number() {
        let (pattern, mut matrix, _) = example();
        matrix.add(&pattern, 17, 17, -1e3);
        assert_eq!(matrix.factorise(&pattern).unwrap_err().row, 17);
        let (pattern, mut matrix, _) = example();
        matrix.add(&pattern, 3, 2, f64::NAN);
        assert_eq!(matrix.factorise(&pattern).unwrap_err().row, 3);
    }
}
