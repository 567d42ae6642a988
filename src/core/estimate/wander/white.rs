//! Rows whose errors are independent, and what they add up to.

use nalgebra::{DMatrix, DMatrixView, Dyn};

/// Rows that are kept until they are summed.
const KEPT: usize = 512;

/// Products of all pairs of columns, `WᵀW`, over rows that come three for each sample.
#[derive(Clone, Debug)]
pub struct WhiteProducts {
    gram: DMatrix<f64>,
    /// Number of the first columns that are in use: the others are zero until now.
    used: usize,
    /// Rows that are not in it yet, one after the other.
    rows: Vec<f64>,
}

impl WhiteProducts {
    /// Of no rows, with so many columns.
    pub fn new(columns: usize) -> Self {
        Self {
            gram: DMatrix::zeros(columns, columns),
            used: columns,
            rows: Vec::new(),
        }
    }

    /// Begins again with so many columns, and gives the products until now.
    pub fn restart(&mut self, columns: usize) -> DMatrix<f64> {
        self.sum();
        self.used = columns;
        std::mem::replace(&mut self.gram, DMatrix::zeros(columns, columns))
    }

    /// Says how many of the first columns are in use from now on.
    pub fn use_first(&mut self, columns: usize) {
        if self.used != columns {
            self.sum();
            self.used = columns;
        }
    }

    /// Adds the rows of a sample, given column by column, of those in use.
    pub fn push(&mut self, numbers: &[f64]) {
        for axis in 0..3 {
            self.rows.extend(numbers.iter().skip(axis).step_by(3));
        }
        if self.rows.len() >= KEPT * self.used {
            self.sum();
        }
    }

    /// The products.
    pub fn gram(mut self) -> DMatrix<f64> {
        self.sum();
        self.gram
    }

    fn sum(&mut self) {
        let columns = self.used;
        let count = self.rows.len() / columns.max(1);
        if count == 0 {
            return;
        }
        // As two views of the same numbers: blocked, as a product with the transposed factor first is not.
        let transposed = DMatrixView::from_slice(&self.rows, columns, count);
        let rows = DMatrixView::<f64, Dyn, Dyn>::from_slice_with_strides(
            &self.rows, count, columns, columns, 1,
        );
        let mut gram = self.gram.view_mut((0, 0), (columns, columns));
        gram.gemm(1.0, &transposed, &rows, 1.0);
        self.rows.clear();
    }
}
