//! Stages 2 to 4b as one pure state machine: event in, estimate out.
//!
//! A driver pushes what its source delivers, in whatever order that is, and calls
//! [`Pipeline::finish`] when the take is over. The result depends on the events alone; clocks,
//! files and threads are the driver's. The same take gives the same [`Outcome`] bit for bit.

mod infer;
mod search;

use thiserror::Error;

use self::infer::{Inferred, NoContact, infer};
pub use self::search::SearchWork;
use crate::estimate::Recipe;
use crate::initialise;
use crate::motion::{
    DropReason, Estimate, Observer, Phase, SampleCounts, Scene, Segment, Sketch, TakeEvent,
};
use crate::segment::{self, SegmentError};

/// One take of one scene on its way to an estimate.
#[derive(Clone, Debug)]
pub struct Pipeline {
    scene: Scene,
    events: Vec<TakeEvent>,
}

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
    /// What became of its samples.
    pub counts: SampleCounts,
    /// The physical motion, whatever its verdict.
    pub estimate: Estimate,
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

impl Pipeline {
    /// Begins a take of that scene.
    pub fn new(scene: Scene) -> Self {
        Self {
            scene,
            events: Vec::new(),
        }
    }

    /// The scene it was begun with.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Takes in what the source delivered; in any order.
    pub fn push(&mut self, event: TakeEvent) {
        self.events.push(event);
    }

    /// The estimate from all that was pushed. A motion that is not physical is an outcome with
    /// that verdict; an error means that there is nothing to estimate from.
    pub fn finish(&self, observer: &mut dyn Observer) -> Result<Outcome, PipelineError> {
        observer.phase(Phase::Clean);
        let scene = self.scene.with_marks(self.marks());
        let (mut sketch, mut counts) = segment::clean::clean(&scene, &self.events)?;
        let inferred = solve(&scene, &mut sketch, &mut counts, observer)?;
        observer.phase(Phase::Done);
        Ok(Outcome {
            scene: inferred.scene,
            inferred: inferred.events,
            search: inferred.search,
            sketch,
            counts,
            estimate: inferred.estimate,
        })
    }

    /// Marks that were pushed: by these repeated collisions are counted.
    fn marks(&self) -> usize {
        let is_mark = |event: &&TakeEvent| matches!(event, TakeEvent::Mark(_));
        self.events.iter().filter(is_mark).count()
    }
}

/// Stages 2 to 4 on a clean sketch, whose marks are refined on the way.
fn solve(
    scene: &Scene,
    sketch: &mut Sketch,
    counts: &mut SampleCounts,
    observer: &mut dyn Observer,
) -> Result<Inferred, PipelineError> {
    observer.phase(Phase::Marks);
    let rounds = segment::refine(scene, sketch);
    let segments = segment::cut(scene, sketch)?;
    account(sketch, &segments, counts);
    observer.phase(Phase::ArcFits);
    let guessed = initialise::guess(scene, sketch, &segments);
    let recipe = Recipe::default();
    let mut inferred = infer(
        scene,
        sketch,
        &segments,
        &guessed.guesses,
        &recipe,
        observer,
    )
    .map_err(|NoContact { event }| PipelineError::NoContact {
        event: scene.events[event].name.clone(),
    })?;
    let counters = &mut inferred.estimate.counters;
    counters.fit_iterations = guessed.fit_iterations;
    counters.assignment_rounds = rounds;
    Ok(inferred)
}

/// Counts the samples that segments use; what lies between segments is near a collision.
fn account(sketch: &Sketch, segments: &[Segment], counts: &mut SampleCounts) {
    counts.used = segments.iter().map(|segment| segment.samples.len()).sum();
    let mut near = 0;
    for body in 0..sketch.bodies.len() {
        let of_body = || segments.iter().filter(move |segment| segment.body == body);
        let first = of_body()
            .map(|segment| segment.samples.start)
            .min()
            .unwrap_or(0);
        let last = of_body()
            .map(|segment| segment.samples.end)
            .max()
            .unwrap_or(0);
        near += last
            - first
            - of_body()
                .map(|segment| segment.samples.len())
                .sum::<usize>();
    }
    counts.drop(DropReason::NearCollision, near);
}
