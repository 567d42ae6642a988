//! Goals at collisions: a pose that must hold where a link touches something.

use thiserror::Error;

use super::scene::{Condition, Goal, GoalSet, GoalTarget, Partner, Scene, Touching};
use crate::math::Pose;
use crate::physics::contact::{Degenerate, Frame};
use crate::physics::impact::ContactSet;

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
    /// is on: typed digits leave a gap that no motion could close. Other goals are unchanged. Fails where the gap is too large, at
    /// an open collision that of every candidate, or a contact is degenerate.
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
        let of = self.goals[goal].clone();
        let Some(world_from_body) = self.pose_against_world(&of) else {
            return Ok(());
        };
        match self.contact_set(of.event) {
            Ok(Some(set)) => {
                let world_from_body = self.in_contact(&of, world_from_body, &set)?;
                self.goals[goal].target = GoalTarget::Pose { world_from_body };
                Ok(())
            }
            Ok(None) => self.touches_somehow(&of, &world_from_body),
            Err(_) => Ok(()),
        }
    }

    /// Whether the goals at a collision permit that these touch there.
    pub(super) fn may_touch(&self, event: usize, contacts: &[Touching]) -> bool {
        let Ok(Some(set)) = self.contact_set_of(event, contacts) else {
            return false;
        };
        let mut goals = self.goals.iter().filter(|goal| goal.event == event);
        goals.all(|goal| {
            let pose = self.pose_against_world(goal);
            pose.is_none_or(|pose| self.in_contact(goal, pose, &set).is_ok())
        })
    }

    /// The pose of a goal where its link hits the static world.
    fn pose_against_world(&self, goal: &Goal) -> Option<Pose> {
        let collision = self.events[goal.event].kind.collision()?;
        let hits_world = collision.link == goal.link && collision.partner == Partner::World;
        match goal.target {
            GoalTarget::Pose { world_from_body } if hits_world => Some(world_from_body),
            _ => None,
        }
    }

    /// A goal's pose moved into contact.
    fn in_contact(
        &self,
        goal: &Goal,
        mut world_from_body: Pose,
        set: &ContactSet,
    ) -> Result<Pose, SnapError> {
        for (index, contact) in set.as_slice().iter().enumerate() {
            let frame = Frame {
                position_m: world_from_body.translation.vector,
                orientation: world_from_body.rotation,
            };
            let touch = contact.touch(&frame, &Frame::world())?;
            let limit_m = if index == 0 { SNAP_M } else { FURTHER_M };
            if !(touch.gap_m.abs() <= limit_m) {
                return Err(SnapError::Apart {
                    link: self.links[goal.link].name.clone(),
                    event: self.events[goal.event].name.clone(),
                    gap_m: touch.gap_m,
                    limit_m,
                });
            }
            if index == 0 {
                world_from_body.translation.vector -= touch.normal * touch.gap_m;
            }
        }
        Ok(world_from_body)
    }

    /// Fails where a goal's pose is in none of the contacts that a collision leaves open, by the nearest of them.
    fn touches_somehow(&self, goal: &Goal, world_from_body: &Pose) -> Result<(), SnapError> {
        let mut nearest: Option<(f64, SnapError)> = None;
        for contacts in self.all_candidates(goal.event) {
            let Ok(Some(set)) = self.contact_set_of(goal.event, &contacts) else {
                continue;
            };
            match self.in_contact(goal, *world_from_body, &set) {
                Ok(_) => return Ok(()),
                Err(SnapError::Degenerate(_)) => {}
                Err(apart @ SnapError::Apart { gap_m, .. }) => {
                    if nearest
                        .as_ref()
                        .is_none_or(|(least_m, _)| gap_m.abs() < *least_m)
                    {
                        nearest = Some((gap_m.abs(), apart));
                    }
                }
            }
        }
        nearest.map_or(Ok(()), |(_, apart)| Err(apart))
    }
}
