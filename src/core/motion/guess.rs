//! The start of the estimation (paper §6.2.1).

use crate::physics::State;

/// A first guess of all unknowns.
#[derive(Clone, Debug, PartialEq)]
pub struct Guess {
    /// One per segment.
    pub arcs: Vec<ArcGuess>,
    /// Physical time of each of the scene's events \[s\].
    pub event_times_s: Vec<f64>,
    /// The scene's free parameters, each in its quantity's unit.
    pub parameters: Vec<f64>,
}

/// A first guess of the flight in one segment.
#[derive(Clone, Debug, PartialEq)]
pub struct ArcGuess {
    /// Physical time of `state`, about the middle of the arc \[s\].
    pub epoch_s: f64,
    /// State at the epoch.
    pub state: State,
    /// Physical times of the segment's samples \[s\], one view after the other; strictly increasing in
    /// each.
    pub sample_times_s: Vec<f64>,
}
