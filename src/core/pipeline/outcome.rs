//! The result of a take, or the reason why there is none.

use nalgebra::UnitQuaternion;
use thiserror::Error;

use super::infer::Inferred;
use super::search::SearchWork;
use super::spread::spread;
use crate::estimate::{Deviations, LastState};
use crate::motion::{
    About, Diagnosis, Doubt, Estimate, Observer, Phase, Place, Rest, RestWork, SampleCounts, Scene,
    SeenPhase, Settled, Sketch, Suspect, Verdict, Verification,
};
use crate::segment::SegmentError;
use crate::settle::settle_until;
use crate::verify::{lies, overlaps_begin_s};

/// The result of a take.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The scene as estimated: repeated collisions written out, contacts filled in, and what was
    /// free with its estimated value ([`Scene::as_estimated`]).
    pub scene: Scene,
    /// The same with what was free as the scene has it: what was estimated.
    pub given: Scene,
    /// What was set free because it explains a misfit, in order; names and values are of `given`.
    pub freed: Vec<Suspect>,
    /// Collisions whose contacts were inferred (indices into `scene.events`).
    pub inferred: Vec<usize>,
    /// Work of the search for them, if there was one.
    pub search: Option<SearchWork>,
    /// The performance as used by the estimation, seen from trackers mounted as estimated.
    pub sketch: Sketch,
    /// Acted time of each event's mark before it was refined [s since the sketch's origin]; `None`
    /// for an event without a mark.
    pub marks_made_s: Vec<Option<f64>>,
    /// Counts of its samples.
    pub counts: SampleCounts,
    /// The physical motion, whatever its verdict.
    pub estimate: Estimate,
    /// Result of the independent checks; `None` where there were none: the estimation failed,
    /// or checks were not wanted.
    pub verification: Option<Verification>,
    /// Its continuation until it rests, if the scene asks for that and the estimation did not fail.
    pub settled: Option<Settled>,
    /// Likely mistakes in what is said of the performance, where something speaks against the motion
    /// and a remedy explains it; that which explains most first.
    pub diagnoses: Vec<Diagnosis>,
    /// What bodies are seen to do that do not fly, of which the scene has no phase, where something speaks against the motion.
    pub seen: Vec<SeenPhase>,
    /// How it rests, if the scene has goals at rest and there is a continuation.
    pub rest: Option<Rest>,
}

/// Why a take has no estimate at all.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PipelineError {
    /// The take gives no sketch of the scene.
    #[error(transparent)]
    Segment(#[from] SegmentError),
    /// A collision leaves its contacts open, and there is no candidate.
    #[error(
        "nothing can touch at `{event}`: expected a feature and a surface, or shapes that meet there"
    )]
    NoContact {
        /// Name of the event.
        event: String,
    },
}

impl Outcome {
    /// An outcome without checks. `marks_made_s` are the times of the marks as they were made.
    pub(super) fn unchecked(
        inferred: Inferred,
        marks_made_s: Vec<Option<f64>>,
        sketch: Sketch,
        counts: SampleCounts,
        which: Deviations,
        observer: &mut dyn Observer,
    ) -> Self {
        let given = inferred.scene;
        let mut estimate = inferred.solved.with_deviations(&given, which, observer);
        estimate.is_rivalled_by(inferred.rivals);
        let scene = given.as_estimated(&estimate);
        Self {
            estimate,
            marks_made_s,
            sketch: sketch.seen_in(&given, &scene),
            scene,
            given,
            freed: Vec::new(),
            inferred: inferred.events,
            search: inferred.search,
            counts,
            verification: None,
            settled: None,
            diagnoses: Vec::new(),
            seen: Vec::new(),
            rest: None,
        }
    }

    /// Continues the motion until it rests, if the scene asks for that and the estimation did not
    /// fail.
    pub(super) fn settle(&mut self, is_predicted: bool, observer: &mut dyn Observer) {
        if self.estimate.verdict != Verdict::Failed
            && let Some(limit_s) = self.scene.settle_s
        {
            observer.phase(Phase::Settle);
            let scene = self.scene.as_estimated(&self.estimate);
            self.settled = settle_until(&scene, &self.estimate, limit_s, observer);
            if let Some(settled) = &mut self.settled {
                settled.is_predicted = is_predicted;
            }
        }
    }

    /// Ends the motion where it begins to go into something. A prediction is of a flight that ends with a mark, which is
    /// no time of a touch: what was seen until then may go on past it.
    pub(super) fn end_where_it_touches(&mut self) {
        // Of a failed estimate not even times need be finite.
        if self.estimate.verdict != Verdict::Failed
            && let Some(end_s) = overlaps_begin_s(&self.scene, &self.estimate).first()
        {
            self.estimate.end_at(*end_s);
        }
    }

    /// Tells how far a prediction may be off, where the last states of what flies are known.
    pub(super) fn spread(&mut self, known: Option<&[LastState]>, observer: &mut dyn Observer) {
        let Some(settled) = self.settled.as_mut().filter(|of| of.is_predicted) else {
            return;
        };
        let scene = self.scene.as_estimated(&self.estimate);
        if let (Some(known), Some(limit_s)) = (known, scene.settle_s) {
            settled.spread = spread(&scene, &self.estimate, known, limit_s, observer);
        }
    }

    /// Looks how the continuation rests; a goal that is not met is a doubt.
    pub(super) fn lie(&mut self, work: RestWork, labels: Vec<Option<UnitQuaternion<f64>>>) {
        let Some(settled) = &self.settled else { return };
        let goals = lies(&self.scene, settled);
        let missed = goals.iter().enumerate().filter(|(_, lie)| !lie.is_met());
        let missed = missed.map(|(goal, lie)| Doubt {
            about: About::Rest,
            place: Place::Rest {
                goal,
                shown: lie.is_still.then(|| lie.shown.clone()),
                tried: work.motions,
            },
            value: lie.angle_rad,
            bound: self.scene.rest_goals[goal].within_rad,
        });
        let doubts = self.estimate.doubts.iter().cloned();
        self.estimate.doubt(doubts.chain(missed).collect());
        self.rest = Some(Rest {
            goals,
            work,
            labels,
        });
    }
}
