//! What a take becomes, or why it becomes nothing.

use thiserror::Error;

use super::infer::Inferred;
use super::search::SearchWork;
use crate::motion::{Estimate, Observer, SampleCounts, Scene, Settled, Sketch, Verification};
use crate::segment::SegmentError;

/// What a take became.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The scene as it was understood: repeated collisions written out, contacts filled in.
    pub scene: Scene,
    /// Collisions whose contacts were inferred (indices into `scene.events`).
    pub inferred: Vec<usize>,
    /// The search for them, if there was one.
    pub search: Option<SearchWork>,
    /// The performance as it was estimated from.
    pub sketch: Sketch,
    /// Acted time of each event's mark before it was refined [s since the sketch's origin]; `None`
    /// where nobody made one.
    pub marks_made_s: Vec<Option<f64>>,
    /// What became of its samples.
    pub counts: SampleCounts,
    /// The physical motion, whatever its verdict.
    pub estimate: Estimate,
    /// What independent checks say of it; `None` where there were none: the estimation failed,
    /// or nobody asked.
    pub verification: Option<Verification>,
    /// How it goes on until it rests, if the scene asks for that and the estimation did not fail.
    pub settled: Option<Settled>,
}

/// Why a take has no estimate at all.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PipelineError {
    /// It makes no sketch of the scene.
    #[error(transparent)]
    Segment(#[from] SegmentError),
    /// A collision that leaves open what touches, where nothing may.
    #[error(
        "nothing can touch at `{event}`: expected a feature and a surface, or shapes that meet there"
    )]
    NoContact {
        /// Its name.
        event: String,
    },
}

impl Outcome {
    /// Before any check. `marks_made_s` are those of the marks as they were made.
    pub(super) fn unchecked(
        inferred: Inferred,
        marks_made_s: Vec<Option<f64>>,
        (sketch, counts): (Sketch, SampleCounts),
        observer: &mut dyn Observer,
    ) -> Self {
        let scene = inferred.scene;
        Self {
            estimate: inferred.solved.with_deviations(&scene, observer),
            marks_made_s,
            scene,
            inferred: inferred.events,
            search: inferred.search,
            sketch,
            counts,
            verification: None,
            settled: None,
        }
    }
}
