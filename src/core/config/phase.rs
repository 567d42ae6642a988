//! Phases: bodies that stay on surfaces.

use super::error::{Fault, fault};
use super::event::{feature_of, link_of};
use super::law::{self, BodyLaws, Laws};
use super::number::{Taken, index_of, name};
use super::raw::{RawPhase, RawScene, Text};
use super::spanned::Spanned;
use crate::motion::{ContactLawIndex, EventKind, LinkIndex, Partner, Scene, SupportPhase, Timing};
use crate::physics::Sustained;
use crate::physics::body::Symmetry;
use crate::physics::contact::Feature;

/// Greatest distance of a ball's middle from its centre of mass \[m\].
const CENTRED_M: f64 = 1e-6;

/// The phases of a scene whose events are known. Appends the laws of those that have their own.
pub(super) fn phases(
    raw: &RawScene,
    scene: &Scene,
    of_links: &BodyLaws,
    laws: &mut Laws,
) -> Result<Vec<SupportPhase>, Fault> {
    let mut phases: Vec<SupportPhase> = Vec::new();
    let mut taken = Taken::default();
    for spanned in &raw.phase {
        let of = spanned.get_ref();
        let name = name("phase", &of.name)?;
        taken.take("phase", &of.name, &name)?;
        let phase = phase(spanned, name, scene, of_links, laws)?;
        if let Some(other) = phases.iter().find(|other| {
            other.link == phase.link
                && other.events[0] < phase.events[1]
                && phase.events[0] < other.events[1]
        }) {
            let message = format!(
                "{:?} and {:?} are of one body at one time, expected one after the other",
                other.name, phase.name
            );
            return fault(of.from.span(), message);
        }
        phases.push(phase);
    }
    for (event, of) in scene.events.iter().enumerate() {
        let Some(link) = of.kind.change() else {
            continue;
        };
        let is_end = |phase: &SupportPhase| phase.link == link && phase.events.contains(&event);
        if !phases.iter().any(is_end) {
            return fault(
                raw.event[event].span(),
                "nothing changes at the event, expected a [[phase]] of its body that begins or ends there",
            );
        }
    }
    Ok(phases)
}

fn phase(
    spanned: &Spanned<RawPhase>,
    name: String,
    scene: &Scene,
    of_links: &BodyLaws,
    laws: &mut Laws,
) -> Result<SupportPhase, Fault> {
    let raw = spanned.get_ref();
    let link = link_of(&raw.body, scene)?;
    let mechanism = scene.mechanism_of(link);
    if scene.timing == Timing::Edited {
        return fault(
            spanned.span(),
            "phases are between marks, which edited stamps do not have, expected stamps \"physical\" or \"tempo\"",
        );
    }
    if scene.is_held(link) || scene.joint_tree(mechanism).is_some() {
        return fault(
            raw.body.span(),
            format!(
                "{:?} is in the hand or joined to something, expected a body by itself",
                scene.links[link].name
            ),
        );
    }
    let names = scene.surfaces.iter().map(|s| s.name.as_str());
    let surface = index_of("surface", &raw.surface, names)?;
    let Feature::Face { normal, .. } = scene.surfaces[surface].geometry else {
        return fault(raw.surface.span(), "expected a plane or a board, or a face");
    };
    let sustained = sustained(&raw.motion)?;
    let feature = feature(raw, link, sustained, scene)?;
    let body = &scene.links[link].body;
    if body.pull_m_s2(&scene.gravity_m_s2).dot(&normal) >= 0.0 {
        return fault(
            raw.surface.span(),
            "gravity does not press the body onto the surface, expected one that carries it",
        );
    }
    if !body.drag().is_none() {
        return fault(
            raw.body.span(),
            "drag does not act on what stays on a surface, expected a body without drag",
        );
    }
    let law = law(spanned, &name, link, sustained, of_links, laws)?;
    let event = |text: &Text| index_of("event", text, scene.events.iter().map(|e| e.name.as_str()));
    let events = [event(&raw.from)?, event(&raw.until)?];
    let concerns = |event: &usize| scene.concerns(*event, mechanism);
    for (text, event) in [&raw.from, &raw.until].into_iter().zip(&events) {
        if !concerns(event) {
            let message = format!(
                "nothing begins or ends for {:?} at the event, expected a start, an end, a collision or a change of it",
                scene.links[link].name
            );
            return fault(text.span(), message);
        }
    }
    let between = (events[0] + 1..events[1]).find(concerns);
    if events[0] >= events[1] || between.is_some() {
        let message = match between {
            Some(event) => format!(
                "{:?} is between both events, expected a phase up to it and one from it on",
                scene.events[event].name
            ),
            None => "it ends before it begins, expected an event after `from`".into(),
        };
        return fault(raw.until.span(), message);
    }
    Ok(SupportPhase {
        name,
        link,
        sustained,
        surface,
        feature,
        law,
        events,
    })
}

fn sustained(text: &Text) -> Result<Sustained, Fault> {
    let mut all = Sustained::ALL.into_iter();
    match all.find(|of| of.as_str() == text.get_ref()) {
        Some(found) => Ok(found),
        None => fault(
            text.span(),
            format!(
                "motion is {:?}, expected \"slide\", \"roll\" or \"rest\"",
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
    let geometry = &of.features[index].geometry;
    let span = raw.feature.as_ref().map_or(raw.body.span(), Spanned::span);
    match (geometry, sustained) {
        (geometry, _) if is_ball(geometry) => Ok(index),
        (Feature::Face { .. }, Sustained::Roll) => fault(
            span,
            "a face does not roll, expected motion = \"slide\" or \"rest\"",
        ),
        (Feature::Face { .. }, _) => Ok(index),
        _ => fault(
            span,
            "expected a face, or a ball whose middle is its centre of mass and whose moments are equal",
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

/// Refuses beginnings at which nothing puts the body on the surface, or in that motion.
pub(super) fn check_beginnings(raw: &RawScene, scene: &Scene) -> Result<(), Fault> {
    let mut all = raw.phase.iter().zip(&scene.phases);
    all.try_for_each(|(spanned, phase)| check_begin(spanned.get_ref(), phase, scene))
}

fn check_begin(raw: &RawPhase, phase: &SupportPhase, scene: &Scene) -> Result<(), Fault> {
    let event = phase.events[0];
    let before = scene.phases.iter().find(|other| {
        other.link == phase.link && other.events[1] == event && other.surface == phase.surface
    });
    match (&scene.events[event].kind, before) {
        (EventKind::Start, _) => Ok(()),
        (EventKind::Change(_), Some(before)) if before.sustained <= phase.sustained => Ok(()),
        (EventKind::Change(_), Some(before)) => fault(
            raw.from.span(),
            format!(
                "nothing makes what {}s {}: expected an impact between both",
                before.sustained.as_str(),
                phase.sustained.as_str()
            ),
        ),
        (EventKind::Change(_), None) => fault(
            raw.from.span(),
            "nothing puts the body onto the surface there, expected a collision, a start, or a phase before it on the same surface",
        ),
        (EventKind::Collision(of), before) => {
            let hits = of.partner == Partner::World
                && of.contacts.iter().all(|t| t.other == Some(phase.surface));
            let set = scene.contact_set(event).ok().flatten();
            let lands = hits && set.is_some_and(|set| set.is_flat());
            let is_flat = scene.support(phase).radius_m.is_none();
            let stops =
                set.is_some_and(|set| set.is_landing()) && phase.sustained == Sustained::Rest;
            if phase.sustained != Sustained::Slide && !stops {
                return fault(
                    raw.from.span(),
                    "an impact leaves slip, expected motion = \"slide\" from it and a change after that, or a face that lands flat with friction",
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
