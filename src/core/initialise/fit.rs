//! The ways in which one flight fits its samples.

use crate::physics::State;

/// One way in which a flight fits: the state at its epoch.
#[derive(Clone, Copy, Debug)]
pub(super) struct ArcFit {
    pub(super) state: State,
    /// Sum of squares \[rad²\].
    pub(super) square_rad2: f64,
}

impl ArcFit {
    pub(super) fn of(state: State, square_rad2: f64) -> Self {
        Self { state, square_rad2 }
    }
}
