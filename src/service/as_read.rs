//! The scene of a recording as it was read, kept apart from the one that is estimated.

use crate::motion::{Scene, TakeEvent};
use crate::pipeline::Pipeline;

/// A scene as it was read: one collision of it may stand for several, so that an event of what was estimated has
/// another index in it, or none. It has therefore no events to be indexed; those of an estimate are of the scene
/// that comes with it.
#[derive(Clone, Debug)]
pub(super) struct AsRead(Scene);

impl AsRead {
    pub(super) fn of(scene: Scene) -> Self {
        Self(scene)
    }

    /// What says how a recording is read and what it is called: topics, bodies, names.
    pub(super) fn for_reading(&self) -> &Scene {
        &self.0
    }

    /// A take of it, to be estimated.
    pub(super) fn pipeline(&self, events: impl IntoIterator<Item = TakeEvent>) -> Pipeline {
        Pipeline::of(self.0.clone(), events)
    }
}
