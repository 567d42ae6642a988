//! The law of an impact as estimated, and how a body moves while it presses on something.

use super::event::Partner;
use super::quantity::Quantity;
use super::whole::Scene;
use crate::motion::estimate::{Estimate, EventEstimate};
use crate::motion::index::LinkIndex;
use crate::physics::impact::{Law, Pressed, PressedOn};

impl Scene {
    /// The law of impact at an event with the estimated parameters; `None` where it is no collision.
    pub fn law_estimated(&self, estimate: &Estimate, event: usize) -> Option<Law> {
        let collision = self.events[event].kind.collision()?;
        let (law, given) = (collision.law, self.law_of(collision));
        let value = |quantity: Quantity| {
            let free = &self.parameters[self.parameter_of(quantity)?];
            let mut known = estimate.parameters.iter();
            Some(known.find(|of| of.name == free.name)?.value)
        };
        let tilt = |tangent| {
            value(Quantity::Tilt { event, tangent }).unwrap_or(collision.tilt_rad[tangent])
        };
        Some(Law {
            restitution: value(Quantity::Restitution { law }).unwrap_or(given.restitution),
            friction: value(Quantity::Friction { law }).unwrap_or(given.friction),
            tilt_rad: [tilt(0), tilt(1)],
        })
    }

    /// How a link is pressed at a collision that lasts; `None` at others. The scene has its quantities as estimated.
    pub fn pressed(
        &self,
        estimate: &Estimate,
        event: &EventEstimate,
        link: LinkIndex,
    ) -> Option<Pressed> {
        let collision = self.events[event.event].kind.collision()?;
        let mut links = collision.links();
        if event.contact_s <= 0.0 || !links.any(|other| other == link) {
            return None;
        }
        let contacts = self.contact_set(event.event).ok()??;
        let mut links = collision.links();
        let on = match collision.partner {
            Partner::World => PressedOn::World,
            Partner::Link(_) if links.any(|other| self.is_held(other)) => PressedOn::Held,
            Partner::Link(_) => PressedOn::Flying,
        };
        let pull_m_s2 = self.links[link].body.pull_m_s2(&estimate.gravity_m_s2);
        Some(Pressed {
            duration_s: event.contact_s,
            restitution: self.law_estimated(estimate, event.event)?.restitution,
            pull_m_s2: contacts.unborne(&pull_m_s2, on),
            moments_kg_m2: self.links[link].body.moments_kg_m2(),
        })
    }
}
