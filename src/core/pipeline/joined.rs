//! The motion of a scene with joined bodies: from the events of a take to its estimate.

mod infer;
mod rivals;
mod tried;

use self::tried::TriedField;
use super::infer::NoContact;
use super::outcome::{Outcome, PipelineError};
use crate::motion::{DropReason, Observer, Phase, Scene, TakeEvent};
use crate::segment;

/// The outcome of a take; `None` of a scene in which no bodies are joined.
pub(super) fn outcome(
    scene: &Scene,
    events: &[TakeEvent],
    observer: &mut dyn Observer,
) -> Result<Option<Outcome>, PipelineError> {
    if scene.joint_trees().next().is_none() {
        return Ok(None);
    }
    observer.phase(Phase::Clean);
    let (mut sketch, mut counts) = segment::clean::clean(scene, events)?;
    segment::hold(scene, &mut sketch)?;
    let span_s = sketch.whole_span_s(scene);
    let marks_made_s: Vec<Option<f64>> = sketch.marks_s.iter().copied().map(Some).collect();
    let field = TriedField {
        scene,
        sketch: &sketch,
        marks_made_s: &marks_made_s,
    };
    let (inferred, tried, search) = if scene.open_events().is_empty() {
        let tried = field.named(scene.clone(), observer);
        (Vec::new(), tried, None)
    } else {
        let ranked = infer::rank(scene, &sketch, observer);
        let ranked = ranked.map_err(|NoContact { event }| PipelineError::NoContact {
            event: scene.events[event].name.clone(),
        })?;
        let (tried, work) = infer::infer(&ranked, &field, observer);
        (ranked.events(), tried, Some(work))
    };
    // Of what is held all samples tell its motion.
    let flying = || sketch.tracks.iter().filter(|track| track.held.is_none());
    let samples = || flying().flat_map(|track| &track.samples);
    let held = sketch.tracks.iter().filter(|track| track.held.is_some());
    let held: usize = held.map(|track| track.samples.len()).sum();
    let before = samples()
        .filter(|sample| sample.acted_s < span_s[0])
        .count();
    let after = samples()
        .filter(|sample| sample.acted_s > span_s[1])
        .count();
    counts.used = held + samples().count() - before - after;
    counts.drop(DropReason::BeforeStart, before);
    counts.drop(DropReason::AfterEnd, after);
    Ok(Some(Outcome {
        scene: tried.scene.clone(),
        given: tried.scene,
        freed: Vec::new(),
        inferred,
        search,
        sketch,
        marks_made_s,
        counts,
        estimate: tried.estimate,
        verification: None,
        settled: None,
        diagnoses: Vec::new(),
        rest: None,
    }))
}
