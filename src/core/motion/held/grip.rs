//! What is in a hand for a while.

use super::estimate::HeldEstimate;
use crate::physics::State;

/// The estimated motion of a body in one of the phases in which a hand moves it.
#[derive(Clone, Debug, PartialEq)]
pub struct GripEstimate {
    /// Index into `Scene::phases`.
    pub phase: usize,
    /// Physical times at which it begins and ends \[s\].
    pub span_s: [f64; 2],
    /// The motion.
    pub motion: HeldEstimate,
}

impl GripEstimate {
    /// The state at a physical time within it \[s\].
    pub fn state(&self, time_s: f64) -> State {
        self.motion.curve.at(time_s).state
    }
}
