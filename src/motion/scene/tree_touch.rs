//! What a link of joined bodies hits.

use super::event::Partner;
use super::joint::JointTree;
use super::whole::Scene;
use crate::physics::contact::Contact;
use crate::physics::impact::Law;

/// One link hits the static world at one contact.
#[derive(Clone, Debug)]
pub struct TreeTouch {
    /// The link's place in the tree.
    pub place: usize,
    /// Its feature and the world's.
    pub contact: Contact,
    /// Restitution, friction and tilt.
    pub law: Law,
    /// Whether a goal fixes the link in contact, so that no row is needed for the gap.
    pub is_by_goal: bool,
}

impl Scene {
    /// What touches at an event of the scene: a link of the tree and the static world, at one contact; `None` at any
    /// other event.
    pub fn tree_touch(&self, joined: &JointTree, event: usize) -> Option<TreeTouch> {
        let collision = self.events[event].kind.collision()?;
        let set = self.contact_set(event).ok()??;
        let [contact] = set.as_slice() else {
            return None;
        };
        if collision.partner != Partner::World {
            return None;
        }
        Some(TreeTouch {
            place: joined.place_of(collision.link)?,
            contact: *contact,
            law: self.impact_law(collision),
            is_by_goal: self.fixes_pose(event, collision.link),
        })
    }
}
