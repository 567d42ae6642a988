//! The state after a flight or on a support, with derivatives by its start and by what acts on the way.

use nalgebra::Vector3;

use super::free::{FreeFlown, WantedDerivatives};
use super::supported::{Carried, Supported};
use crate::physics::body::Body;
use crate::physics::state::{ByStates, State, StateTangent};

/// A state after a flight or on a support, with derivatives by the state at its start and by what acts on the way.
#[expect(
    clippy::large_enum_variant,
    reason = "few live at a time, on the stack"
)]
#[derive(Clone, Copy, Debug)]
pub enum Flown {
    /// After a flight.
    Free(FreeFlown),
    /// On a support.
    Carried(Carried),
}

impl Flown {
    /// After `duration_s` from a state (negative: before it). Derivatives by drag and by moments are zero where they are
    /// not wanted, and on a support.
    pub fn new(
        body: &Body,
        gravity_m_s2: &Vector3<f64>,
        state: &State,
        duration_s: f64,
        is_wanted: WantedDerivatives,
    ) -> Self {
        match Supported::new(body, gravity_m_s2, state) {
            Some(mut supported) => Self::Carried(supported.carried(duration_s)),
            None => {
                let free = FreeFlown::new(body, gravity_m_s2, state, duration_s, is_wanted);
                Self::Free(free)
            }
        }
    }

    /// The state.
    pub fn state(&self) -> State {
        match self {
            Self::Free(free) => free.state(),
            Self::Carried(carried) => carried.state,
        }
    }

    /// Derivatives by the state at the start.
    pub fn by_state(&self) -> ByStates {
        match self {
            Self::Free(free) => free.by_state(),
            Self::Carried(carried) => carried.by_state,
        }
    }

    /// Derivative by a component of the pull, gravity's or a force's per mass \[s²/m\].
    pub fn by_pull(&self, axis: usize) -> StateTangent {
        match self {
            Self::Free(free) => free.by_pull(axis),
            Self::Carried(carried) => carried.by_pull[axis],
        }
    }

    /// Derivative by the linear drag (0) or the quadratic one (1).
    pub fn by_drag(&self, order: usize) -> StateTangent {
        match self {
            Self::Free(free) => free.by_drag(order),
            Self::Carried(_) => StateTangent::zeros(),
        }
    }

    /// Derivative by the lift, where it is wanted.
    pub fn by_lift(&self) -> StateTangent {
        match self {
            Self::Free(free) => free.by_lift(),
            Self::Carried(_) => StateTangent::zeros(),
        }
    }

    /// Derivative by the logarithm of a principal moment.
    pub fn by_log_moment(&self, axis: usize) -> StateTangent {
        match self {
            Self::Free(free) => free.by_log_moment(axis),
            Self::Carried(_) => StateTangent::zeros(),
        }
    }

    /// Derivative by the friction of what supports it.
    pub fn by_friction(&self) -> StateTangent {
        match self {
            Self::Free(_) => StateTangent::zeros(),
            Self::Carried(carried) => carried.by_friction,
        }
    }
}
