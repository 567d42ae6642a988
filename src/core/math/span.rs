//! Spans of columns.

use nalgebra::{ColPivQR, DMatrix, DVector, Dyn};

/// The span of some columns, and what is orthogonal to it: from the QR decomposition with pivoting of
/// the columns at unit length.
pub struct Span {
    /// `None` without columns.
    decomposed: Option<ColPivQR<f64, Dyn, Dyn>>,
    rows: usize,
    rank: usize,
}

impl Span {
    /// The span of columns with that many `rows`; directions whose pivot is `dependent` or less are
    /// left out, and with them columns that are zero.
    pub fn of(columns: &[DVector<f64>], rows: usize, dependent: f64) -> Self {
        let unit = |column: &DVector<f64>| column.clone().try_normalize(0.0);
        let columns: Vec<DVector<f64>> = columns.iter().filter_map(unit).collect();
        let decomposed =
            (!columns.is_empty()).then(|| DMatrix::from_columns(&columns).col_piv_qr());
        let rank = decomposed.as_ref().map_or(0, |decomposed| {
            let pivots = decomposed.r();
            let most = pivots.nrows().min(pivots.ncols());
            let rank = (0..most).take_while(|at| pivots[(*at, *at)].abs() > dependent);
            rank.count()
        });
        Self {
            decomposed,
            rows,
            rank,
        }
    }

    /// Its number of dimensions.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// An orthonormal basis, column by column.
    pub fn basis(&self) -> DMatrix<f64> {
        match &self.decomposed {
            Some(decomposed) => decomposed.q().columns(0, self.rank).into_owned(),
            None => DMatrix::zeros(self.rows, 0),
        }
    }

    /// Coordinates of columns along an orthonormal basis of what is orthogonal to the span.
    pub fn beyond(&self, mut columns: DMatrix<f64>) -> DMatrix<f64> {
        if let Some(decomposed) = &self.decomposed {
            decomposed.q_tr_mul(&mut columns);
        }
        columns.remove_rows(0, self.rank)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_depends_on_others_adds_nothing() {
        let column = |entries: [f64; 4]| DVector::from_row_slice(&entries);
        let columns = [
            column([1e-9, 0.0, 0.0, 2e-9]),
            column([0.0; 4]),
            column([0.0, 3e6, 0.0, 0.0]),
            column([1.0, -5.0, 0.0, 2.0]),
        ];
        let span = Span::of(&columns, 4, 1e-6);
        let basis = span.basis();
        assert_eq!((basis.shape(), span.rank()), ((4, 2), 2));
        let gram = basis.tr_mul(&basis);
        assert!((gram - DMatrix::identity(2, 2)).amax() < 1e-15);
        for column in &columns {
            let within = &basis * basis.tr_mul(column);
            assert!((within - column).norm() <= 1e-15 * (1.0 + column.norm()));
        }
    }

    #[test]
    fn what_is_beyond_a_span_keeps_its_length() {
        let column = |entries: [f64; 4]| DVector::from_row_slice(&entries);
        let columns = [
            column([1.0, 2.0, 0.0, -1.0]),
            column([0.5, 1.0, 0.0, -0.5]),
            column([0.0, 0.3, 1.0, 4.0]),
        ];
        let span = Span::of(&columns, 4, 1e-9);
        let all = DMatrix::from_fn(4, 3, |row, column| ((7 * row + 3 * column) as f64).sin());
        let beyond = span.beyond(all.clone());
        assert_eq!(beyond.shape(), (2, 3));
        let basis = span.basis();
        let left = &all - &basis * basis.tr_mul(&all);
        assert!((beyond.tr_mul(&beyond) - left.tr_mul(&left)).amax() < 1e-14);
    }

    #[test]
    fn nothing_spans_nothing() {
        let span = Span::of(&[], 3, 1e-6);
        assert_eq!(span.basis().shape(), (3, 0));
        assert_eq!(
            span.beyond(DMatrix::identity(3, 3)),
            DMatrix::identity(3, 3)
        );
    }
}
