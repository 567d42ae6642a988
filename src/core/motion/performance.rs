//! What was performed, as the estimation reads it.

use super::{Scene, Segment, Sketch};

/// A scene with a sketch of it that is cut into segments.
#[derive(Clone, Copy, Debug)]
pub struct Performance<'a> {
    /// What holds in any case.
    pub scene: &'a Scene,
    /// The samples and marks.
    pub sketch: &'a Sketch,
    /// The parts of the sketch between collisions, in order.
    pub segments: &'a [Segment],
}
