//! Goals at collisions: a pose that must hold where a link touches something.

use thiserror::Error;

use super::scene::{Condition, Goal, GoalSet, GoalTarget, Partner, Scene};
use crate::physics::contact::{Degenerate, Frame};

/// Largest gap of a goal's pose at a collision that is corrected \[m\].
const SNAP_M: f64 = 1e-3;
/// Largest gap of further contacts, which are not corrected \[m\].
const FURTHER_M: f64 = 1e-9;

/// Why a goal cannot hold at its collision.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SnapError {
    /// In its pose a contact is degenerate.
    #[error(transparent)]
    Degenerate(#[from] Degenerate),
    /// In its pose the features are apart, or inside one another.
    #[error(
        "the goal leaves {} mm between {link:?} and what it touches at {event:?}, expected at most {} mm",
        1e3 * .gap_m, 1e3 * .limit_m
    )]
    Apart {
        /// Name of the link.
        link: String,
        /// Name of the event.
        event: String,
        /// Gap in the goal's pose.
        gap_m: f64,
        /// Largest gap that is corrected.
        limit_m: f64,
    },
}

impl Scene {
    /// Moves the pose of a goal at a collision into contact, and the place of a contact onto the face that it
    /// is on: typed digits leave a gap that no motion could close. Other goals and those at open collisions are unchanged. Fails where the
    /// gap is too large or a contact is degenerate.
    pub fn snap_to_contact(&mut self, goal: usize) -> Result<(), SnapError> {
        if let GoalTarget::Condition(condition) = &self.goals[goal].target
            && let Some((point_m, normal)) = self.face_touched(&self.goals[goal], condition)
            && let GoalSet::Box { lower, .. } = condition.set
            && condition.set.is_point(3)
        {
            let on_face = lower - normal * normal.dot(&(lower - point_m));
            let condition = Condition {
                set: GoalSet::point(on_face),
                ..condition.clone()
            };
            if condition.sd.is_none() && (on_face - lower).norm() <= SNAP_M {
                self.goals[goal].target = GoalTarget::Condition(condition);
            }
            return Ok(());
        }
        let Goal {
            event,
            link,
            target,
        } = self.goals[goal].clone();
        let hits_world = self.events[event]
            .kind
            .collision()
            .is_some_and(|c| c.link == link && c.partner == Partner::World);
        let (
            true,
            GoalTarget::Pose {
                mut world_from_body,
            },
        ) = (hits_world, target)
        else {
            return Ok(());
        };
        let Ok(Some(set)) = self.contact_set(event) else {
            return Ok(());
        };
        for (index, contact) in set.as_slice().iter().enumerate() {
            let frame = Frame {
                position_m: world_from_body.translation.vector,
                orientation: world_from_body.rotation,
            };
            let touch = contact.touch(&frame, &Frame::world())?;
            let limit_m = if index == 0 { SNAP_M } else { FURTHER_M };
            if !(touch.gap_m.abs() <= limit_m) {
                return Err(SnapError::Apart {
                    link: self.links[link].name.clone(),
                    event: self.events[event].name.clone(),
                    gap_m: touch.gap_m,
                    limit_m,
                });
            }
            if index == 0 {
                world_from_body.translation.vector -= touch.normal * touch.gap_m;
            }
        }
        self.goals[goal].target = GoalTarget::Pose { world_from_body };
        Ok(())
    }
}
