//! The motion of a scene with joined bodies: from the events of a take to its estimate.

use super::outcome::{Outcome, PipelineError};
use crate::estimate::tree::{TreeProblem, estimate};
use crate::motion::{DropReason, Observer, Phase, Scene, TakeEvent};
use crate::{initialise, segment, verify};

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
    let problem = TreeProblem::new(scene, &sketch);
    let span_s = problem.span_s;
    let starts = initialise::tree::starts(scene, &sketch, &problem.forest);
    let mut estimate = estimate(scene, &sketch, &problem, &starts, observer);
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
    let marks_made_s: Vec<Option<f64>> = sketch.marks_s.iter().copied().map(Some).collect();
    let doubts = verify::joined::doubts(scene, (&sketch, &marks_made_s), &estimate);
    estimate.doubt(doubts);
    Ok(Some(Outcome {
        scene: scene.clone(),
        given: scene.clone(),
        freed: Vec::new(),
        inferred: Vec::new(),
        search: None,
        sketch,
        marks_made_s,
        counts,
        estimate,
        verification: None,
        settled: None,
        diagnoses: Vec::new(),
        rest: None,
    }))
}
