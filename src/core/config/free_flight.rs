//! Events at which nothing hits: starts, changes of phase, waypoints, ends.

use std::ops::Range;

use crate::config::spanned::Spanned;

use super::error::{Fault, fault};
use super::raw::{RawEvent, Text};
use crate::motion::{EventKind, LinkIndex, Scene, Timing};

/// A start or an end, which are of all bodies.
pub(super) fn plain(event: &RawEvent, kind: EventKind) -> Result<EventKind, Fault> {
    match &event.body {
        Some(body) => does_not_apply("body", body.span(), &kind),
        None => without_contact(event, kind),
    }
}

/// A moment of a flight of one body.
pub(super) fn waypoint(
    event: &RawEvent,
    body: Option<(&Text, LinkIndex)>,
    scene: &Scene,
) -> Result<EventKind, Fault> {
    if scene.timing == Timing::Edited {
        return fault(
            event.kind.span(),
            "a waypoint is about where its mark is, and edited stamps have no marks, expected stamps \
             \"physical\" or \"tempo\"",
        );
    }
    let Some((text, link)) = body else {
        return fault(
            event.kind.span(),
            "missing key `body`: a waypoint is of the flight of one body",
        );
    };
    if scene.is_held(link) {
        return fault(
            text.span(),
            format!(
                "a waypoint of {:?}, which is held and goes where it was tracked, expected a body that flies",
                scene.links[link].name
            ),
        );
    }
    without_contact(event, EventKind::Waypoint(link))
}

/// A change of the phase of one body.
pub(super) fn change(event: &RawEvent, body: Option<LinkIndex>) -> Result<EventKind, Fault> {
    match body {
        Some(link) => without_contact(event, EventKind::Change(link)),
        None => fault(
            event.kind.span(),
            "missing key `body`: a change is of the phase of one body",
        ),
    }
}

fn without_contact(event: &RawEvent, kind: EventKind) -> Result<EventKind, Fault> {
    for (key, span) in [
        ("feature", event.feature.as_ref().map(Spanned::span)),
        ("features", event.features.as_ref().map(Spanned::span)),
        ("surface", event.surface.as_ref().map(Spanned::span)),
        ("other", event.other.as_ref().map(Spanned::span)),
        (
            "other_feature",
            event.other_feature.as_ref().map(Spanned::span),
        ),
        ("restitution", event.restitution.as_ref().map(Spanned::span)),
        ("bumper", event.bumper.as_ref().map(Spanned::span)),
        ("friction", event.friction.as_ref().map(Spanned::span)),
        (
            "tangential_restitution",
            event.tangential_restitution.as_ref().map(Spanned::span),
        ),
        ("count", event.count.as_ref().map(Spanned::span)),
    ] {
        if let Some(span) = span {
            return does_not_apply(key, span, &kind);
        }
    }
    Ok(kind)
}

fn does_not_apply<T>(key: &str, span: Range<usize>, kind: &EventKind) -> Result<T, Fault> {
    let kind = kind.as_str();
    fault(
        span,
        format!("{key} does not apply to an event of kind {kind:?}"),
    )
}
