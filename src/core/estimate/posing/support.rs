//! What phases add to the problem: changes between them, and what holds where one begins with the performance.

use super::{friction, gravity};
use crate::estimate::problem::influence::Acting;
use crate::estimate::problem::{Arc, ArcChange, ArcPair, ArcSupport, SupportPlace};
use crate::motion::{EventKind, Scene, SupportedBy};
use crate::physics::contact::Feature;
use crate::physics::support::Caught;
use crate::physics::{Body, Support, Sustained};

/// The changes of phases. `arcs` have the parameters of their friction.
pub(super) fn changes(
    scene: &Scene,
    arcs: &[Arc],
    gravity_parameters: &[Option<usize>; 3],
) -> Vec<ArcChange> {
    let events = scene.events.iter().enumerate();
    let changes = events.filter_map(|(event, of)| Some((event, of.kind.change()?)));
    let changes = changes.filter_map(|(event, link)| {
        let mechanism = scene.mechanism_of(link);
        let arc_with = |is: &dyn Fn(&Arc) -> bool| {
            let mut own = arcs.iter();
            own.position(|arc| arc.mechanism == mechanism && is(arc))
        };
        let before = arc_with(&|arc| arc.end == Some(event))?;
        let after = arc_with(&|arc| arc.start == Some(event))?;
        let sustained = |arc: usize| match arcs[arc].body.support()? {
            Support::Plane(plane) => Some(plane.sustained),
            Support::Pivot(_) => None,
        };
        let slip_ends = match (sustained(before), sustained(after)) {
            (Some(Sustained::Slide), Some(after)) => after != Sustained::Slide,
            (Some(Sustained::Roll), Some(after)) => after == Sustained::Rest,
            _ => false,
        };
        let mut parameters: Vec<usize> = [before, after]
            .into_iter()
            .filter_map(|arc| arcs[arc].friction_parameter)
            .collect();
        parameters.dedup();
        let frictions = parameters.into_iter().map(friction);
        let acting: Vec<Acting> = frictions.chain(gravity(gravity_parameters)).collect();
        Some(ArcChange {
            event,
            sides: ArcPair {
                mechanism,
                before,
                after,
            },
            slip_ends,
            caught: caught(&arcs[after].body),
            acting,
        })
    });
    changes.collect()
}

/// What catches a body that turns about a pivot from then on.
fn caught(body: &Body) -> Option<Caught> {
    match body.support()? {
        Support::Plane(_) => None,
        Support::Pivot(pivot) => Some(pivot.catch(&body.gyration_m2())),
    }
}

/// What holds on arcs that begin on a support with the performance, or at a pivot.
pub(super) fn supports(scene: &Scene, arcs: &[Arc]) -> Vec<ArcSupport> {
    let begun = arcs.iter().enumerate().filter_map(|(index, arc)| {
        let phase = scene.phase_between(arc.mechanism, [arc.start, arc.end])?;
        let from = phase.events[0];
        let is_start = scene.events[from].kind == EventKind::Start;
        let begins = arc.start == Some(from) && (is_start || phase.on_surface().is_none());
        begins.then_some((index, phase, !is_start))
    });
    let supports = begun.map(|(arc, phase, is_caught)| {
        let on = match &phase.by {
            SupportedBy::Surface(on) => on,
            SupportedBy::Pivot(at) => {
                return ArcSupport {
                    arc,
                    is_caught,
                    at: SupportPlace::Pivot {
                        place_m: at.place_m,
                        axis: at.axis,
                    },
                };
            }
        };
        let Feature::Face { point_m, .. } = scene.surfaces[on.surface].geometry else {
            panic!("a phase on a plane");
        };
        ArcSupport {
            arc,
            is_caught,
            at: SupportPlace::Plane { point_m },
        }
    });
    supports.collect()
}
