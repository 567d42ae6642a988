//! What is in a hand for a while.

use crate::config::error::{Fault, fault};
use crate::config::joint::joint;
use crate::config::raw::{RawJoint, RawPhase, RawScene};
use crate::config::spanned::Spanned;
use crate::motion::{EventKind, InHand, Joint, LinkIndex, Scene, Sees, SupportPhase, Timing};
use crate::physics::tree::JointKind;

/// The words for it, as motions of a phase: in a hand, and knocked about by contacts that no law explains.
pub(super) const MOTIONS: [&str; 2] = ["held", TUMBLE];
const TUMBLE: &str = "tumble";

/// A body in the hand, or one that tumbles, which goes where its own tracker saw it.
pub(super) fn held(
    spanned: &Spanned<RawPhase>,
    link: LinkIndex,
    scene: &Scene,
) -> Result<InHand, Fault> {
    let raw = spanned.get_ref();
    let tumbles = raw.motion.get_ref() == TUMBLE;
    if tumbles && scene.timing != Timing::Known {
        return fault(
            raw.motion.span(),
            "what tumbles is not slower than it was seen, expected stamps = \"physical\"",
        );
    }
    let unused = [
        ("surface", raw.surface.as_ref().map(Spanned::span)),
        ("feature", raw.feature.as_ref().map(Spanned::span)),
        ("friction", raw.friction.as_ref().map(Spanned::span)),
    ];
    for (key, span) in unused {
        if let Some(span) = span {
            let said = format!(
                "{key} is of what stays on a surface, expected none of what is held or tumbles"
            );
            return fault(span, said);
        }
    }
    let mut own = scene
        .tracks
        .iter_enumerated()
        .filter(|(_, of)| of.link == link);
    match (own.next(), own.next()) {
        (Some((track, of)), None) if of.sees == Sees::Pose => Ok(InHand {
            track,
            link_from_tracker: of.link_from_tracker,
            tumbles,
        }),
        _ => fault(
            raw.body.span(),
            "what is held or tumbles goes where its tracker saw it, expected one tracker of it that shows poses",
        ),
    }
}

/// A body that a held one grips, and goes where that was tracked.
pub(super) fn gripped(
    spanned: &Spanned<RawJoint>,
    hand: LinkIndex,
    scene: &Scene,
) -> Result<(Joint, InHand), Fault> {
    let of = joint(spanned, scene)?;
    let made = &of.joint;
    if !matches!(made.kind, JointKind::Fixed) {
        return fault(
            spanned.get_ref().kind.span(),
            "what a hand grips for a while does not move in it, expected kind = \"fixed\"",
        );
    }
    if scene.tracks.iter().any(|track| track.link == of.child) {
        let said = format!(
            "{:?} has a tracker of its own, expected tracked = false, or a [[phase]] with motion = \"held\" in place of the joint",
            scene.links[of.child].name
        );
        return fault(spanned.get_ref().child.span(), said);
    }
    let mut trackers = scene.tracks.iter_enumerated();
    let Some((track, seen)) = trackers.find(|(_, track)| track.link == hand) else {
        return fault(
            spanned.span(),
            "no tracker sees the held body, expected one that does",
        );
    };
    let hand_from_child = made.parent_from_joint * made.link_from_joint.inverse();
    let grip = InHand {
        track,
        link_from_tracker: hand_from_child.inverse() * seen.link_from_tracker,
        tumbles: false,
    };
    Ok((of, grip))
}

/// Whether a hand grips the body that is called so for a while, so that no tracker needs to see it.
pub(in crate::config) fn grips(raw: &RawScene, scene: &Scene, name: &str) -> bool {
    let mut joints = raw.joint.iter().map(Spanned::get_ref);
    joints.any(|joint| {
        let is_hand = |text: &str| {
            let mut links = scene.links.iter();
            links.any(|link| link.held.is_some() && link.name == text)
        };
        let parent = joint.parent.as_ref();
        joint.is_for_a_while()
            && joint.child.get_ref() == name
            && parent.is_some_and(|parent| is_hand(parent.get_ref()))
    })
}

/// Refuses a hand that takes or leaves a body at an impact, or hands it to another, and what tumbles so.
pub(super) fn check_ends(
    span: std::ops::Range<usize>,
    phase: &SupportPhase,
    scene: &Scene,
) -> Result<(), Fault> {
    let is_met = phase.events.iter().all(|event| {
        let kind = &scene.events[*event].kind;
        matches!(kind, EventKind::Start | EventKind::End) || kind.change().is_some()
    });
    if !is_met {
        return fault(
            span,
            "what a hand carries, or tumbles, begins and ends at changes, expected from and until that are a start, a change or an end",
        );
    }
    let [from, until] = phase.events.map(|event| &scene.events[event].kind);
    if (from, until) == (&EventKind::Start, &EventKind::End) {
        return fault(
            span,
            "the body is in the hand, or tumbles, from the start to the end, so that nothing of it is estimated: expected a change at which it is let go, or taken; what is held throughout has held = true",
        );
    }
    let mechanism = scene.mechanism_of(phase.link);
    let next = scene.phase_beside(mechanism, phase.events[1], true);
    if next.is_some_and(|next| next.in_hand().is_some()) {
        return fault(
            span,
            "the body is in a hand, or tumbles, before and after the event, expected one phase",
        );
    }
    Ok(())
}
