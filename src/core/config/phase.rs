//! Phases: bodies that stay on surfaces, are in a hand, are held still, are tied to the world for a while, or stick together.

mod hand;
mod on_surface;
mod pivot;
mod stuck;

use std::ops::Range;

pub(super) use self::hand::grips;

use super::error::{Fault, fault};
use super::event::link_of;
use super::law::{BodyLaws, Laws};
use super::number::{Taken, index_of, name};
use super::raw::{RawScene, Text};
use crate::motion::{EventKind, LinkIndex, Scene, SupportPhase, SupportedBy, Timing};

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
        let link = carried(&of.body, scene)?;
        let by = match &of.surface {
            _ if hand::MOTIONS.contains(&of.motion.get_ref().as_str()) => {
                SupportedBy::Hand(hand::held(spanned, link, scene)?)
            }
            Some(surface) => SupportedBy::Surface(on_surface::on_surface(
                spanned, surface, &name, link, scene, of_links, laws,
            )?),
            None => SupportedBy::Pivot(pivot::still(spanned)?),
        };
        refuse_drag(&of.body, link, &by, scene)?;
        let ends = [Some(&of.from), Some(&of.until)];
        let phase = phase(name, link, by, ends, spanned.span(), scene)?;
        push(&mut phases, phase, of.from.span())?;
    }
    let mut partners: Vec<SupportPhase> = Vec::new();
    for spanned in raw.joint.iter().filter(|of| of.get_ref().is_for_a_while()) {
        let of = spanned.get_ref();
        let parent = of.parent.as_ref().map(|text| link_of(text, scene));
        let (joint, by) = match parent.transpose()? {
            Some(hand) if scene.is_held(hand) => {
                let (joint, grip) = hand::gripped(spanned, hand, scene)?;
                (joint, SupportedBy::Hand(grip))
            }
            Some(parent) if stuck::is_meant(of) => {
                for text in of.parent.iter().chain([&of.child]) {
                    carried(text, scene)?;
                }
                let (joint, by) = stuck::stuck(spanned, parent, scene)?;
                (joint, SupportedBy::Body(by))
            }
            _ => {
                let (joint, at) = pivot::tied(spanned, scene)?;
                (joint, SupportedBy::Pivot(at))
            }
        };
        taken.take("phase", &of.name, &joint.name)?;
        let link = carried(&of.child, scene)?;
        refuse_drag(&of.child, link, &by, scene)?;
        let ends = [of.from.as_ref(), of.until.as_ref()];
        let phase = phase(joint.name, link, by, ends, spanned.span(), scene)?;
        partners.extend(stuck::partner(&phase));
        push(&mut phases, phase, spanned.span())?;
    }
    // After all, so that the others are in the order of their tables.
    for partner in partners {
        stuck::check_alone(raw, &partner, &phases, scene)?;
        phases.push(partner);
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

/// Adds a phase that has the time of its body to itself.
fn push(
    phases: &mut Vec<SupportPhase>,
    phase: SupportPhase,
    span: Range<usize>,
) -> Result<(), Fault> {
    if let Some(other) = phases.iter().find(|other| {
        other.link == phase.link
            && other.events[0] < phase.events[1]
            && phase.events[0] < other.events[1]
    }) {
        let message = format!(
            "{:?} and {:?} are of one body at one time, expected one after the other",
            other.name, phase.name
        );
        return fault(span, message);
    }
    phases.push(phase);
    Ok(())
}

/// The body that is meant, if it may be carried.
fn carried(text: &Text, scene: &Scene) -> Result<LinkIndex, Fault> {
    let link = link_of(text, scene)?;
    if scene.is_held(link) || scene.joint_tree(scene.mechanism_of(link)).is_some() {
        return fault(
            text.span(),
            format!(
                "{:?} is in the hand or joined to something, expected a body by itself",
                scene.links[link].name
            ),
        );
    }
    Ok(link)
}

/// Refuses drag and lift on what something carries that is no hand.
fn refuse_drag(text: &Text, link: LinkIndex, by: &SupportedBy, scene: &Scene) -> Result<(), Fault> {
    let is_driven = matches!(by, SupportedBy::Hand(_));
    if is_driven || scene.links[link].body.feels_no_air() {
        return Ok(());
    }
    fault(
        text.span(),
        "drag and lift do not act on what something carries, expected a body without them",
    )
}

/// A phase between two events of its body, by default from the start to the end.
fn phase(
    name: String,
    link: LinkIndex,
    by: SupportedBy,
    ends: [Option<&Text>; 2],
    span: Range<usize>,
    scene: &Scene,
) -> Result<SupportPhase, Fault> {
    let mechanism = scene.mechanism_of(link);
    if scene.timing == Timing::Edited {
        return fault(
            span,
            "phases are between marks, which edited stamps do not have, expected stamps \"physical\" or \"tempo\"",
        );
    }
    let concerns = |event: &usize| scene.concerns(*event, mechanism);
    let event = |text: Option<&Text>, otherwise: EventKind, key: &str| match text {
        Some(text) => {
            let names = scene.events.iter().map(|e| e.name.as_str());
            let event = index_of("event", text, names)?;
            if concerns(&event) {
                return Ok(event);
            }
            let message = format!(
                "nothing begins or ends for {:?} at the event, expected a start, an end, a collision or a change of it",
                scene.links[link].name
            );
            fault(text.span(), message)
        }
        None => match scene.events.iter().position(|of| of.kind == otherwise) {
            Some(event) => Ok(event),
            None => fault(
                span.clone(),
                format!(
                    "missing key `{key}`: there is no event of kind {:?}",
                    otherwise.as_str()
                ),
            ),
        },
    };
    let events = [
        event(ends[0], EventKind::Start, "from")?,
        event(ends[1], EventKind::End, "until")?,
    ];
    let between = (events[0] + 1..events[1]).find(concerns);
    if events[0] >= events[1] || between.is_some() {
        let message = match between {
            Some(event) => format!(
                "{:?} is between both events, expected a phase up to it and one from it on",
                scene.events[event].name
            ),
            None => "it ends before it begins, expected an event after `from`".into(),
        };
        return fault(ends[1].map_or(span, |text| text.span()), message);
    }
    Ok(SupportPhase {
        name,
        link,
        by,
        events,
    })
}

/// Refuses beginnings at which nothing brings the body into the phase.
pub(super) fn check_beginnings(raw: &RawScene, scene: &Scene) -> Result<(), Fault> {
    for (spanned, phase) in raw.phase.iter().zip(&scene.phases) {
        if let Some(on) = phase.on_surface() {
            on_surface::check_begin(spanned.get_ref(), phase, on, scene)?;
        }
    }
    let froms = raw.phase.iter().map(|of| of.get_ref().from.span());
    let tied = raw.joint.iter().filter(|of| of.get_ref().is_for_a_while());
    let froms = froms.chain(tied.map(|of| match &of.get_ref().from {
        Some(from) => from.span(),
        None => of.span(),
    }));
    for (span, phase) in froms.zip(&scene.phases) {
        if phase.in_hand().is_some() {
            hand::check_ends(span, phase, scene)?;
            continue;
        }
        if phase.stuck_to().is_some() {
            continue;
        }
        let from = &scene.events[phase.events[0]].kind;
        let is_met = *from == EventKind::Start || from.change().is_some();
        if phase.on_surface().is_none() && !is_met {
            return fault(
                span,
                "what is tied to the world or held still is so from the start or from a change on, expected one of these",
            );
        }
    }
    Ok(())
}
