//! What joined bodies cannot be part of.

use std::ops::Range;

use toml::Spanned;

use crate::config::error::{Fault, fault};
use crate::config::raw::{RawEvent, RawScene};
use crate::motion::{LinkIndex, Scene, Timing};

/// Refuses a scene that asks of joined bodies what is not done for them.
pub(super) fn refuse(raw: &RawScene, scene: &Scene, joint: &Range<usize>) -> Result<(), Fault> {
    if scene.timing != Timing::Known {
        return fault(
            raw.timing.stamps.span(),
            "joined bodies are estimated from physical stamps, expected stamps = \"physical\"",
        );
    }
    for event in &raw.event {
        refuse_event(event)?;
    }
    for (span, said) in unused(raw) {
        if let Some(span) = span {
            return fault(span, said);
        }
    }
    let joined = |link: LinkIndex| {
        raw.joint.iter().any(|of| {
            let of = of.get_ref();
            let names = [Some(&of.child), of.parent.as_ref()];
            names
                .iter()
                .flatten()
                .any(|text| *text.get_ref() == scene.links[link].name)
        })
    };
    if let Some(link) = scene.links.keys().find(|link| !joined(*link)) {
        let said = format!(
            "{:?} is not joined, expected a joint for it: a scene has either joined bodies or bodies by themselves",
            scene.links[link].name
        );
        return fault(joint.clone(), said);
    }
    Ok(())
}

/// Collisions of joined bodies are with the static world, at one contact that the scene names.
fn refuse_event(spanned: &Spanned<RawEvent>) -> Result<(), Fault> {
    let event = spanned.get_ref();
    if event.kind.get_ref() != "collision" {
        return Ok(());
    }
    let refused = [
        (
            event.other.as_ref().map(Spanned::span),
            "joined bodies collide with the static world alone, expected surface in place of other",
        ),
        (
            event.features.as_ref().map(Spanned::span),
            "joined bodies touch at one contact at a time, expected one feature",
        ),
        (
            event.count.as_ref().map(Spanned::span),
            "collisions of joined bodies are listed one by one, expected no count",
        ),
    ];
    for (span, said) in refused {
        if let Some(span) = span {
            return fault(span, said);
        }
    }
    if event.feature.is_none() || event.surface.is_none() {
        let said = "what touches is not inferred of joined bodies, expected feature and surface";
        return fault(spanned.span(), said);
    }
    Ok(())
}

/// Keys that the motion of joined bodies does not heed, and what is expected instead.
fn unused(raw: &RawScene) -> impl Iterator<Item = (Option<Range<usize>>, &'static str)> {
    fn span<T>(of: &Option<Spanned<T>>) -> Option<Range<usize>> {
        of.as_ref().map(Spanned::span)
    }
    let of_scene = [(
        raw.free.first().map(|free| free.quantity.span()),
        "nothing is estimated beside the motion of joined bodies, expected no [[free]]",
    )];
    let of_bodies = raw.body.iter().flat_map(|body| {
        let body = body.get_ref();
        let said = "joined bodies fly in gravity alone, expected neither force nor drag";
        [
            (span(&body.force_m_s2), said),
            (span(&body.drag_linear_per_s), said),
            (span(&body.drag_quadratic_per_m), said),
        ]
    });
    let tracks = raw.body.iter().flat_map(|body| &body.get_ref().track);
    let of_tracks = tracks.map(|track| {
        let said = "samples of joined bodies weigh what the scene says, expected no weights";
        (span(&track.get_ref().weights), said)
    });
    let of_events = raw.event.iter().flat_map(|event| {
        let event = event.get_ref();
        let said = "times of joined bodies' events are told by their marks alone, expected no other time of the event";
        [&event.time_sd_ms, &event.earliest_ms, &event.latest_ms]
            .map(|of| (span(of), said))
            .into_iter()
            .chain([(span(&event.time), said)])
    });
    let at_rest = raw.goal.iter().map(|goal| {
        let said = "joined bodies are not led to how they rest, expected no face_up";
        (span(&goal.get_ref().face_up), said)
    });
    let of_goals = raw.goal.iter().flat_map(|goal| {
        let goal = goal.get_ref();
        let said = "joined bodies begin and end at the marks, expected no goal of a time";
        [
            (span(&goal.time_ms), said),
            (span(&goal.time_within_ms), said),
        ]
    });
    of_scene
        .into_iter()
        .chain(of_bodies)
        .chain(of_tracks)
        .chain(of_events)
        .chain(of_goals)
        .chain(at_rest)
}
