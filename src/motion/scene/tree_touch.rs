//! What meets what, where bodies are joined.

use super::event::Partner;
use super::whole::Scene;
use crate::physics::impact::Law;
use crate::physics::tree::LinkContact;

/// A link hits the static world or another link at one contact.
#[derive(Clone, Debug)]
pub struct TreeTouch {
    /// What touches.
    pub at: LinkContact,
    /// Restitution, friction and tilt.
    pub law: Law,
    /// Whether goals fix all that moves of it in contact, so that no row is needed for the gap.
    pub is_by_goal: bool,
}

impl Scene {
    /// What touches at an event of the scene, at one contact; `None` at an event that is no collision, or one at
    /// several contacts or at one that is left open.
    pub fn tree_touch(&self, event: usize) -> Option<TreeTouch> {
        let collision = self.events[event].kind.collision()?;
        let set = self.contact_set(event).ok()??;
        let [contact] = set.as_slice() else {
            return None;
        };
        Some(TreeTouch {
            at: LinkContact {
                place: self.place_of(collision.link),
                other: match collision.partner {
                    Partner::World => None,
                    Partner::Link(other) => Some(self.place_of(other)),
                },
                contact: *contact,
            },
            law: self.impact_law(collision),
            is_by_goal: collision.links().all(|link| self.fixes_pose(event, link)),
        })
    }
}
