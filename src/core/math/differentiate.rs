//! Numeric differentiation, to check derivatives that are given by formulas.

/// Derivative of `f: R^columns → R^rows` at zero, `[row][column]`, by central differences
/// with three Richardson extrapolations from a step of 0.02: the truncation error is of eighth
/// order, so that smooth functions of unit scale come out to about 1e-11.
pub fn jacobian(rows: usize, columns: usize, f: impl Fn(&[f64]) -> Vec<f64>) -> Vec<Vec<f64>> {
    let mut result = vec![vec![0.0; columns]; rows];
    for column in 0..columns {
        let difference = |step: f64| -> Vec<f64> {
            let mut x = vec![0.0; columns];
            x[column] = step;
            let plus = f(&x);
            x[column] = -step;
            let minus = f(&x);
            plus.iter()
                .zip(&minus)
                .map(|(p, m)| (p - m) / (2.0 * step))
                .collect()
        };
        let mut table: Vec<Vec<f64>> = (0..4)
            .map(|k| difference(0.02 / f64::from(1 << k)))
            .collect();
        for order in 1..4 {
            let factor = 4f64.powi(order);
            for k in 0..(4 - order as usize) {
                table[k] = (0..rows)
                    .map(|i| (factor * table[k + 1][i] - table[k][i]) / (factor - 1.0))
                    .collect();
            }
        }
        for row in 0..rows {
            result[row][column] = table[0][row];
        }
    }
    result
}
