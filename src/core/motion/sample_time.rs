//! Times of samples.

use super::index::TrackIndex;
use super::take::Stamp;

/// The physical time of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleTime {
    /// The track that the sample is of.
    pub track: TrackIndex,
    /// Stamp of the sample.
    pub stamp: Stamp,
    /// Its physical time [s since the first sample].
    pub time_s: f64,
    /// Whether its time was not known: its stamp then says nothing of it.
    pub is_open: bool,
}
