//! Whitened coordinates of a flight's state about the best motion.
//!
//! With the block `S` of `P = (H + w CᵀC)⁻¹` ([`covariance`](crate::estimate::covariance)) that belongs to a
//! flight's state `q`, and `S = L Lᵀ`,
//!
//! ```text
//! q = q₀ ⊞ L z,   objective(z) ≈ objective(0) + |z|²
//! ```
//!
//! where all else follows as it fits best: the unknowns change by `X z` with `X = P_q L⁻ᵀ`, so that
//! `Xᵀ(H + w CᵀC)X = 1`. Of the directions that constraints fix, nearly all of that is `w CᵀC`'s:
//! where `XᵀHX` is not near one there is no coordinate.

use nalgebra::{DMatrix, DVector};

use super::Covariance;
use crate::estimate::terms::context::SolveContext;
use crate::optimise::System;
use crate::physics::State;
use crate::physics::state::StateTangent;

/// Least variance of a direction relative to the largest, in the typical lengths of
/// [`Program::damping`](crate::optimise::Program::damping): less is rounding.
const ROUNDING: f64 = 1e-13;
/// Least share of a free direction's information that is not the constraints'.
const FREE: f64 = 0.5;

/// Whitened coordinates of the state of one flight.
#[derive(Clone, Debug)]
pub struct Whitened {
    /// Index into [`Problem::arcs`](crate::estimate::problem::Problem::arcs).
    pub arc: usize,
    /// The state at its epoch in the best motion, `q₀`.
    origin: State,
    /// `L`, a row per entry of the state's tangent and a column per coordinate.
    root: DMatrix<f64>,
}

impl Whitened {
    /// Those of an arc at an optimum; `None` where its covariance is not finite.
    pub fn new(
        context: &SolveContext,
        system: &System,
        covariance: &Covariance,
        arc: usize,
        origin: &State,
    ) -> Option<Self> {
        let at: Vec<usize> = context.layout.state(arc).collect();
        let columns = covariance.with_all(&at);
        let lengths = context.lengths_of_state();
        let scale = DMatrix::from_diagonal(&lengths);
        let unscale = DMatrix::from_diagonal(&lengths.map(f64::recip));
        let block = &unscale * columns.select_rows(&at) * &unscale;
        if !columns.iter().all(|entry| entry.is_finite()) {
            return None;
        }
        let eigen = (0.5 * (&block + block.transpose())).symmetric_eigen();
        let largest = eigen.eigenvalues.max();
        let kept = (0..at.len()).filter(|k| eigen.eigenvalues[*k] > ROUNDING * largest);
        let kept: Vec<usize> = kept.collect();
        let vectors = eigen.eigenvectors.select_columns(&kept);
        let sds = kept.iter().map(|k| eigen.eigenvalues[*k].sqrt());
        let sds = DVector::from_iterator(kept.len(), sds);
        let response = columns * unscale * &vectors * DMatrix::from_diagonal(&sds.map(f64::recip));
        let pattern = &context.layout.structure.pattern;
        let mut by_samples = DMatrix::zeros(kept.len(), kept.len());
        for (column, x) in response.column_iter().enumerate() {
            let mut product = DVector::zeros(x.len());
            system
                .hessian
                .multiply_add(pattern, &x.into_owned(), &mut product);
            by_samples.set_column(column, &response.tr_mul(&product));
        }
        let shares = (0.5 * (&by_samples + by_samples.transpose())).symmetric_eigen();
        let free = (0..kept.len()).filter(|k| shares.eigenvalues[*k] > FREE);
        let free = shares
            .eigenvectors
            .select_columns(&free.collect::<Vec<_>>());
        Some(Self {
            arc,
            origin: *origin,
            root: scale * vectors * DMatrix::from_diagonal(&sds) * free,
        })
    }

    /// Number of coordinates.
    pub fn dimension(&self) -> usize {
        self.root.ncols()
    }

    /// The state at coordinates `z`.
    pub fn state(&self, z: &DVector<f64>) -> State {
        let delta = &self.root * z;
        let delta = StateTangent::from_fn(|row, _| delta[row]);
        self.origin.retract(&delta)
    }
}
