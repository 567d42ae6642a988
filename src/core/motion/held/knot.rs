//! States with their rates, at one time.

use nalgebra::SMatrix;

pub use crate::physics::driven::Driven;

/// Covariance of a state, in its tangent.
pub type StateCovariance = SMatrix<f64, 12, 12>;

/// A state at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// Time \[s\].
    pub time_s: f64,
    /// The state there.
    pub driven: Driven,
}
