//! The law of an impact as estimated, and how a body moves while it presses on something.

use super::event::Partner;
use super::quantity::Quantity;
use super::whole::Scene;
use crate::motion::estimate::{Estimate, EventEstimate};
use crate::motion::index::LinkIndex;
use crate::physics::State;
use crate::physics::impact::{Law, Pressed, PressedOn, Side};

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
            tangential_restitution: value(Quantity::TangentialRestitution { law })
                .unwrap_or(given.tangential_restitution),
            tilt_rad: [tilt(0), tilt(1)],
        })
    }

    /// How a link is pressed at a collision that lasts; `None` at others, and where a contact is degenerate or a flight is
    /// missing. The scene has its quantities as estimated.
    pub fn pressed(
        &self,
        estimate: &Estimate,
        event: &EventEstimate,
        link: LinkIndex,
    ) -> Option<Pressed> {
        if event.contact_s <= 0.0 {
            return None;
        }
        let speed_m_s = self.closing_m_s(estimate, event)?;
        self.pressed_at(estimate, event, link, speed_m_s)
    }

    /// The same at a speed of the first contact along its normal [m/s].
    pub fn pressed_at(
        &self,
        estimate: &Estimate,
        event: &EventEstimate,
        link: LinkIndex,
        speed_m_s: f64,
    ) -> Option<Pressed> {
        let collision = self.events[event.event].kind.collision()?;
        if event.contact_s <= 0.0 {
            return None;
        }
        let contacts = self.contact_set(event.event).ok()??;
        let mut links = collision.links();
        let on = match collision.partner {
            Partner::World => PressedOn::World,
            Partner::Link(_) if links.any(|other| self.is_held(other)) => PressedOn::Held,
            Partner::Link(_) => PressedOn::Flying,
        };
        let restitution = self.law_estimated(estimate, event.event)?.restitution;
        let (body, gravity) = (&self.links[link].body, &estimate.gravity_m_s2);
        Some(Pressed::new(
            &contacts,
            on,
            body,
            gravity,
            speed_m_s,
            restitution,
            event.contact_s,
        ))
    }

    /// The speed with which the first contact of a collision closes, along its normal, before it [m/s]; `None` where it is
    /// degenerate or a flight is missing.
    fn closing_m_s(&self, estimate: &Estimate, event: &EventEstimate) -> Option<f64> {
        let collision = self.events[event.event].kind.collision()?;
        let contacts = self.contact_set(event.event).ok()??;
        let law = self.law_estimated(estimate, event.event)?;
        let states = collision
            .links()
            .map(|link| estimate.arriving(self, link, event.time_s));
        let states: Vec<State> = states.collect::<Option<_>>()?;
        let sides = collision.links().zip(&states).map(|(link, state)| Side {
            body: &self.links[link].body,
            state,
        });
        let sides: Vec<Side> = sides.collect();
        let impact = contacts.impact(sides.first()?, sides.get(1), &law).ok()?;
        Some(impact.speeds_m_s[0])
    }
}
