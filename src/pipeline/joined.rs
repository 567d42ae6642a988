//! The motion of bodies joined in a tree: from the events of a take to its estimate.

use super::outcome::{Outcome, PipelineError};
use crate::estimate::tree::{TreeProblem, estimate};
use crate::motion::{
    About, Doubt, DropReason, Observer, Phase, Place, Scene, TakeEvent, TrackResidual,
};
use crate::{initialise, segment};

/// Greatest root mean square residual of a track, in units of its weights.
const RESIDUAL: f64 = 3.0;

/// The outcome of a take of joined bodies; `None` of a scene of bodies by themselves.
pub(super) fn outcome(
    scene: &Scene,
    events: &[TakeEvent],
    observer: &mut dyn Observer,
) -> Result<Option<Outcome>, PipelineError> {
    let Some((mechanism, joined)) = scene.joint_trees().next() else {
        return Ok(None);
    };
    observer.phase(Phase::Clean);
    let (sketch, mut counts) = segment::clean::clean(scene, events)?;
    let problem = TreeProblem::new(scene, &sketch, (mechanism, joined));
    let span_s = problem.span_s;
    let start = initialise::tree::tree(scene, &sketch, joined, &problem.tree);
    let mut estimate = estimate(scene, &sketch, problem, start, observer);
    let samples = || sketch.tracks.iter().flat_map(|track| &track.samples);
    let before = samples()
        .filter(|sample| sample.acted_s < span_s[0])
        .count();
    let after = samples()
        .filter(|sample| sample.acted_s > span_s[1])
        .count();
    counts.used = samples().count() - before - after;
    counts.drop(DropReason::BeforeStart, before);
    counts.drop(DropReason::AfterEnd, after);
    let residuals = estimate.trees.iter().flat_map(|tree| &tree.residuals);
    let doubts = residuals.filter_map(|residual| {
        let rms = in_weights(scene, residual);
        Doubt::beyond(About::Residual, Place::Motion, rms, RESIDUAL)
    });
    let doubts = doubts.collect();
    estimate.doubt(doubts);
    let marks_made_s = sketch.marks_s.iter().copied().map(Some).collect();
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

/// The larger residual of a track in units of its weights.
fn in_weights(scene: &Scene, residual: &TrackResidual) -> f64 {
    let weights = scene.tracks[residual.track].weights(&scene.weights);
    let position = residual
        .position_rms_m
        .map(|rms_m| rms_m / weights.position_m);
    let turn = residual
        .orientation_rms_rad
        .map(|rms_rad| rms_rad / weights.orientation_rad);
    position.into_iter().chain(turn).fold(0.0, f64::max)
}
