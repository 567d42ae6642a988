//! Bodies in the hand.

use crate::config::spanned::Spanned;

use super::error::{Fault, fault};
use super::number::positive;
use super::raw::{RawBody, RawScene, Text};
use crate::motion::{Held, LinkIndex, Scene, Timing};

/// Whether a body is held, and what is known of its tracker then. A held body has no inertia, and
/// nothing pulls at it.
pub(super) fn held(spanned: &Spanned<RawBody>) -> Result<Option<Held>, Fault> {
    let raw = spanned.get_ref();
    let sds = [
        ("tracker_sd_mm", &raw.tracker_sd_mm),
        ("tracker_sd_deg", &raw.tracker_sd_deg),
    ];
    if !raw.held.as_ref().is_some_and(|held| *held.get_ref()) {
        for (key, number) in sds {
            if let Some(number) = number {
                return fault(
                    number.span(),
                    format!("{key} is about the tracker of a held body, expected held = true"),
                );
            }
        }
        return Ok(None);
    }
    let inertia = [
        ("mass_g", raw.mass_g.as_ref().map(Spanned::span)),
        ("mass_kg", raw.mass_kg.as_ref().map(Spanned::span)),
        (
            "density_kg_m3",
            raw.density_kg_m3.as_ref().map(Spanned::span),
        ),
        (
            "moments_kg_m2",
            raw.moments_kg_m2.as_ref().map(Spanned::span),
        ),
        ("force_m_s2", raw.force_m_s2.as_ref().map(Spanned::span)),
        (
            "drag_linear_per_s",
            raw.drag_linear_per_s.as_ref().map(Spanned::span),
        ),
        (
            "drag_quadratic_per_m",
            raw.drag_quadratic_per_m.as_ref().map(Spanned::span),
        ),
        ("lift", raw.lift.as_ref().map(Spanned::span)),
    ];
    for (key, span) in inertia {
        if let Some(span) = span {
            return fault(
                span,
                format!(
                    "{key} does not apply to a held body: it moves as it was tracked, and no impact deflects it"
                ),
            );
        }
    }
    if let Some(track) = raw.track.first() {
        return fault(
            track.span(),
            "a held body moves as one tracker shows its pose, expected topic and tracker in place of [[body.track]]",
        );
    }
    let sd = |(key, number): (&str, &Option<_>)| {
        let number = number.as_ref();
        number.map(|number| positive(key, number)).transpose()
    };
    let [position, orientation] = sds;
    Ok(Some(Held {
        position_sd_m: sd(position)?.map(|sd_mm| sd_mm / 1e3),
        orientation_sd_rad: sd(orientation)?.map(f64::to_radians),
    }))
}

/// Sets what is held, and refuses scenes in which nothing flies or stamps are edited.
pub(super) fn hold(raw: &RawScene, scene: &mut Scene) -> Result<(), Fault> {
    let mut flying = 0;
    for (index, spanned) in raw.body.iter().enumerate() {
        let held = held(spanned)?;
        if held.is_none() {
            flying += 1;
        } else if scene.timing == Timing::Edited {
            return fault(
                spanned.span(),
                "a held body moves as it was tracked, which edited stamps do not tell: expected stamps = \"physical\" or \"tempo\"",
            );
        }
        scene.links[LinkIndex(index)].held = held;
    }
    if flying == 0 {
        return fault(
            raw.name.span(),
            "all bodies are held, expected at least one that flies",
        );
    }
    Ok(())
}

/// Refuses that a held body has a goal.
pub(super) fn check_goal(text: &Text, link: LinkIndex, scene: &Scene) -> Result<(), Fault> {
    if scene.is_held(link) {
        return fault(
            text.span(),
            format!(
                "a goal of {:?}, which is held and goes where it was tracked, expected a body that flies",
                scene.links[link].name
            ),
        );
    }
    Ok(())
}

/// Refuses collisions in which a held body comes first, or meets another.
pub(super) fn check_collision(
    first: &Text,
    link: LinkIndex,
    other: Option<(&Text, LinkIndex)>,
    scene: &Scene,
) -> Result<(), Fault> {
    if !scene.is_held(link) {
        return Ok(());
    }
    let name = |link: LinkIndex| &scene.links[link].name;
    match other {
        Some((text, other)) if scene.is_held(other) => fault(
            text.span(),
            format!(
                "{:?} and {:?} are both held: nothing follows from their collision",
                name(link),
                name(other)
            ),
        ),
        Some((_, other)) => fault(
            first.span(),
            format!(
                "{:?} is held, expected what it deflects first: body = {:?}, other = {:?}",
                name(link),
                name(other),
                name(link)
            ),
        ),
        None => fault(
            first.span(),
            format!(
                "{:?} is held: what it hits does not deflect it, expected a body that flies",
                name(link)
            ),
        ),
    }
}
