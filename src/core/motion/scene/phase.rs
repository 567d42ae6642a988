//! Phases in which a body stays on a surface.

use crate::motion::index::{ContactLawIndex, LinkIndex};
use crate::physics::Sustained;

/// A body stays on a plane between two events.
#[derive(Clone, Debug, PartialEq)]
pub struct SupportPhase {
    /// Unique name.
    pub name: String,
    /// The body.
    pub link: LinkIndex,
    /// How it moves.
    pub sustained: Sustained,
    /// What it is on (index into `Scene::surfaces`): a plane.
    pub surface: usize,
    /// By what it is on it (index into the body's features): a ball, or a face.
    pub feature: usize,
    /// Its friction.
    pub law: ContactLawIndex,
    /// The events at which it begins and ends.
    pub events: [usize; 2],
}
