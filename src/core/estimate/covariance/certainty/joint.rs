//! The covariance of several unknowns together, by where it is from: that of any sum of them at no more cost.

use nalgebra::{DMatrix, DVector};

use super::{Covariance, CovarianceOfErrors};
use crate::estimate::covariance::bins::Six;
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
        let (seen, errors) = self.seen_jointly(&answers);
        let marks = form(&|answer| self.marks(answer).0);
        let beyond = form(&|answer| self.marks(answer).1);
        let known = &whole - form(&|answer| self.curvature(answer));
        let wished = form(&|answer| self.wished(answer));
        Variance {
            damped: form(&|answer| self.kkt.damped(answer)),
            informed: &seen + marks + wished,
            priors: &known - seen + beyond,
            known,
            errors,
            whole,
        }
    }

    /// Information of samples about the answers, and the covariance that their errors make of them.
    fn seen_jointly(&self, answers: &[DVector<f64>]) -> (DMatrix<f64>, DMatrix<f64>) {
        let count = answers.len();
        match &self.errors {
            CovarianceOfErrors::Found { design, noise } => {
                let changes = answers.iter().map(|answer| {
                    let mut changes: Vec<Six> = Vec::new();
                    design.each_change(answer, |change| changes.push(*change));
                    changes
                });
                let changes: Vec<Vec<Six>> = changes.collect();
                let sums: Vec<Vec<Six>> = answers.iter().map(|of| design.sums(of)).collect();
                let strayed: Vec<Vec<Six>> = sums.iter().map(|sums| noise.strayed(sums)).collect();
                let of_kind = |one: &[Six], other: &[Six], kind: usize| -> f64 {
                    let axes = 3 * kind..3 * kind + 3;
                    let pairs = one.iter().zip(other);
                    pairs
                        .map(|(one, other)| {
                            let each = axes.clone().map(|axis| one[axis] * other[axis]);
                            each.sum::<f64>()
                        })
                        .sum()
                };
                let squares = [0, 1].map(|kind| {
                    symmetric(count, |row, column| {
                        of_kind(&changes[row], &changes[column], kind)
                    })
                });
                let wander = symmetric(count, |row, column| {
                    let of = |kind| of_kind(&sums[row], &strayed[column], kind);
                    of(0) + of(1)
                });
                let white = noise.white;
                let errors = &squares[0] * white[0] + &squares[1] * white[1] + wander;
                let [positions, orientations] = squares;
                (positions + orientations, errors)
            }
            CovarianceOfErrors::Weighed(of_samples) => {
                let pattern = &self.context.structure().pattern;
                let products = answers.iter().map(|answer| {
                    let mut product = DVector::zeros(answer.len());
                    of_samples.multiply_add(pattern, answer, &mut product);
                    product
                });
                let products: Vec<DVector<f64>> = products.collect();
                let seen = symmetric(count, |row, column| answers[row].dot(&products[column]));
                (seen.clone(), seen)
            }
        }
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
