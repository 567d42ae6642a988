//! Contacts that pull. At several contacts at once the law of impact lets each rebound as the restitution says; where one
//! comes far more slowly than the others, that takes an impulse which draws it back, and no contact can exert one: it would
//! come off, which is another motion. Three contacts of a face stand for all of it: none pulls where the surface presses
//! within the solid's outline.

use super::carried;
use super::law::CheckedLaw;
use super::meeting::World;
use crate::motion::Pull;

/// The pulls of a motion of bodies by themselves, of every collision at several contacts that has one.
pub(super) fn pulls(world: &World) -> Vec<Pull> {
    let events = world.estimate.events.iter();
    let pulls = events.filter_map(|event| {
        let law = CheckedLaw::new(world.scene, world.estimate, event.event)?;
        let count = law.contacts.as_slice().len();
        if count == 1 {
            return None;
        }
        let other = match law.other {
            Some(other) => Some(world.state_before(other, event)?),
            None => None,
        };
        let state = world.state_before(law.link, event)?;
        let impact = law.impact(&state, other.as_ref())?;
        let link = &world.links[law.link];
        if law.other.is_none() && carried::presses_within(world, link, &state, &law, &impact) {
            return None;
        }
        of(event.event, &impact.normal_impulses_n_s[..count])
    });
    pulls.collect()
}

/// The pull at an event, if one of several impulses along normals does.
pub(super) fn of(event: usize, impulses_n_s: &[f64]) -> Option<Pull> {
    let greatest = |of: &mut dyn Iterator<Item = f64>| of.fold(0.0, f64::max);
    let pull = greatest(&mut impulses_n_s.iter().map(|impulse| -impulse));
    let size = greatest(&mut impulses_n_s.iter().map(|impulse| impulse.abs()));
    // One contact alone pulls where it recedes, which is looked at by itself.
    (impulses_n_s.len() > 1 && pull > 0.0).then(|| Pull {
        event,
        share: pull / size,
    })
}
