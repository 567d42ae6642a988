//! What phases add to the problem: changes between them, and what holds where one begins with the performance.

use super::{friction, gravity};
use crate::estimate::problem::influence::Acting;
use crate::estimate::problem::{Arc, ArcChange, ArcPair, ArcSupport, FlatFace};
use crate::motion::{EventKind, Scene};
use crate::physics::Sustained;
use crate::physics::contact::Feature;

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
        let sustained = |arc: usize| Some(arcs[arc].body.support()?.sustained);
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
            acting,
        })
    });
    changes.collect()
}

/// What holds on arcs that begin on a support with the performance.
pub(super) fn supports(scene: &Scene, arcs: &[Arc]) -> Vec<ArcSupport> {
    let begun = arcs.iter().enumerate().filter_map(|(index, arc)| {
        let phase = scene.phase_between(arc.mechanism, [arc.start, arc.end])?;
        let from = phase.events[0];
        let begins = scene.events[from].kind == EventKind::Start && arc.start == Some(from);
        begins.then_some((index, phase))
    });
    let supports = begun.map(|(arc, phase)| {
        let Feature::Face { point_m, .. } = scene.surfaces[phase.surface].geometry else {
            panic!("a phase on a plane");
        };
        let own = scene.links[phase.link].features[phase.feature].geometry;
        ArcSupport {
            arc,
            point_m,
            face: match own {
                Feature::Face { point_m, normal } => Some(FlatFace { point_m, normal }),
                _ => None,
            },
        }
    });
    supports.collect()
}
