//! What a page is made of.

use crate::motion::{PoseSample, Scene, TrackIndex};
use crate::report::ExportProvenance;
use crate::write::export::WrittenMotion;

/// What a page is made of.
#[derive(Clone, Copy)]
pub struct Page<'a> {
    /// The scene of the estimate.
    pub scene: &'a Scene,
    /// The motion and the performance.
    pub motion: &'a WrittenMotion,
    /// What trackers read that see points alone, as they read it.
    pub readings: &'a [(TrackIndex, PoseSample)],
    /// From what it is made.
    pub provenance: &'a ExportProvenance,
    /// What of the file could not be read.
    pub lost: &'a [String],
}
