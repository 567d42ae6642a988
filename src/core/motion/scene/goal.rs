//! What must hold at events (paper §3.1).

use nalgebra::Vector3;

use super::condition::{Condition, GoalQuantity};
use crate::math::Pose;
use crate::motion::index::LinkIndex;

/// A goal (paper §3.1): a condition on a link at an event, just before it if it is a collision and
/// the condition does not say otherwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// Index into `Scene::events`.
    pub event: usize,
    /// The link that it is asked of.
    pub link: LinkIndex,
    /// The condition.
    pub target: GoalTarget,
}

impl Goal {
    /// The events that it is about: its own, and that since which a time is counted.
    pub fn events(&self) -> impl Iterator<Item = usize> {
        let since = match &self.target {
            GoalTarget::Condition(condition) => condition.quantity.since(),
            _ => None,
        };
        [self.event].into_iter().chain(since)
    }

    /// Gives its events other places among the scene's.
    pub fn place_events(&mut self, place: impl Fn(usize) -> usize) {
        self.event = place(self.event);
        if let GoalTarget::Condition(condition) = &mut self.target
            && let GoalQuantity::Time { since: Some(since) } = &mut condition.quantity
        {
            *since = place(*since);
        }
    }
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
    /// Any quantity in any set, hard or with a weight. Of a time the link says nothing.
    Condition(Condition),
}
