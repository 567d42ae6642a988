//! Rows whose errors are independent, and what they add up to.

use nalgebra::DMatrix;

/// Rows that are kept until they are summed.
const KEPT: usize = 512;

/// Products of all pairs of columns, `WᵀW`, over rows that come three for each sample.
#[derive(Clone, Debug)]
pub struct WhiteProducts {
    gram: DMatrix<f64>,
    /// Rows that are not in it yet, one after the other.
    rows: Vec<f64>,
}

impl WhiteProducts {
    /// Of no rows, with so many columns.
    pub fn new(columns: usize) -> Self {
        Self {
            gram: DMatrix::zeros(columns, columns),
            rows: Vec::new(),
        }
    }

    /// Adds the rows of a sample, given column by column.
    pub fn push(&mut self, numbers: &[f64]) {
        for axis in 0..3 {
            self.rows.extend(numbers.iter().skip(axis).step_by(3));
        }
        if self.rows.len() >= KEPT * self.gram.ncols() {
            self.sum();
        }
    }

    /// The products.
    pub fn gram(mut self) -> DMatrix<f64> {
        self.sum();
        self.gram
    }

    fn sum(&mut self) {
        let columns = self.gram.ncols();
        let count = self.rows.len() / columns.max(1);
        let transposed = DMatrix::from_column_slice(columns, count, &self.rows);
        // Blocked, as a product with the transposed factor first is not.
        self.gram
            .gemm(1.0, &transposed, &transposed.transpose(), 1.0);
        self.rows.clear();
    }
}
