//! Intervals of joint values, by how takes differ and not by their noise alone.
//!
//! With the joint information `A = Σ W_k + Λ`, priors `Λ`, and the gradients `g_k` of takes at the optimum the covariance is
//! `A⁻¹ (Σ a_k a_kᵀ + Λ) A⁻¹`, robust to whatever is common within a take and to how takes differ. In the frame in which
//! `A = 1` a take of information `B_k` fits itself by that much, and `a_k = (1 − B_k)^(−1/2) g_k` takes that back (CR2).
//! Quantiles are those of Student's t with as many degrees of freedom as Satterthwaite's approximation gives each
//! parameter (Bell and McCaffrey, Survey Methodology 28, 2002).

use nalgebra::{Cholesky, DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::parameter::{JointParameter, lengths};
use super::part::MeanPart;
use super::search::JointSearch;
use super::spread::TakesField;
use super::weak::without;
use crate::motion::TakeShare;

/// How often an interval should hold what it is about.
const CONFIDENCE: f64 = 0.95;
/// Least share of itself that a take is taken to leave to the others.
const LEAST_LEFT: f64 = 1e-3;
/// A direction of the kept space has at least so much of itself outside what is not determined.
const DETERMINED: f64 = 1e-9;

/// A joint value with its interval, SI.
#[derive(Clone, Debug, PartialEq)]
pub struct JointInterval {
    /// The value; of what is drawn, the mean over takes.
    pub value: f64,
    /// Its standard deviation; none where it is not determined, at a bound, or told by one take.
    pub sd: Option<f64>,
    /// Ends of its interval, within its bounds.
    pub ends: Option<[f64; 2]>,
    /// Degrees of freedom.
    pub freedom: f64,
    /// Whether it is at a bound.
    pub is_at_bound: bool,
    /// Whether a direction that is not determined has part in it.
    pub is_weak: bool,
    /// Its spread over takes, where it is drawn.
    pub spread: Option<Spreads>,
}

/// A standard deviation over takes, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spreads {
    /// The likeliest.
    pub sd: f64,
    /// Ends of its interval.
    pub ends: [f64; 2],
}

/// The optimum with all that is told of it.
pub(super) struct Optimum {
    /// Basis of the directions that are free and determined, scaled so that the information is one: `Q L⁻ᵀ`.
    pub(super) frame: DMatrix<f64>,
    /// Each take's gradient and information there.
    pub(super) gradients: Vec<DVector<f64>>,
    pub(super) informations: Vec<DMatrix<f64>>,
    /// Information of the priors there.
    prior: DMatrix<f64>,
}

impl Optimum {
    /// The optimum of a search; `None` where nothing is free and determined.
    pub(super) fn of(joint: &JointSearch, parts: &[MeanPart]) -> Option<Self> {
        let parameters = joint.parameters();
        let total = joint.total(parts);
        let basis = kept(joint)?;
        let inner = basis.transpose() * &total.information * &basis;
        let factor = Cholesky::new(inner)?;
        let frame = factor
            .l()
            .solve_lower_triangular(&basis.transpose())?
            .transpose();
        let inside = |matrix: &DMatrix<f64>| frame.transpose() * matrix * &frame;
        let priors = parameters.iter().map(JointParameter::prior);
        let priors = DVector::from_iterator(parameters.len(), priors);
        let gradients = parts.iter().map(|of| frame.transpose() * &of.gradient);
        Some(Self {
            gradients: gradients.collect(),
            informations: parts.iter().map(|of| inside(&of.information)).collect(),
            prior: inside(&DMatrix::from_diagonal(&priors)),
            frame,
        })
    }

    /// Covariance of the joint values, in lengths, and the degrees of freedom of each.
    fn covariance(&self) -> (DMatrix<f64>, DVector<f64>) {
        let count = self.frame.ncols();
        let mut meat = self.prior.clone();
        let roots: Vec<DMatrix<f64>> = self.informations.iter().map(inverse_root).collect();
        for (gradient, root) in self.gradients.iter().zip(&roots) {
            let adjusted = root * gradient;
            meat += &adjusted * adjusted.transpose();
        }
        let covariance = &self.frame * meat * self.frame.transpose();
        let freedoms = self.frame.row_iter().map(|row| {
            let along = row.transpose();
            let (mut trace, mut squares) = (0.0, 0.0);
            let mut outer = DMatrix::zeros(count, count);
            for (root, information) in roots.iter().zip(&self.informations) {
                let adjusted = root * &along;
                let told = information * &adjusted;
                let own = adjusted.dot(&told);
                let lost = told.norm_squared();
                trace += own - lost;
                squares += own * own - 2.0 * own * lost;
                outer += &told * told.transpose();
            }
            let squares = squares + outer.norm_squared();
            match squares > 0.0 {
                true => trace * trace / squares,
                false => 0.0,
            }
        });
        let freedoms = DVector::from_iterator(self.frame.nrows(), freedoms);
        (covariance, freedoms)
    }
}

/// Orthonormal directions that are neither at a bound nor undetermined.
fn kept(joint: &JointSearch) -> Option<DMatrix<f64>> {
    let bounded = joint.bounded();
    let mut projector = without(&joint.held());
    for at in (0..bounded.len()).filter(|at| bounded[*at]) {
        projector.row_mut(at).fill(0.0);
        projector.column_mut(at).fill(0.0);
    }
    let eigen = projector.symmetric_eigen();
    let columns = eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter());
    let columns = columns.filter(|(value, _)| **value > 1.0 - DETERMINED);
    let columns: Vec<DVector<f64>> = columns.map(|(_, column)| column.into_owned()).collect();
    (!columns.is_empty()).then(|| DMatrix::from_columns(&columns))
}

/// `(1 − B)^(−1/2)`.
fn inverse_root(information: &DMatrix<f64>) -> DMatrix<f64> {
    let eigen = information.clone().symmetric_eigen();
    let values = eigen
        .eigenvalues
        .map(|value| (1.0 - value).max(LEAST_LEFT).powf(-0.5));
    &eigen.eigenvectors * DMatrix::from_diagonal(&values) * eigen.eigenvectors.transpose()
}

impl JointSearch {
    /// The joint values with their intervals, and their correlations, at the optimum.
    pub fn intervals(&self, shares: &[Option<TakeShare>]) -> (Vec<JointInterval>, DMatrix<f64>) {
        let parts = self.parts(shares);
        let of_means = self.of_means(&parts);
        let count = self.parameters().len();
        let none = || (DMatrix::zeros(count, count), DVector::zeros(count));
        let (covariance, freedoms) =
            Optimum::of(self, &of_means).map_or_else(none, |of| of.covariance());
        let field = TakesField {
            parameters: self.parameters(),
            mean: self.mean(),
            parts: &parts,
        };
        let (held, bounded) = (self.held(), self.bounded());
        let lengths = lengths(self.parameters());
        let values = self.values();
        let each = self.parameters().iter().enumerate().map(|(at, parameter)| {
            let length = lengths[at];
            let is_weak = held.row(at).norm() > DETERMINED.sqrt();
            let is_told = !is_weak && !bounded[at] && parts.len() > 1 && freedoms[at] > 0.5;
            let variance = covariance[(at, at)];
            let sd = (is_told && variance > 0.0).then(|| variance.sqrt() * length);
            let half = sd.map(|sd| quantile(freedoms[at]) * sd);
            let ends = half.filter(|half| half.is_finite()).map(|half| {
                let value = values[at];
                [
                    (value - half).max(parameter.lower),
                    (value + half).min(parameter.upper),
                ]
            });
            let spread = parameter.is_drawn.then(|| Spreads {
                sd: self.variances()[at].sqrt() * length,
                ends: field.ends(self.variances(), at).map(|end| end * length),
            });
            JointInterval {
                value: values[at],
                sd,
                ends,
                freedom: freedoms[at],
                is_at_bound: bounded[at],
                is_weak,
                spread,
            }
        });
        let each = each.collect();
        let correlation = DMatrix::from_fn(count, count, |a, b| {
            let size = (covariance[(a, a)] * covariance[(b, b)]).sqrt();
            match (size > 0.0, a == b) {
                (true, _) => covariance[(a, b)] / size,
                (false, true) => 1.0,
                (false, false) => 0.0,
            }
        });
        (each, correlation)
    }
}

/// Half the width of an interval in standard deviations.
fn quantile(freedom: f64) -> f64 {
    let law = StudentsT::new(0.0, 1.0, freedom);
    law.map_or(f64::INFINITY, |law| law.inverse_cdf(0.5 + 0.5 * CONFIDENCE))
}
