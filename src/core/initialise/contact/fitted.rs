//! Fits of the motion about a collision.

use crate::motion::{LinkIndex, Scene, Touching};
use crate::physics::State;
use crate::physics::contact::Contact;

/// Fits of the motion about a collision.
pub trait Fitted {
    /// The state of a link so long after the event \[s\], by the fit that ends there, or by the one that begins there;
    /// `None` where there is none.
    fn state(&self, link: LinkIndex, is_after: bool, after_s: f64) -> Option<State>;

    /// Uncertainty of a link's surface at the event \[m\], as far as fits show it.
    fn spread_m(&self, link: LinkIndex) -> f64;
}

/// A collision among fits.
pub(super) struct FittedView<'a> {
    pub(super) scene: &'a Scene,
    pub(super) event: usize,
    pub(super) fitted: &'a dyn Fitted,
}

impl FittedView<'_> {
    pub(super) fn links(&self) -> Vec<LinkIndex> {
        let collision = self.scene.events[self.event].kind.collision();
        collision.map_or_else(Vec::new, |collision| collision.links().collect())
    }

    pub(super) fn contact(&self, touching: &Touching) -> Option<Contact> {
        let set = self.scene.contact_set_of(self.event, &[*touching]);
        set.ok()?.map(|set| set.as_slice()[0])
    }
}
