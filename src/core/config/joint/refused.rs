//! What scenes with joints cannot ask for.

use std::ops::Range;

use crate::config::spanned::Spanned;

use crate::config::error::{Fault, fault};
use crate::config::event::link_of;
use crate::config::raw::{RawEvent, RawScene};
use crate::motion::{LinkIndex, Quantity, Scene, Timing, TreeTouch};
use crate::physics::impact::ImpactError;
use crate::physics::tree::ForestSnapshot;

/// Refuses a scene with joints that asks for what is not done there.
pub(super) fn refuse(raw: &RawScene, scene: &Scene) -> Result<(), Fault> {
    if scene.timing == Timing::Edited {
        return fault(
            raw.timing.stamps.span(),
            "joined bodies move from start to end at once, expected stamps = \"physical\" or \"tempo\"",
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
    match scene.links.keys().find(|link| scene.is_held(*link)) {
        Some(hand) => refuse_beside(raw, scene, hand),
        None => Ok(()),
    }
}

/// Refuses what is not done of joined bodies beside a held one: its motion, and theirs with it, is told by stamps.
fn refuse_beside(raw: &RawScene, scene: &Scene, hand: LinkIndex) -> Result<(), Fault> {
    let name = &scene.links[hand].name;
    if matches!(scene.timing, Timing::Unknown { .. }) {
        let said = format!(
            "{name:?} is held in a scene with joints, where the tempo must be known: expected stamps = \"physical\""
        );
        return fault(raw.timing.stamps.span(), said);
    }
    for event in &raw.event {
        let kind = &event.get_ref().kind;
        if kind.get_ref() == "collision" {
            let said = format!(
                "{name:?} is held in a scene with joints, where nothing is hit: expected no collision"
            );
            return fault(kind.span(), said);
        }
    }
    for goal in &raw.goal {
        let Some(other) = &goal.get_ref().relative_to else {
            continue;
        };
        if scene.is_held(link_of(other, scene)?) {
            let said = "goals of joined bodies are not relative to a held one, expected another body or angles_deg";
            return fault(other.span(), said);
        }
    }
    Ok(())
}

/// Refuses free quantities of a scene with joints that are not of the law of an impact.
pub(in crate::config) fn refuse_free(raw: &RawScene, scene: &Scene) -> Result<(), Fault> {
    if scene.joint_trees().next().is_none() {
        return Ok(());
    }
    let of_law = |quantity| {
        matches!(
            quantity,
            Quantity::Restitution { .. } | Quantity::Friction { .. } | Quantity::Tilt { .. }
        )
    };
    let Some(other) = scene.parameters.iter().find(|of| !of_law(of.quantity)) else {
        return Ok(());
    };
    let mut named = raw.free.iter().map(|free| &free.quantity);
    let place = named.find(|name| other.name.starts_with(name.get_ref().as_str()));
    let said = format!(
        "of a scene with joints restitution, friction and tilts of its collisions may be free, expected one of them instead of {:?}",
        other.name
    );
    fault(place.map_or(0..0, Spanned::span), said)
}

/// Collisions in a scene with joints are listed one by one.
fn refuse_event(spanned: &Spanned<RawEvent>) -> Result<(), Fault> {
    let event = spanned.get_ref();
    if event.kind.get_ref() != "collision" {
        return Ok(());
    }
    match &event.count {
        Some(count) => fault(
            count.span(),
            "collisions in a scene with joints are listed one by one, expected no count",
        ),
        None => Ok(()),
    }
}

/// Refuses collisions of two bodies that a joint ties to each other: whether they overlap beside it is not looked at.
pub(super) fn refuse_neighbours(raw: &RawScene, scene: &Scene) -> Result<(), Fault> {
    for spanned in &raw.event {
        let event = spanned.get_ref();
        let (Some(body), Some(other)) = (&event.body, &event.other) else {
            continue;
        };
        let [one, other] = [link_of(body, scene)?, link_of(other, scene)?];
        if scene.are_joined(one, other) {
            let said = format!(
                "a joint ties {:?} to {:?}, expected bodies that no joint ties to each other",
                scene.links[one].name, scene.links[other].name
            );
            return fault(spanned.span(), said);
        }
    }
    Ok(())
}

/// Refuses several contacts at once of which the joints let one follow from the others, whatever the pose: their impulses
/// would not be determined.
pub(in crate::config) fn refuse_dependent(raw: &RawScene, scene: &Scene) -> Result<(), Fault> {
    if scene.joint_trees().next().is_none() {
        return Ok(());
    }
    for (event, spanned) in raw.event.iter().enumerate() {
        let several = spanned.get_ref().features.as_ref();
        let several = several.filter(|features| features.get_ref().len() > 1);
        if let Some((several, touch)) = several.zip(scene.tree_touch(event))
            && depends(scene, &touch)
        {
            let said = "by the joints these features always touch together: expected one of them";
            return fault(several.span(), said);
        }
    }
    Ok(())
}

/// Whether contacts depend on each other in some poses that have nothing in common.
fn depends(scene: &Scene, touch: &TreeTouch) -> bool {
    let forest = scene.forest();
    let mut snapshot = ForestSnapshot::new(&forest, &scene.gravity_m_s2);
    let poses = [0.4, 0.7, 1.1].map(|step: f64| {
        let delta = (0..2 * forest.freedoms()).map(|at| (1.0 + step * at as f64).sin());
        forest.retract(&forest.at_rest(), &delta.collect::<Vec<f64>>())
    });
    poses.iter().all(|pose| {
        snapshot.set(pose);
        let impact = snapshot.impact(pose, &touch.at, &touch.law);
        matches!(impact, Err(ImpactError::Dependent { .. }))
    })
}

/// Keys that a motion with joints does not heed, and what is expected instead.
fn unused(raw: &RawScene) -> impl Iterator<Item = (Option<Range<usize>>, &'static str)> {
    fn span<T>(of: &Option<Spanned<T>>) -> Option<Range<usize>> {
        of.as_ref().map(Spanned::span)
    }
    let of_bodies = raw.body.iter().flat_map(|body| {
        let body = body.get_ref();
        let said =
            "bodies of a scene with joints fly in gravity alone, expected neither force nor drag";
        [
            (span(&body.force_m_s2), said),
            (span(&body.drag_linear_per_s), said),
            (span(&body.drag_quadratic_per_m), said),
        ]
    });
    let tracks = raw.body.iter().flat_map(|body| &body.get_ref().track);
    let of_tracks = tracks.map(|track| {
        let said = "samples in a scene with joints weigh what that says, expected no weights";
        (span(&track.get_ref().weights), said)
    });
    let of_events = raw.event.iter().flat_map(|event| {
        let event = event.get_ref();
        let said = "times of events in a scene with joints are told by their marks alone, expected no other time of the event";
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
        let said = "a motion with joints begins and ends at the marks, expected no goal of a time";
        [
            (span(&goal.time_ms), said),
            (span(&goal.time_within_ms), said),
            (
                goal.contact.as_ref().filter(|of| *of.get_ref()).map(Spanned::span),
                "where bodies touch is no point for goals in a scene with joints, expected point_mm or feature",
            ),
        ]
    });
    of_bodies
        .chain(of_tracks)
        .chain(of_events)
        .chain(of_goals)
        .chain(at_rest)
}
