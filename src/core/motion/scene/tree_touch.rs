//! What meets what, where bodies are joined.

use super::event::Partner;
use super::whole::Scene;
use crate::physics::impact::Law;
use crate::physics::tree::LinkContact;

/// A link hits the static world or another link.
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
    /// What touches at an event of the scene; `None` at an event that is no collision, or one whose contacts are left
    /// open or not supported.
    pub fn tree_touch(&self, event: usize) -> Option<TreeTouch> {
        let collision = self.events[event].kind.collision()?;
        let contacts = self.contact_set(event).ok()??;
        Some(TreeTouch {
            at: LinkContact {
                place: self.place_of(collision.link),
                other: match collision.partner {
                    Partner::World => None,
                    Partner::Link(other) => Some(self.place_of(other)),
                },
                contacts,
            },
            law: self.impact_law(collision),
            is_by_goal: collision.links().all(|link| self.fixes_pose(event, link)),
        })
    }
}
