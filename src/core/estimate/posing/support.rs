//! What phases add to the problem: changes between them, and what holds where one begins with the performance.

use super::gravity;
use crate::estimate::problem::influence::Acting;
use crate::estimate::problem::{
    Arc, ArcChange, ArcPair, ArcSticking, ArcSupport, MovedBy, SupportPlace,
};
use crate::motion::{EventKind, LinkIndex, Scene, Sketch, SupportPhase, SupportedBy};
use crate::physics::contact::Feature;
use crate::physics::support::Caught;
use crate::physics::{Body, Support, Sustained};

/// The changes of phases. `arcs` have the parameters of their friction, `hold` adds what is in a hand at an event.
pub(super) fn changes(
    scene: &Scene,
    arcs: &[Arc],
    gravity_parameters: &[Option<usize>; 3],
    mut hold: impl FnMut(usize, usize) -> Option<usize>,
) -> Vec<ArcChange> {
    let events = scene.events.iter().enumerate();
    let changes = events.filter(|(_, of)| of.kind.change().is_some());
    let changes = changes.flat_map(|(event, _)| {
        let links = scene.links_at(event).into_iter();
        links.map(move |link| (event, link))
    });
    let changes = changes.filter_map(|(event, link)| {
        let mechanism = scene.mechanism_of(link);
        let mut side = |is_after: bool| {
            if let Some(phase) = scene.grip_beside(mechanism, event, is_after) {
                return hold(phase, event).map(MovedBy::Hand);
            }
            let mut own = arcs.iter();
            let is_beside = |arc: &Arc| match is_after {
                true => arc.start == Some(event),
                false => arc.end == Some(event),
            };
            let arc = own.position(|arc| arc.mechanism == mechanism && is_beside(arc));
            arc.map(MovedBy::Arc)
        };
        let sides = [side(false)?, side(true)?];
        let arc = |side: MovedBy| match side {
            MovedBy::Arc(arc) => Some(arc),
            MovedBy::Hand(_) => None,
        };
        let [before, after] = sides.map(arc);
        let sustained = |arc: Option<usize>| match arcs[arc?].body.support()? {
            Support::Plane(plane) => Some(plane.sustained),
            Support::Pivot(_) | Support::Stuck(_) => None,
        };
        let slip_ends = match (sustained(before), sustained(after)) {
            (Some(Sustained::Slide), Some(after)) => after != Sustained::Slide,
            (Some(Sustained::Roll), Some(after)) => after == Sustained::Rest,
            _ => false,
        };
        // What two bodies that stick together keep of velocities they keep together.
        let is_stuck = scene.sticks(event, mechanism);
        // A hand ends velocities where it puts something down, or takes what moves, and contacts at the end of a tumble; what lay
        // begins to move so slowly that they tell no more than places when.
        let tumbled = scene.phase_beside(mechanism, event, false);
        let is_stopped = match (before, after) {
            (None, _) if tumbled.is_some_and(SupportPhase::tumbles) => true,
            (None, _) => sustained(after) == Some(Sustained::Rest),
            (_, None) => true,
            _ => false,
        };
        let own = [before, after].into_iter().flatten();
        let own = own.flat_map(|arc| arcs[arc].acting.iter().copied());
        let own = own.filter(|acting| acting.influence.is_of_motion());
        let mut acting: Vec<Acting> = own.chain(gravity(gravity_parameters)).collect();
        acting.sort_by_key(|acting| acting.parameter);
        acting.dedup_by_key(|acting| acting.parameter);
        Some(ArcChange {
            event,
            sides,
            keeps_velocities: !is_stopped && !is_stuck,
            slip_ends,
            caught: after.and_then(|after| caught(&arcs[after].body)),
            acting,
        })
    });
    changes.collect()
}

/// What catches a body that turns about a pivot from then on.
fn caught(body: &Body) -> Option<Caught> {
    match body.support()? {
        Support::Plane(_) | Support::Stuck(_) => None,
        Support::Pivot(pivot) => Some(pivot.catch(&body.gyration_m2())),
    }
}

/// Where bodies stick together.
pub(super) fn stickings(
    scene: &Scene,
    arcs: &[Arc],
    gravity_parameters: &[Option<usize>; 3],
) -> Vec<ArcSticking> {
    let pairs = scene.stuck_pairs().filter_map(|pair| {
        let side = |link: LinkIndex| {
            let mechanism = scene.mechanism_of(link);
            let mut own = arcs.iter().enumerate();
            let mut own = || {
                own.find(|(_, arc)| {
                    let is_beside = [arc.start, arc.end].contains(&Some(pair.event));
                    arc.mechanism == mechanism && is_beside
                })
            };
            // Arcs are in order of time.
            let (before, after) = (own()?.0, own()?.0);
            Some(ArcPair {
                mechanism,
                before,
                after,
            })
        };
        let [first, second] = pair.links.map(side);
        let sides = [first?, second?];
        let moments = |side: &ArcPair| arcs[side.before].body.moments_kg_m2().mean();
        let whole = match arcs[sides[0].after].body.support() {
            Some(Support::Stuck(part)) => part.moments_kg_m2.mean(),
            _ => sides.iter().map(moments).sum(),
        };
        Some(ArcSticking {
            event: pair.event,
            sides,
            per_kg_m2: whole,
            acting: gravity(gravity_parameters).collect(),
        })
    });
    pairs.collect()
}

/// The ends of what a hand does.
pub(super) fn grips(scene: &Scene, sketch: &Sketch) -> Vec<[usize; 2]> {
    let phases = scene.phases.iter().enumerate();
    let gripped = phases.filter(|(index, _)| sketch.grip(*index).is_some());
    gripped.map(|(_, phase)| phase.events).collect()
}

/// What holds on arcs that begin on a support with the performance, or at a pivot.
pub(super) fn supports(scene: &Scene, arcs: &[Arc]) -> Vec<ArcSupport> {
    let begun = arcs.iter().enumerate().filter_map(|(index, arc)| {
        let phase = scene.phase_between(arc.mechanism, [arc.start, arc.end])?;
        let from = phase.events[0];
        let is_start = scene.events[from].kind == EventKind::Start;
        // What is put down is there at once, as at a start.
        let is_put = scene.hand_beside(arc.mechanism, from, false);
        let is_told = is_start || is_put || phase.on_surface().is_none();
        let begins = arc.start == Some(from) && is_told;
        begins.then_some((index, phase, !is_start && !is_put))
    });
    let supports = begun.filter_map(|(arc, phase, is_caught)| {
        let at = match &phase.by {
            SupportedBy::Surface(on) => match scene.surfaces[on.surface].geometry {
                Feature::Face { point_m, .. } => SupportPlace::Plane { point_m },
                _ => panic!("a phase on a plane"),
            },
            SupportedBy::Pivot(at) => SupportPlace::Pivot {
                place_m: at.place_m,
                axis: at.axis,
            },
            SupportedBy::Hand(_) | SupportedBy::Body(_) => return None,
        };
        Some(ArcSupport { arc, is_caught, at })
    });
    supports.collect()
}
