//! Two solids that must stay out of each other of which one belongs to a tree, or moves beside some.

use crate::estimate::posing::clearance::met::standing;
use crate::estimate::problem::clearance::{ClearSolids, ClearanceTouches, Clears, KeptFrom};
use crate::motion::{Against, Scene};
use crate::physics::contact::{Contact, Feature};

/// Two solids whose distance must not be less than a bound near a moment of the motion.
#[derive(Clone, Debug)]
pub struct TreeClearance {
    /// What is kept apart.
    pub solids: ClearSolids,
    /// Places of both in the forest; its own again where the other does not move as the unknowns say.
    pub places: [usize; 2],
    /// The piece of the motion on which they are.
    pub piece: MotionPiece,
    /// About when it is \[s, acted\].
    pub about_s: f64,
}

/// A piece of the motion that no node and no event parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotionPiece {
    /// The node from which the motion reaches it.
    pub node: usize,
    /// Number of events within the motion before it.
    pub events_before: usize,
}

impl Clears for TreeClearance {
    fn solids(&self) -> &ClearSolids {
        &self.solids
    }

    fn solids_mut(&mut self) -> &mut ClearSolids {
        &mut self.solids
    }

    /// Beyond a node or an event it is of another piece of the motion.
    fn is_beside(&self, other: &Self) -> bool {
        self.piece == other.piece && self.solids.is_beside(&other.solids)
    }
}

impl TreeClearance {
    /// The same in another scene that differs in values of quantities: what stands still may stand elsewhere.
    pub(super) fn set_from(&mut self, scene: &Scene) {
        let solids = &mut self.solids;
        if let Some(frame) = standing(scene, solids.against) {
            solids.from = KeptFrom::Still(frame);
        }
        let Against::Surface(surface) = solids.against else {
            return;
        };
        let plane = scene.surfaces[surface].plane();
        if let (ClearanceTouches::One(contact), Some((point_m, normal))) =
            (&mut solids.touches, plane)
            && let Ok(moved) = Contact::new(*contact.a(), Feature::face(point_m, normal))
        {
            **contact = moved;
        }
    }
}
