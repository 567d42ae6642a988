//! Whether what hits touches at its impact: also where a goal says the pose, and no equation of the estimate asks for contact.

use super::joined::GAP_M;
use super::law::CheckedLaw;
use super::meeting::World;
use crate::motion::{About, Doubt, EventEstimate, LinkIndex, Place};
use crate::physics::contact::Frame;

/// The contacts of bodies by themselves that are apart, or inside one another, at their impact.
pub(super) fn doubts(world: &World) -> Vec<Doubt> {
    let events = world.estimate.events.iter();
    let doubts = events.filter_map(|event| {
        let place = Place::Event(event.event);
        Doubt::beyond(About::Gap, place, gap_m(world, event)?, GAP_M)
    });
    doubts.collect()
}

/// Largest gap of the contacts at an event; `None` where none is looked for.
fn gap_m(world: &World, event: &EventEstimate) -> Option<f64> {
    let law = CheckedLaw::new(world.scene, world.estimate, event.event)?;
    let frame = |link: LinkIndex| {
        let pose = world.state_before(link, event)?;
        Some(Frame {
            position_m: pose.position_m,
            orientation: pose.orientation,
        })
    };
    let body = frame(law.link)?;
    let other = match law.other {
        Some(other) => frame(other)?,
        None => Frame::world(),
    };
    let gaps = law.contacts.as_slice().iter().map(|contact| {
        let touch = contact.touch(&body, &other);
        touch.map_or(f64::INFINITY, |touch| touch.gap_m.abs())
    });
    Some(gaps.fold(0.0, f64::max))
}
