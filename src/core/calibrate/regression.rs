//! Robust linear least squares of samples that are three numbers each.

use nalgebra::{DMatrix, DVector, Matrix3xX, Vector3};

use super::spread::{Spread, jackknife};

/// Median length of a vector of three standard normal numbers.
const MEDIAN_LENGTH: f64 = 1.538_17;

/// Residuals beyond this many standard deviations count for nothing (Tukey's bisquare).
const CUT: f64 = 6.0;

/// Rounds of reweighting; the weights stand still long before.
const ROUNDS: usize = 30;

/// One sample's three equations `coefficients · unknowns = observed`.
pub(super) struct Equation {
    pub(super) coefficients: Matrix3xX<f64>,
    pub(super) observed: Vector3<f64>,
}

/// Solution of equations.
pub(super) struct Regression {
    pub(super) unknowns: DVector<f64>,
    pub(super) covariance: DMatrix<f64>,
    pub(super) spread: Spread,
    pub(super) residuals: Vec<Vector3<f64>>,
    /// Weights from 0, left out, to 1.
    pub(super) weights: Vec<f64>,
}

impl Regression {
    /// Root mean square of the residual's length, of what counts.
    pub(super) fn rms(&self) -> f64 {
        let squares = self.residuals.iter().zip(&self.weights);
        let sum: f64 = squares.map(|(r, w)| w * r.norm_squared()).sum();
        (sum / self.weights.iter().sum::<f64>()).sqrt()
    }

    /// How many samples count for nothing.
    pub(super) fn outliers(&self) -> usize {
        self.weights.iter().filter(|weight| **weight == 0.0).count()
    }
}

/// Normal equations: matrix and right-hand side.
type Normal = (DMatrix<f64>, DVector<f64>);

fn normal<'a>(equations: impl Iterator<Item = (&'a Equation, &'a f64)>, unknowns: usize) -> Normal {
    let mut matrix = DMatrix::zeros(unknowns, unknowns);
    let mut right = DVector::zeros(unknowns);
    for (equation, weight) in equations {
        let a = &equation.coefficients;
        matrix.gemm_tr(*weight, a, a, 1.0);
        right += a.tr_mul(&equation.observed) * *weight;
    }
    (matrix, right)
}

fn solve((matrix, right): Normal) -> Option<DVector<f64>> {
    Some(matrix.cholesky()?.solve(&right))
}

/// Least squares with Tukey's weights, begun with those of Huber, and covariance by blocks of time.
/// `None` where the equations do not determine the unknowns.
pub(super) fn regress(equations: &[Equation]) -> Option<Regression> {
    let unknowns = equations.first()?.coefficients.ncols();
    let residuals_of = |x: &DVector<f64>| -> Vec<Vector3<f64>> {
        let residual = |of: &Equation| of.observed - &of.coefficients * x;
        equations.iter().map(residual).collect()
    };
    let mut weights = vec![1.0; equations.len()];
    let mut x = solve(normal(equations.iter().zip(&weights), unknowns))?;
    for round in 0..ROUNDS {
        let residuals = residuals_of(&x);
        let scale = scale(&residuals);
        if !(scale > 0.0) {
            break;
        }
        for (weight, residual) in weights.iter_mut().zip(&residuals) {
            let ratio = residual.norm() / (CUT * scale);
            *weight = if round < ROUNDS / 3 {
                (0.5 / ratio).min(1.0)
            } else {
                (1.0 - ratio * ratio).max(0.0).powi(2)
            };
        }
        x = solve(normal(equations.iter().zip(&weights), unknowns))?;
    }
    let residuals = residuals_of(&x);
    let counted: Vec<[f64; 3]> = residuals
        .iter()
        .zip(&weights)
        .map(|(residual, weight)| (residual * weight.sqrt()).into())
        .collect();
    let spread = Spread::of(&counted);
    let count = equations.len();
    let parts: Vec<Normal> = (0..spread.blocks)
        .map(|block| {
            let of = equations.iter().zip(&weights).enumerate();
            let of = of.filter(|(at, _)| spread.block(*at, count) == block);
            normal(of.map(|(_, pair)| pair), unknowns)
        })
        .collect();
    let whole = parts.iter().fold(
        (DMatrix::zeros(unknowns, unknowns), DVector::zeros(unknowns)),
        |(matrix, right), part| (matrix + &part.0, right + &part.1),
    );
    let without = parts
        .iter()
        .map(|part| solve((&whole.0 - &part.0, &whole.1 - &part.1)))
        .collect::<Option<Vec<_>>>()?;
    Some(Regression {
        covariance: jackknife(&x, &without),
        unknowns: x,
        spread,
        residuals,
        weights,
    })
}

/// Standard deviation per axis by the median length.
fn scale(residuals: &[Vector3<f64>]) -> f64 {
    let mut lengths: Vec<f64> = residuals.iter().map(|r| r.norm()).collect();
    lengths.sort_by(f64::total_cmp);
    lengths[lengths.len() / 2] / MEDIAN_LENGTH
}
