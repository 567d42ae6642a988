//! Which of the phases that are seen the scene has.

use crate::motion::{Scene, SeenMotion, SeenPhase, Stamp, SupportPhase, SupportedBy};

/// For each phase that is seen, the one of the scene that says it (index into `Scene::phases`). `marks` are those of the events,
/// where they are known: a phase with both its marks is what is seen between them, whatever it says; the others are matched in
/// order.
pub fn said(scene: &Scene, seen: &[SeenPhase], marks: &[Option<Stamp>]) -> Vec<Option<usize>> {
    let mut found = vec![None; seen.len()];
    let span = |phase: &SupportPhase| {
        let [from, until] = phase
            .events
            .map(|event| marks.get(event).copied().flatten());
        Some([from?, until?])
    };
    for (at, of) in seen.iter().enumerate() {
        let covers = |phase: &SupportPhase| {
            let marked = span(phase).filter(|_| phase.link == of.link);
            marked.is_some_and(|[from, until]| {
                let both_ns = of.until.min(until).0 - of.from.max(from).0;
                2 * both_ns > of.until.0 - of.from.0
            })
        };
        found[at] = scene.phases.iter().position(covers);
    }
    for (index, phase) in scene.phases.iter().enumerate() {
        if span(phase).is_some() {
            continue;
        }
        let is_next = |at: &usize| {
            found[*at].is_none() && seen[*at].link == phase.link && is_alike(phase, &seen[*at])
        };
        if let Some(at) = (0..seen.len()).find(is_next) {
            found[at] = Some(index);
        }
    }
    found
}

/// Whether a phase says of a body what is seen.
fn is_alike(phase: &SupportPhase, seen: &SeenPhase) -> bool {
    match (&phase.by, seen.motion) {
        (SupportedBy::Surface(on), SeenMotion::On(there)) => {
            (on.sustained, on.surface) == (there.sustained, there.surface)
        }
        (SupportedBy::Pivot(at), SeenMotion::Still) => at.place_m.is_none(),
        (SupportedBy::Hand(hand), SeenMotion::InHand | SeenMotion::With(_)) => !hand.tumbles,
        (SupportedBy::Hand(hand), SeenMotion::Tumble) => hand.tumbles,
        _ => false,
    }
}
