//! The equations of motion of a mechanism: of what moves as one system of ordinary differential
//! equations between its collisions.
//!
//! The kind is told apart once per arc and once per side of a collision, never per sample.

use nalgebra::Vector3;

use super::body::Body;
use super::flow;
use super::state::{self, State, StateTangent};

/// What the equations of motion of a mechanism need.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dynamics {
    /// One rigid body in free flight: Newton's and Euler's equations, solved in [`flow`].
    Free(Body),
}

impl Dynamics {
    /// Number of directions in which the state may change: the length of its tangents.
    pub fn dimension(&self) -> usize {
        match self {
            Dynamics::Free(_) => state::DIMENSION,
        }
    }

    /// `q ⊞ δ`.
    ///
    /// # Panics
    /// Where `delta` has not [`Self::dimension`] entries.
    pub fn retract(&self, state: &State, delta: &[f64]) -> State {
        match self {
            Dynamics::Free(_) => state.retract(&StateTangent::from_column_slice(delta)),
        }
    }

    /// State after `duration_s` of flight (negative: before); see [`flow::advance`].
    pub fn advance(&self, gravity_m_s2: &Vector3<f64>, state: &State, duration_s: f64) -> State {
        match self {
            Dynamics::Free(body) => flow::advance(body, gravity_m_s2, state, duration_s),
        }
    }
}
