//! The motion of a scene with joined bodies: from the events of a take to its estimate.

mod infer;
mod out;
mod rivals;
mod tried;

use self::tried::{Tried, TriedField};
use super::infer::NoContact;
use super::outcome::{Outcome, PipelineError};
use super::perform::marks;
use super::search::SearchWork;
use crate::estimate::tree::Solved;
use crate::motion::{
    DropReason, Estimate, Observer, Phase, SampleCounts, Scene, Sketch, TakeEvent,
};
use crate::segment;

/// The outcome of a take, led out of what it goes into where that may be; `None` of a scene in which no bodies are joined.
pub(super) fn outcome(
    scene: &Scene,
    events: &[TakeEvent],
    may_keep_out: bool,
    observer: &mut dyn Observer,
) -> Result<Option<Outcome>, PipelineError> {
    if scene.joint_trees().next().is_none() {
        return Ok(None);
    }
    let found = found(scene, events, observer)?;
    let mut tried = found.tried;
    if may_keep_out {
        let field = TriedField {
            scene,
            sketch: &found.sketch,
            marks_made_s: &found.marks_made_s,
        };
        tried = field.kept_out(tried, observer);
    }
    Ok(Some(Outcome {
        scene: tried.scene.as_estimated(&tried.estimate),
        given: tried.scene,
        freed: Vec::new(),
        inferred: found.inferred,
        search: found.search,
        sketch: found.sketch,
        marks_made_s: found.marks_made_s,
        counts: found.counts,
        estimate: tried.estimate,
        verification: tried.verification,
        settled: None,
        diagnoses: Vec::new(),
        seen: Vec::new(),
        rest: None,
    }))
}

/// A motion of joined bodies, and what it is of.
pub(super) struct JoinedMotion {
    tried: Tried,
    sketch: Sketch,
    counts: SampleCounts,
    /// See [`Outcome::marks_made_s`].
    marks_made_s: Vec<Option<f64>>,
    /// Events whose contacts the scene leaves open.
    inferred: Vec<usize>,
    search: Option<SearchWork>,
}

impl JoinedMotion {
    pub(super) fn solved(&self) -> &Solved {
        &self.tried.solved
    }

    pub(super) fn estimate(&self) -> &Estimate {
        &self.tried.estimate
    }
}

/// The motion of a scene with joined bodies.
pub(super) fn found(
    scene: &Scene,
    events: &[TakeEvent],
    observer: &mut dyn Observer,
) -> Result<JoinedMotion, PipelineError> {
    observer.phase(Phase::Clean);
    let scene = &scene.with_marks(marks(events));
    let (mut sketch, mut counts) = segment::clean::clean(scene, events)?;
    segment::hold(scene, &mut sketch)?;
    let marks_made_s: Vec<Option<f64>> = sketch.marks_s.iter().copied().map(Some).collect();
    let field = TriedField {
        scene,
        sketch: &sketch,
        marks_made_s: &marks_made_s,
    };
    let (inferred, tried, search) = if scene.open_events().is_empty() {
        let tried = field.performed(scene.clone(), observer);
        (Vec::new(), tried, None)
    } else {
        let ranked = infer::rank(scene, &sketch, observer);
        let ranked = ranked.map_err(|NoContact { event }| PipelineError::NoContact {
            event: scene.events[event].name.clone(),
        })?;
        let (tried, work) = infer::infer(&ranked, &field, observer);
        (ranked.events(), tried, Some(work))
    };
    account(scene, &sketch, &mut counts);
    Ok(JoinedMotion {
        tried,
        sketch,
        counts,
        marks_made_s,
        inferred,
        search,
    })
}

/// Counts the samples within the motion, and all of what is held; none of what is apart.
fn account(scene: &Scene, sketch: &Sketch, counts: &mut SampleCounts) {
    let [first_s, last_s] = sketch.whole_span_s(scene);
    counts.used = 0;
    for (track, of) in sketch.tracks.iter_enumerated() {
        if scene.sees_held(track) {
            counts.used += of.samples.len();
        } else if scene.sees_moving(track) {
            let begun = of
                .samples
                .partition_point(|sample| sample.acted_s < first_s);
            let ended = of
                .samples
                .partition_point(|sample| sample.acted_s <= last_s);
            counts.used += ended - begun;
            counts.drop(DropReason::BeforeStart, begun);
            counts.drop(DropReason::AfterEnd, of.samples.len() - ended);
        }
    }
}
