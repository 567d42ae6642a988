//! Spans of columns.

use nalgebra::{DMatrix, DVector};

/// An orthonormal basis of the span of columns with that many `rows`, from the QR decomposition with
/// pivoting of the columns at unit length: directions whose pivot is `dependent` or less are left out,
/// and with them columns that are zero.
pub fn orthonormal(columns: &[DVector<f64>], rows: usize, dependent: f64) -> DMatrix<f64> {
    let unit = |column: &DVector<f64>| column.clone().try_normalize(0.0);
    let columns: Vec<DVector<f64>> = columns.iter().filter_map(unit).collect();
    if columns.is_empty() {
        return DMatrix::zeros(rows, 0);
    }
    let decomposed = DMatrix::from_columns(&columns).col_piv_qr();
    let pivots = decomposed.r();
    let most = pivots.nrows().min(pivots.ncols());
    let rank = (0..most).take_while(|at| pivots[(*at, *at)].abs() > dependent);
    decomposed.q().columns(0, rank.count()).into_owned()
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
        let basis = orthonormal(&columns, 4, 1e-6);
        assert_eq!(basis.shape(), (4, 2));
        let gram = basis.tr_mul(&basis);
        assert!((gram - DMatrix::identity(2, 2)).amax() < 1e-15);
        for column in &columns {
            let within = &basis * basis.tr_mul(column);
            assert!((within - column).norm() <= 1e-15 * (1.0 + column.norm()));
        }
        assert_eq!(orthonormal(&[], 3, 1e-6).shape(), (3, 0));
    }
}
