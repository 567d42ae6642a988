//! Stages 2 to 4c as one pure state machine: event in, checked estimate out.
//!
//! A driver pushes what its source delivers, in whatever order that is, and calls
//! [`Pipeline::finish`] when the take is over, or [`Pipeline::estimate`] if it wants no checks. The result depends on the events alone; clocks,
//! files and threads are the driver's. The same take gives the same [`Outcome`] bit for bit.

mod follow;
mod infer;
mod preview;
mod search;
mod warm;

use thiserror::Error;

use self::follow::follow;
use self::infer::{Inferred, NoContact, infer};
pub use self::preview::{Preview, Previewed};
pub use self::search::SearchWork;
use crate::estimate::Recipe;
use crate::initialise;
use crate::motion::{
    DropReason, Estimate, EventKind, Observer, Phase, SampleCounts, Scene, Segment, Settled,
    Sketch, Stamp, TakeEvent, Verdict, Verification,
};
use crate::segment::{self, SegmentError};
use crate::settle::settle;
use crate::verify::verify;

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
    fn unchecked(inferred: Inferred, sketch: Sketch, counts: SampleCounts) -> Self {
        Self {
            scene: inferred.scene,
            inferred: inferred.events,
            search: inferred.search,
            sketch,
            counts,
            estimate: inferred.estimate,
            verification: None,
            settled: None,
        }
    }
}

impl Pipeline {
    /// Begins a take of that scene.
    pub fn new(scene: Scene) -> Self {
        Self {
            scene,
            events: Vec::new(),
        }
    }

    /// A take of that scene that is over.
    pub fn of(scene: Scene, events: impl IntoIterator<Item = TakeEvent>) -> Self {
        Self {
            scene,
            events: events.into_iter().collect(),
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

    /// Marks for what was pushed, in order of time, whatever marks are in it: of every collision
    /// of the scene, or of `count` on each body, and its start and end at the first and the last
    /// sample.
    pub fn propose(&self, count: Option<usize>) -> Result<Vec<MarkProposal>, PipelineError> {
        let marks = count.map_or(self.marks(), |count| {
            count + self.scene.events.len().max(1) - 1
        });
        let scene = &self.scene.with_marks(marks);
        let sketch = segment::clean::unmarked(scene, &self.events)?;
        let collisions = segment::propose(scene, &sketch, count).into_iter();
        let mut marks: Vec<MarkProposal> = collisions
            .map(|proposal| MarkProposal {
                body: Some(proposal.body),
                event: proposal.event,
                stamp: proposal.stamp(&sketch),
                time_s: proposal.acted_s,
                score: Some(proposal.score),
            })
            .collect();
        let stamps = || {
            sketch
                .bodies
                .iter()
                .flat_map(|b| &b.samples)
                .map(|s| s.stamp)
        };
        for (index, event) in scene.events.iter().enumerate() {
            let stamp = match event.kind {
                EventKind::Start => stamps().min(),
                EventKind::End => stamps().max(),
                EventKind::Collision(_) | EventKind::Collisions { .. } => None,
            };
            marks.extend(stamp.map(|stamp| MarkProposal {
                body: None,
                event: Some(index),
                stamp,
                time_s: stamp.seconds_since(sketch.origin),
                score: None,
            }));
        }
        marks.sort_by_key(|mark| mark.stamp);
        Ok(marks)
    }

    /// The estimate from all that was pushed, checked, and continued until it rests if the scene
    /// asks for that. A motion that is not physical is an outcome with that verdict; an error
    /// means that there is nothing to estimate from.
    pub fn finish(&self, observer: &mut dyn Observer) -> Result<Outcome, PipelineError> {
        let mut outcome = self.solved(observer)?;
        let scene = &outcome.scene;
        if outcome.estimate.verdict != Verdict::Failed {
            observer.phase(Phase::Verify);
            let verification = verify(scene, &outcome.estimate);
            judge(scene, &verification, &mut outcome.estimate);
            outcome.verification = Some(verification);
            if let Some(limit_s) = scene.settle_s {
                observer.phase(Phase::Settle);
                outcome.settled = settle(scene, &outcome.estimate, limit_s);
            }
        }
        observer.phase(Phase::Done);
        Ok(outcome)
    }

    /// The estimate from all that was pushed, unchecked: its verdict is that of its gaps alone.
    pub fn estimate(&self, observer: &mut dyn Observer) -> Result<Outcome, PipelineError> {
        let outcome = self.solved(observer)?;
        observer.phase(Phase::Done);
        Ok(outcome)
    }

    fn solved(&self, observer: &mut dyn Observer) -> Result<Outcome, PipelineError> {
        observer.phase(Phase::Clean);
        let scene = self.scene.with_marks(self.marks());
        let (mut sketch, mut counts) = segment::clean::clean(&scene, &self.events)?;
        let inferred = solve(&scene, &mut sketch, &mut counts, observer)?;
        Ok(Outcome::unchecked(inferred, sketch, counts))
    }

    /// Marks that were pushed: by these repeated collisions are counted.
    pub fn marks(&self) -> usize {
        let is_mark = |event: &&TakeEvent| matches!(event, TakeEvent::Mark(_));
        self.events.iter().filter(is_mark).count()
    }
}

/// A mark as the stream suggests it.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkProposal {
    /// Whose kink it is (index into `Scene::bodies`); `None` for start and end.
    pub body: Option<usize>,
    /// Its event (index into `Scene::events`), if as many were looked for as the scene has.
    pub event: Option<usize>,
    /// When, on the clock of the samples.
    pub stamp: Stamp,
    /// The same [s since the first sample].
    pub time_s: f64,
    /// See [`segment::Proposal::score`]; none for start and end.
    pub score: Option<f64>,
}

/// No motion is called physical in which solids are inside one another or another part than
/// expected would have touched first. The verdict becomes `plausible`, and the reason says why.
fn judge(scene: &Scene, verification: &Verification, estimate: &mut Estimate) {
    let Some(objection) = objection(scene, verification) else {
        return;
    };
    if estimate.verdict == Verdict::Physical {
        estimate.verdict = Verdict::Plausible;
    }
    estimate.reason = format!("{objection}; {}", estimate.reason);
}

/// What speaks against a motion whose gaps are closed, in the scene's names.
fn objection(scene: &Scene, verification: &Verification) -> Option<String> {
    let mut objections = Vec::new();
    if let Some(deepest) = &verification.deepest {
        objections.push(format!(
            "`{}` is {:.1} mm inside `{}` at {:.3} s",
            scene.bodies[deepest.body].name,
            deepest.depth_m * 1e3,
            scene.name_of(deepest.against),
            deepest.time_s
        ));
    }
    if let Some(touch) = verification.wrong_features().next() {
        let body = &scene.bodies[touch.body];
        let name = |feature: usize| body.features[feature].name.as_str();
        let expected: Vec<&str> = touch.expected.iter().map(|f| name(*f)).collect();
        let [x, y, z] = (touch.found_point_m * 1e3).into();
        objections.push(format!(
            "at `{}` `{}` leads `{}` by {:.1} mm",
            scene.events[touch.event].name,
            touch.found.map_or_else(
                || format!("[{x:.1}, {y:.1}, {z:.1}] mm"),
                |f| name(f).into()
            ),
            expected.join(", "),
            touch.lead_m * 1e3
        ));
    }
    (!objections.is_empty()).then(|| objections.join("; "))
}

/// Stages 2 to 4 on a clean sketch, whose marks are refined on the way.
fn solve(
    scene: &Scene,
    sketch: &mut Sketch,
    counts: &mut SampleCounts,
    observer: &mut dyn Observer,
) -> Result<Inferred, PipelineError> {
    let (segments, rounds) = segments(scene, sketch, counts, observer)?;
    let mut inferred = solve_segments(scene, sketch, (&segments, rounds), observer)?;
    let (segments, again) = follow(sketch, segments, &mut inferred, observer);
    inferred.estimate.counters.assignment_rounds += again;
    account(sketch, &segments, counts);
    Ok(inferred)
}

/// Stage 2 after cleaning: marks refined, the sketch cut, samples accounted for. Segments, and
/// the rounds of refinement.
fn segments(
    scene: &Scene,
    sketch: &mut Sketch,
    counts: &mut SampleCounts,
    observer: &mut dyn Observer,
) -> Result<(Vec<Segment>, usize), SegmentError> {
    observer.phase(Phase::Marks);
    let mut rounds = segment::refine(scene, sketch);
    counts.marks.moved = segment::reseat(scene, sketch);
    if !counts.marks.moved.is_empty() {
        rounds += segment::refine(scene, sketch);
    }
    segment::loosen(sketch);
    let segments = segment::cut(scene, sketch)?;
    Ok((segments, rounds))
}

/// Stages 3 and 4.
fn solve_segments(
    scene: &Scene,
    sketch: &mut Sketch,
    (segments, rounds): (&[Segment], usize),
    observer: &mut dyn Observer,
) -> Result<Inferred, PipelineError> {
    observer.phase(Phase::ArcFits);
    let guessed = initialise::guess(scene, sketch, segments);
    initialise::weigh(scene, sketch, segments, &guessed.guesses[0]);
    let recipe = Recipe::default();
    let mut inferred = infer(scene, sketch, segments, &guessed.guesses, &recipe, observer)
        .map_err(|NoContact { event }| PipelineError::NoContact {
            event: scene.events[event].name.clone(),
        })?;
    let counters = &mut inferred.estimate.counters;
    counters.fit_iterations = guessed.fit_iterations;
    counters.assignment_rounds = rounds;
    Ok(inferred)
}

/// Counts the samples that segments use; what lies between a body's segments is near a collision.
fn account(sketch: &Sketch, segments: &[Segment], counts: &mut SampleCounts) {
    counts.used = segments.iter().map(|segment| segment.samples.len()).sum();
    for (index, body) in sketch.bodies.iter().enumerate() {
        let of_body = || segments.iter().filter(move |segment| segment.body == index);
        let first = of_body().map(|segment| segment.samples.start).min();
        let last = of_body().map(|segment| segment.samples.end).max();
        let (first, last) = (first.unwrap_or(0), last.unwrap_or(0));
        let used: usize = of_body().map(|segment| segment.samples.len()).sum();
        counts.drop(DropReason::BeforeStart, first);
        counts.drop(DropReason::NearCollision, last - first - used);
        counts.drop(DropReason::AfterEnd, body.samples.len() - last);
    }
}
