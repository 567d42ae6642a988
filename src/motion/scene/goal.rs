//! What must hold at events (paper §3.1).

use nalgebra::Vector3;

use crate::math::Pose;
use crate::motion::index::LinkIndex;

/// A goal (paper §3.1): a hard condition on a link at an event (just before it, if it is a
/// collision).
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// Index into `Scene::events`.
    pub event: usize,
    /// The link that it is asked of.
    pub link: LinkIndex,
    /// The condition.
    pub target: GoalTarget,
}

/// The condition of a goal.
#[derive(Clone, Debug, PartialEq)]
pub enum GoalTarget {
    /// The link's pose.
    Pose {
        /// Pose of the link's axes, at its centre of mass.
        world_from_body: Pose,
    },
    /// The centre of mass inside an axis-aligned box; equal bounds fix a coordinate, infinite
    /// ones leave it free [m, world].
    PositionWithin {
        /// Lower corner.
        lower_m: Vector3<f64>,
        /// Upper corner.
        upper_m: Vector3<f64>,
    },
}
