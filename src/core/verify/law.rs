//! The law of impact at a collision, with the estimated parameters.

use crate::motion::{Estimate, LinkIndex, Partner, Scene};
use crate::physics::State;
use crate::physics::impact::{self, ContactSet, Impact, Pressed, Side};

/// The bodies and contacts of a collision, and its law.
pub(super) struct CheckedLaw<'a> {
    scene: &'a Scene,
    pub(super) contacts: ContactSet,
    pub(super) law: impact::Law,
    pub(super) link: LinkIndex,
    pub(super) other: Option<LinkIndex>,
}

impl<'a> CheckedLaw<'a> {
    /// The law at an event; `None` where it is no collision, where the scene leaves a feature
    /// open, and where the contacts are not supported.
    pub(super) fn new(scene: &'a Scene, estimate: &Estimate, event: usize) -> Option<Self> {
        let collision = scene.events[event].kind.collision()?;
        let contacts = scene.contact_set(event).ok()??;
        Some(Self {
            scene,
            contacts,
            law: scene.law_estimated(estimate, event)?,
            link: collision.link,
            other: match collision.partner {
                Partner::World => None,
                Partner::Link(other) => Some(other),
            },
        })
    }

    /// Presses by the weight of what is pressed, too.
    pub(super) fn press(&mut self, pressed: Option<&Pressed>) {
        self.law = pressed.map_or(self.law, |pressed| pressed.law(&self.law));
    }

    /// The states after the impact, of the link and of the other link if there is one; `None` where
    /// the contacts are degenerate in these poses, or a state is missing.
    pub(super) fn after(
        &self,
        state: &State,
        other: Option<&State>,
    ) -> Option<(State, Option<State>)> {
        let impact = self.impact(state, other)?;
        Some((
            impact.after[0].in_pose_of(state),
            other.map(|other| impact.after[1].in_pose_of(other)),
        ))
    }

    /// The impact of the link, and of the other link if there is one, in these states; `None` as of
    /// [`CheckedLaw::after`].
    pub(super) fn impact(&self, state: &State, other: Option<&State>) -> Option<Impact> {
        let side = |link: LinkIndex, state| Side {
            body: &self.scene.links[link].body,
            state,
        };
        let partner = match self.other {
            None => None,
            Some(link) => Some(side(link, other?)),
        };
        let a = side(self.link, state);
        self.contacts.impact(&a, partner.as_ref(), &self.law).ok()
    }
}
