//! What happens at collisions, contact by contact.

use serde::{Deserialize, Serialize};

use super::read::unknown;
use crate::motion::{Estimate, EventEstimate, Scene};

/// What happens at one contact of a collision, or where a face lands flat as a whole: by the law of impact, from the motion
/// before it; or where a place catches a body. Of the event's first body, against what it hits; places and directions are in
/// world axes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ImpactLine {
    /// What touches.
    pub contact: Option<String>,
    /// Where; of a face the middle of the pressure.
    pub point_m: [f64; 3],
    /// Unit normal, towards the body.
    pub normal: [f64; 3],
    /// Speed along the normal before, positive approaching.
    #[serde(default = "unknown")]
    pub approach_m_s: f64,
    /// Speed across the normal before.
    #[serde(default = "unknown")]
    pub slip_m_s: f64,
    /// Speed along the normal after, positive parting.
    #[serde(default = "unknown")]
    pub parting_m_s: f64,
    /// Speed across the normal after.
    #[serde(default = "unknown")]
    pub slip_after_m_s: f64,
    /// Impulse on the body; on what it hits it is the opposite.
    pub impulse_n_s: [f64; 3],
    /// Its size.
    #[serde(default = "unknown")]
    pub impulse_size_n_s: f64,
    /// Moment on the body beside the impulse: of the friction of a face about the normal, of a pin across its axis.
    pub moment_n_m_s: [f64; 3],
}

/// The contacts of a collision, in the order of the scene.
pub(super) fn impact_lines(
    scene: &Scene,
    estimate: &Estimate,
    event: &EventEstimate,
) -> Vec<ImpactLine> {
    let knocks = estimate.knocks(scene, event);
    let collision = scene.events[event.event].kind.collision();
    let named = collision.map_or(&[][..], |of| &of.contacts);
    let is_each = knocks.len() == named.len();
    let lines = knocks.iter().enumerate().map(|(at, knock)| {
        let [slip_m_s, slip_after_m_s] = knock.slips_m_s();
        let touching = if is_each { &named[at..=at] } else { named };
        ImpactLine {
            contact: scene
                .words_of(event.event, touching)
                .or_else(|| catching(scene, event.event)),
            point_m: knock.point_m.into(),
            normal: knock.normal.into(),
            approach_m_s: knock.approach_m_s(),
            slip_m_s,
            parting_m_s: knock.parting_m_s(),
            slip_after_m_s,
            impulse_n_s: knock.impulse_n_s.into(),
            impulse_size_n_s: knock.impulse_n_s.norm(),
            moment_n_m_s: knock.moment_n_m_s.into(),
        }
    });
    lines.collect()
}

/// The name of what catches a body at a change.
fn catching(scene: &Scene, event: usize) -> Option<String> {
    let link = scene.events[event].kind.change()?;
    let phase = scene.phase_beside(scene.mechanism_of(link), event, true)?;
    Some(phase.name.clone())
}
