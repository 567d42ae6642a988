//! Which samples err together: those of one track, from flight to flight, where their errors are a process in time.

use super::influence::Acting;
use crate::estimate::wander::Process;
use crate::motion::TrackIndex;

/// The samples of all tracks whose errors are a process.
#[derive(Clone, Debug)]
pub struct Weave {
    /// Errors of positions, and of orientations and directions, in units of residuals.
    pub processes: [Process; 2],
    /// Track by track.
    pub tracks: Vec<WovenTrack>,
}

/// The samples of a track.
#[derive(Clone, Debug)]
pub struct WovenTrack {
    /// What was tracked.
    pub track: TrackIndex,
    /// Its flights, in order of time.
    pub arcs: Vec<WovenArc>,
    /// Parameters that act on any of them.
    pub parameters: Vec<usize>,
}

/// The samples of a flight.
#[derive(Clone, Debug)]
pub struct WovenArc {
    /// Index into [`Problem::arcs`](super::Problem::arcs).
    pub arc: usize,
    /// Parameters that act on it or on what is seen of it, gravity among them.
    pub acting: Vec<Acting>,
    /// Its samples, in order of time.
    pub samples: Vec<WovenSample>,
    /// Of how many flights before it errors still tell of its own.
    pub remembered: usize,
}

/// A sample.
#[derive(Clone, Copy, Debug)]
pub struct WovenSample {
    /// Index into [`Arc::views`](super::Arc::views).
    pub view: usize,
    /// Index into [`View::samples`](super::View::samples).
    pub sample: usize,
    /// When it was taken \[s, acted\].
    pub acted_s: f64,
}
