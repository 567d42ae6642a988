//! What one take says of quantities that several takes share.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// A take at given values `p` of some quantities, all else of it at its own constrained optimum:
/// `f*(p) = min_x f(x, p)  s.t.  c(x, p) = 0`, where half a square of one is one standard deviation of a sample. Priors of
/// those quantities are not in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TakeShare {
    /// `p`, in SI units.
    pub values: DVector<f64>,
    /// `f*`.
    pub cost: f64,
    /// `df*/dp`.
    pub gradient: DVector<f64>,
    /// `d²f*/dp²`: the Schur complement of `p` in the take's system of Karush, Kuhn and Tucker.
    pub curvature: DMatrix<f64>,
    /// Root mean square residual of positions \[m\] and of orientations \[rad\] per axis, with how many samples show each.
    pub residual: [f64; 2],
    /// See `residual`.
    pub samples: [usize; 2],
}
