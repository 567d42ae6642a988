//! What stays on a surface.

use crate::config::error::{Fault, fault};
use crate::config::event::feature_of;
use crate::config::law::{self, BodyLaws, Laws};
use crate::config::number::index_of;
use crate::config::raw::{RawPhase, Text};
use crate::config::spanned::Spanned;
use crate::motion::{
    ContactLawIndex, EventKind, LinkIndex, OnSurface, Partner, Scene, SupportPhase,
};
use crate::physics::Sustained;
use crate::physics::body::Symmetry;
use crate::physics::contact::Feature;

/// Greatest distance of a ball's middle from its centre of mass \[m\].
const CENTRED_M: f64 = 1e-6;

/// How a body stays on the surface that is meant. Appends the law of a phase that has its own.
pub(super) fn on_surface(
    spanned: &Spanned<RawPhase>,
    text: &Text,
    name: &str,
    link: LinkIndex,
    scene: &Scene,
    of_links: &BodyLaws,
    laws: &mut Laws,
) -> Result<OnSurface, Fault> {
    let raw = spanned.get_ref();
    let names = scene.surfaces.iter().map(|s| s.name.as_str());
    let surface = index_of("surface", text, names)?;
    let Feature::Face { normal, .. } = scene.surfaces[surface].geometry else {
        return fault(text.span(), "expected a plane or a board, or a face");
    };
    let sustained = sustained(&raw.motion)?;
    let feature = feature(raw, link, sustained, scene)?;
    let body = &scene.links[link].body;
    if body.pull_m_s2(&scene.gravity_m_s2).dot(&normal) >= 0.0 {
        return fault(
            text.span(),
            "gravity does not press the body onto the surface, expected one that carries it",
        );
    }
    let law = law(spanned, name, link, sustained, of_links, laws)?;
    Ok(OnSurface {
        sustained,
        surface,
        feature,
        law,
    })
}

fn sustained(text: &Text) -> Result<Sustained, Fault> {
    let mut all = Sustained::ALL.into_iter();
    match all.find(|of| of.as_str() == text.get_ref()) {
        Some(found) => Ok(found),
        None => fault(
            text.span(),
            format!(
                "motion is {:?}, expected \"slide\", \"roll\", \"rest\", \"held\" or \"tumble\"",
                text.get_ref()
            ),
        ),
    }
}

/// The ball or the face that is on the surface.
fn feature(
    raw: &RawPhase,
    link: LinkIndex,
    sustained: Sustained,
    scene: &Scene,
) -> Result<usize, Fault> {
    let of = &scene.links[link];
    let is_ball = |feature: &Feature| {
        matches!(feature, Feature::Point { point_m, radius_m }
            if *radius_m > 0.0 && point_m.norm() <= CENTRED_M)
            && of.body.symmetry() == Symmetry::Spherical
    };
    let index = match &raw.feature {
        Some(text) => feature_of(of, text)?,
        None => match of.features.iter().position(|f| is_ball(&f.geometry)) {
            Some(index) => index,
            None => {
                return fault(
                    raw.name.span(),
                    "missing key `feature`: the face on which the body stays",
                );
            }
        },
    };
    let is_side = |feature: &Feature| match feature {
        Feature::Line {
            point_m,
            direction,
            radius_m,
        } => {
            let is_round = match of.body.symmetry() {
                Symmetry::Spherical => true,
                Symmetry::Axial { axis } => direction[axis].abs() > 1.0 - CENTRED_M,
                Symmetry::Asymmetric => false,
            };
            is_round && *radius_m > 0.0 && point_m.cross(direction).norm() <= CENTRED_M
        }
        _ => false,
    };
    let geometry = &of.features[index].geometry;
    let span = raw.feature.as_ref().map_or(raw.body.span(), Spanned::span);
    match (geometry, sustained) {
        (geometry, _) if is_ball(geometry) => Ok(index),
        (Feature::Face { .. }, Sustained::Roll) => fault(
            span,
            "a face does not roll, expected motion = \"slide\" or \"rest\"",
        ),
        (Feature::Face { .. }, _) => Ok(index),
        (side, Sustained::Slide) if is_side(side) => fault(
            span,
            "the side of a cylinder rolls or rests, expected motion = \"roll\" or \"rest\"",
        ),
        (side, _) if is_side(side) => Ok(index),
        _ => fault(
            span,
            "expected a face, a ball whose middle is its centre of mass and whose moments are equal, or the side of a cylinder about its axis of symmetry",
        ),
    }
}

/// Its own law, or the body's.
fn law(
    spanned: &Spanned<RawPhase>,
    name: &str,
    link: LinkIndex,
    sustained: Sustained,
    of_links: &BodyLaws,
    laws: &mut Laws,
) -> Result<ContactLawIndex, Fault> {
    let raw = spanned.get_ref();
    match (&raw.friction, sustained, of_links[link]) {
        (Some(friction), Sustained::Rest, _) => fault(
            friction.span(),
            "friction does not apply to what rests, expected none",
        ),
        (Some(friction), ..) => {
            if let Some(other) = laws.iter().find(|law| law.name == name) {
                let message = format!(
                    "a body or an event named {:?} has restitution or friction too, expected another name",
                    other.name
                );
                return fault(raw.name.span(), message);
            }
            let law = law::sustained(name, friction)?;
            Ok(laws.push_and_get_key(law))
        }
        (None, Sustained::Slide, Some(law)) => Ok(law),
        (None, Sustained::Rest, _) => Ok(of_links[link].unwrap_or_default()),
        (None, ..) => fault(
            spanned.span(),
            format!(
                "missing key `friction`: what {}s has one of its own",
                sustained.as_str()
            ),
        ),
    }
}

/// Refuses a beginning at which nothing puts the body on the surface, or in that motion.
pub(super) fn check_begin(
    raw: &RawPhase,
    phase: &SupportPhase,
    on: &OnSurface,
    scene: &Scene,
) -> Result<(), Fault> {
    let event = phase.events[0];
    let before = scene.phases.iter().find_map(|other| {
        let on_other = other.on_surface()?;
        let is_before = other.link == phase.link && other.events[1] == event;
        (is_before && on_other.surface == on.surface).then_some(on_other)
    });
    let mechanism = scene.mechanism_of(phase.link);
    match (&scene.events[event].kind, before) {
        (EventKind::Start, _) => Ok(()),
        (EventKind::Change(_), None) if scene.hand_beside(mechanism, event, false) => Ok(()),
        (EventKind::Change(_), Some(before)) if before.sustained <= on.sustained => Ok(()),
        (EventKind::Change(_), Some(before)) => fault(
            raw.from.span(),
            format!(
                "nothing makes what {}s {}: expected an impact between both",
                before.sustained.as_str(),
                on.sustained.as_str()
            ),
        ),
        (EventKind::Change(_), None) => fault(
            raw.from.span(),
            "nothing puts the body onto the surface there, expected a collision, a start, or a phase before it on the same surface",
        ),
        (EventKind::Collision(of), before) => {
            let hits = of.partner == Partner::World
                && of.contacts.iter().all(|t| t.other == Some(on.surface));
            let set = scene.contact_set(event).ok().flatten();
            let lands = hits && set.is_some_and(|set| set.is_flat());
            let feature = &scene.links[phase.link].features[on.feature];
            let is_flat = matches!(feature.geometry, Feature::Face { .. });
            let stops = set.is_some_and(|set| set.is_landing()) && on.sustained == Sustained::Rest;
            let grips = !is_flat
                && on.sustained == Sustained::Roll
                && scene.law_of(of).friction > 0.0
                && !scene.springs_back(of.law);
            if on.sustained != Sustained::Slide && !stops && !grips {
                return fault(
                    raw.from.span(),
                    "an impact leaves slip, expected motion = \"slide\" from it and a change after that, a face that lands flat with friction, or what rolls where friction ends the slip",
                );
            }
            if !hits && before.is_none() {
                return fault(
                    raw.from.span(),
                    "the body does not hit the surface there by a contact that is named, expected surface and feature of the event",
                );
            }
            if hits && is_flat && !lands {
                return fault(
                    raw.from.span(),
                    "the body does not land flat, expected its face, or three corners of it, as what touches at the event",
                );
            }
            if hits && scene.law_of(of).restitution > 0.0 {
                return fault(
                    raw.from.span(),
                    format!(
                        "the body rebounds from the impact, with a restitution of {}, expected 0 of an event after which it stays",
                        scene.law_of(of).restitution
                    ),
                );
            }
            Ok(())
        }
        (EventKind::Collisions { .. } | EventKind::Waypoint(_) | EventKind::End, _) => fault(
            raw.from.span(),
            "no phase begins there, expected a start, one collision or a change",
        ),
    }
}
