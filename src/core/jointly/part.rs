//! The part that a take has in the joint normal equations, in lengths of the parameters.
//!
//! About the joint mean a take says `gᵀd + ½ dᵀSd`. Where some parameters `D` are its own, drawn with variances `T`, these
//! are marginalised: with `M = (T⁻¹ + S_DD)⁻¹` what is left says
//!
//! ```text
//! W = S − S_·D M S_D·,   g̃ = g − S_·D M g_D
//! ```
//!
//! of the means, which is `(S⁻¹ + T)⁻¹` where `S` has an inverse (Laplace's approximation where a take is curved).

use nalgebra::{DMatrix, DVector};

use super::parameter::{JointParameter, lengths};
use crate::motion::TakeShare;

/// What a take says about the joint mean, before anything is marginalised.
#[derive(Clone, Debug)]
pub(super) struct PlainPart {
    /// Gradient at the mean.
    pub(super) gradient: DVector<f64>,
    /// `S`, positive semidefinite.
    pub(super) curvature: DMatrix<f64>,
    /// How far it was asked from the mean.
    pub(super) off: DVector<f64>,
    pub(super) cost: f64,
}

/// The same about the means alone.
#[derive(Clone, Debug)]
pub(super) struct MeanPart {
    pub(super) gradient: DVector<f64>,
    pub(super) information: DMatrix<f64>,
    /// `M`, zero where nothing is drawn.
    pub(super) own: DMatrix<f64>,
    /// `log det (1 + T S_DD)`.
    pub(super) log_determinant: f64,
}

impl PlainPart {
    /// The part of a take about a mean.
    pub(super) fn new(
        parameters: &[JointParameter],
        share: &TakeShare,
        mean: &DVector<f64>,
    ) -> Self {
        let lengths = lengths(parameters);
        let gradient = share.gradient.component_mul(&lengths);
        let curvature = DMatrix::from_fn(lengths.len(), lengths.len(), |a, b| {
            share.curvature[(a, b)] * lengths[a] * lengths[b]
        });
        let curvature = semidefinite(curvature);
        let off = share.values.component_div(&lengths) - mean;
        Self {
            gradient: gradient - &curvature * &off,
            curvature,
            off,
            cost: share.cost,
        }
    }

    /// What is left of it about the means, where its own values have these variances; none where zero.
    pub(super) fn of_means(&self, variances: &DVector<f64>) -> MeanPart {
        let own = self.own(variances);
        let spread = DMatrix::from_diagonal(variances);
        let inner = DMatrix::identity(own.nrows(), own.ncols()) + spread * &self.curvature;
        let along = &self.curvature * &own;
        MeanPart {
            gradient: &self.gradient - &along * &self.gradient,
            information: semidefinite(&self.curvature - &along * &self.curvature),
            log_determinant: inner.determinant().max(f64::MIN_POSITIVE).ln(),
            own,
        }
    }

    /// Covariance of its own values by itself, as much as a typical change known beforehand of what it does not tell.
    pub(super) fn alone(&self) -> Option<DMatrix<f64>> {
        let count = self.gradient.len();
        (&self.curvature + DMatrix::identity(count, count)).try_inverse()
    }

    /// `M = (T⁻¹ + S_DD)⁻¹ = √T (1 + √T S √T)⁻¹ √T`, which is zero where `T` is.
    fn own(&self, variances: &DVector<f64>) -> DMatrix<f64> {
        let root = DMatrix::from_diagonal(&variances.map(f64::sqrt));
        let count = variances.len();
        let inner = DMatrix::identity(count, count) + &root * &self.curvature * &root;
        match inner.cholesky() {
            Some(factor) => &root * factor.inverse() * &root,
            None => DMatrix::zeros(count, count),
        }
    }

    /// How far the take's own values are from means that move by `step`.
    pub(super) fn own_off(&self, own: &DMatrix<f64>, step: &DVector<f64>) -> DVector<f64> {
        -own * (&self.gradient + &self.curvature * step)
    }
}

/// A symmetric matrix without negative eigenvalues: those of an optimum are rounding, or directions that its take does not
/// determine.
pub(super) fn semidefinite(matrix: DMatrix<f64>) -> DMatrix<f64> {
    let symmetric = 0.5 * (&matrix + matrix.transpose());
    let eigen = symmetric.clone().symmetric_eigen();
    if eigen.eigenvalues.iter().all(|value| *value >= 0.0) {
        return symmetric;
    }
    let values = eigen.eigenvalues.map(|value| value.max(0.0));
    &eigen.eigenvectors * DMatrix::from_diagonal(&values) * eigen.eigenvectors.transpose()
}

/// Sum of gradients and informations of parts, with the priors about a mean.
pub(super) struct Total {
    pub(super) gradient: DVector<f64>,
    pub(super) information: DMatrix<f64>,
}

impl Total {
    pub(super) fn of<'a>(
        parameters: &[JointParameter],
        mean: &DVector<f64>,
        parts: impl Iterator<Item = &'a MeanPart>,
    ) -> Self {
        let count = parameters.len();
        let mut gradient = DVector::zeros(count);
        let mut information = DMatrix::zeros(count, count);
        for part in parts {
            gradient += &part.gradient;
            information += &part.information;
        }
        for (at, parameter) in parameters.iter().enumerate() {
            let prior = parameter.prior();
            gradient[at] += prior * (mean[at] - parameter.initial / parameter.length);
            information[(at, at)] += prior;
        }
        Self {
            gradient,
            information,
        }
    }
}
