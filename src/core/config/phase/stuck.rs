//! Bodies that fly, meet, and are one from then on.

use crate::config::error::{Fault, fault};
use crate::config::joint::joint;
use crate::config::number::index_of;
use crate::config::raw::{RawJoint, RawScene};
use crate::config::spanned::Spanned;
use crate::motion::{Joint, LinkIndex, Scene, Sees, StuckTo, SupportPhase, SupportedBy, Timing};
use nalgebra::Vector3;

/// Whether a joint between two bodies that are not held says that they stick together.
pub(super) fn is_meant(of: &RawJoint) -> bool {
    of.kind.get_ref() == "fixed"
}

/// What sticks to another body.
pub(super) fn stuck(
    spanned: &Spanned<RawJoint>,
    parent: LinkIndex,
    scene: &Scene,
) -> Result<(Joint, StuckTo), Fault> {
    let raw = spanned.get_ref();
    let of = joint(spanned, scene)?;
    let unused = [
        ("parent_at_mm", raw.parent_at_mm.as_ref().map(Spanned::span)),
        ("child_at_mm", raw.child_at_mm.as_ref().map(Spanned::span)),
        (
            "child_orientation_wxyz",
            raw.child_orientation_wxyz.as_ref().map(Spanned::span),
        ),
        ("limits_deg", raw.limits_deg.as_ref().map(Spanned::span)),
    ];
    for (key, span) in unused {
        if let Some(span) = span {
            let said = format!(
                "two bodies stick together where their trackers show it, expected no {key}"
            );
            return fault(span, said);
        }
    }
    if let Some(until) = &raw.until {
        return fault(
            until.span(),
            "bodies that stick together do so to the end, expected no until",
        );
    }
    if let Timing::Unknown { .. } = scene.timing {
        return fault(
            spanned.span(),
            "bodies stick together where the tempo is known, expected stamps = \"physical\"",
        );
    }
    let text = match &raw.parent {
        Some(text) => text,
        None => &raw.child,
    };
    for (link, span) in [(parent, text.span()), (of.child, raw.child.span())] {
        let name = &scene.links[link].name;
        let body = &scene.links[link].body;
        if body.force_m_s2() != Vector3::zeros() || !body.feels_no_air() {
            let said = format!(
                "{name:?} sticks to another body, on which only gravity acts, expected neither drag nor force_m_s2 nor lift of it"
            );
            return fault(span, said);
        }
        let mut own = scene.tracks.iter().filter(|track| track.link == link);
        if !own.any(|track| track.sees == Sees::Pose) {
            let said = format!(
                "{name:?} sticks to another body where trackers show it, expected a tracker of it that shows poses"
            );
            return fault(span, said);
        }
    }
    if let Some(text) = &raw.from {
        let names = scene.events.iter().map(|event| event.name.as_str());
        let from = index_of("event", text, names)?;
        if scene.events[from].kind.change() != Some(of.child) {
            let said = format!(
                "bodies stick together from a change on, in place of a collision, expected an event with kind = \"change\" and body = {:?}",
                scene.links[of.child].name
            );
            return fault(text.span(), said);
        }
        let later = (from + 1..scene.events.len()).find(|event| {
            let links = scene.links_at(*event);
            links.contains(&parent) || links.contains(&of.child)
        });
        if let Some(later) = later {
            let said = format!(
                "{:?} is after {:?}, from which on both bodies fly as one to the end: what hits them then is not computed, expected the end before it",
                scene.events[later].name,
                text.get_ref()
            );
            return fault(text.span(), said);
        }
    }
    let by = StuckTo {
        other: parent,
        part: None,
    };
    Ok((of, by))
}

/// The phase of the body to which one sticks in a phase.
pub(super) fn partner(phase: &SupportPhase) -> Option<SupportPhase> {
    let other = phase.stuck_to()?.other;
    Some(SupportPhase {
        link: other,
        by: SupportedBy::Body(StuckTo {
            other: phase.link,
            part: None,
        }),
        ..phase.clone()
    })
}

/// Refuses bodies that are in other phases, too, or that several stick to.
pub(super) fn check_alone(
    raw: &RawScene,
    partner: &SupportPhase,
    phases: &[SupportPhase],
    scene: &Scene,
) -> Result<(), Fault> {
    let links = [
        Some(partner.link),
        partner.stuck_to().map(|stuck| stuck.other),
    ];
    let is_other = |phase: &&SupportPhase| phase.name != partner.name;
    let mut others = phases.iter().filter(is_other);
    let Some(other) = others.find(|phase| links.contains(&Some(phase.link))) else {
        return Ok(());
    };
    let named = |of: &&Spanned<RawJoint>| *of.get_ref().name.get_ref() == partner.name;
    let span = raw.joint.iter().find(named).map_or(0..0, Spanned::span);
    let said = format!(
        "{:?} sticks to another body and is in {:?}, too, expected no other phase of what sticks together: it flies before",
        scene.links[other.link].name, other.name
    );
    fault(span, said)
}
