//! The covariance of several unknowns together, by where it is from: that of any sum of them at no more cost.

use nalgebra::{DMatrix, DVector};

use super::Covariance;
use crate::motion::Variance;
use crate::optimise::Program;

/// A symmetric matrix of one entry for each pair.
fn symmetric(count: usize, mut entry: impl FnMut(usize, usize) -> f64) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(count, count);
    for row in 0..count {
        for column in 0..=row {
            let entry = entry(row, column);
            matrix[(row, column)] = entry;
            matrix[(column, row)] = entry;
        }
    }
    matrix
}

impl Covariance<'_> {
    /// The covariance of unknowns together: what [`sds`](Self::sds) takes apart for one sum of them.
    pub fn jointly(&self, unknowns: &[usize]) -> Variance<DMatrix<f64>> {
        let count = unknowns.len();
        let answers = unknowns.iter().map(|at| self.answer(&[(*at, 1.0)]));
        let answers: Vec<DVector<f64>> = answers.collect();
        let whole = symmetric(count, |row, column| answers[column][unknowns[row]]);
        let form = |square: &dyn Fn(&DVector<f64>) -> f64| polarised(&answers, &whole, square);
        let seen = self.seen_jointly(&answers);
        let marks = form(&|answer| self.marks(answer).0);
        let beyond = form(&|answer| self.marks(answer).1);
        let known = &whole - form(&|answer| self.curvature(answer));
        let wished = form(&|answer| self.wished(answer));
        Variance {
            damped: form(&|answer| self.kkt.damped(answer)),
            informed: &seen + marks + wished,
            priors: &known - &seen + beyond,
            known,
            errors: self.spread(&answers).unwrap_or(seen),
            whole,
        }
    }

    /// Information of samples about the answers.
    pub(super) fn seen_jointly(&self, answers: &[DVector<f64>]) -> DMatrix<f64> {
        let pattern = &self.context.structure().pattern;
        let products = answers.iter().map(|answer| {
            let mut product = DVector::zeros(answer.len());
            self.of_samples.multiply_add(pattern, answer, &mut product);
            product
        });
        let products: Vec<DVector<f64>> = products.collect();
        symmetric(answers.len(), |row, column| {
            answers[row].dot(&products[column])
        })
    }
}

/// The matrix of a square on the answers. They are scaled by their variances first, so that small ones are not lost.
fn polarised(
    answers: &[DVector<f64>],
    whole: &DMatrix<f64>,
    square: &dyn Fn(&DVector<f64>) -> f64,
) -> DMatrix<f64> {
    let sizes = whole.diagonal().map(|variance| {
        let size = variance.sqrt();
        if size > 0.0 { size } else { 1.0 }
    });
    let scaled = answers.iter().zip(&sizes);
    let scaled: Vec<DVector<f64>> = scaled.map(|(answer, size)| answer / *size).collect();
    let own: Vec<f64> = scaled.iter().map(square).collect();
    symmetric(answers.len(), |row, column| {
        let both = match row == column {
            true => own[row],
            false => 0.5 * (square(&(&scaled[row] + &scaled[column])) - own[row] - own[column]),
        };
        both * sizes[row] * sizes[column]
    })
}
