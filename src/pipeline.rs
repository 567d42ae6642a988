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
    Doubt, DropReason, Estimate, EventKind, Observer, Phase, SampleCounts, Scene, Segment, Settled,
    Sketch, Stamp, TakeEvent, Verdict, Verification,
};
use crate::segment::{self, SegmentError};
use crate::settle::settle;
use crate::verify::{credible, verify};

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
    fn unchecked(
        inferred: Inferred,
        cut: Cut,
        (sketch, counts): (Sketch, SampleCounts),
        observer: &mut dyn Observer,
    ) -> Self {
        let scene = inferred.scene;
        Self {
            estimate: inferred.solved.with_deviations(&scene, observer),
            marks_made_s: cut.marks_made_s,
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
        if outcome.estimate.verdict != Verdict::Failed {
            observer.phase(Phase::Verify);
            outcome.verification = Some(verify(&outcome.scene, &outcome.estimate));
            let doubts = doubts(&outcome);
            outcome.estimate.doubt(doubts);
        }
        let scene = &outcome.scene;
        if outcome.estimate.verdict != Verdict::Failed
            && let Some(limit_s) = scene.settle_s
        {
            observer.phase(Phase::Settle);
            outcome.settled = settle(scene, &outcome.estimate, limit_s);
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
        let mut cut = cut(&scene, &mut sketch, &mut counts, observer)?;
        let mut inferred = solve(&scene, &mut sketch, &cut, observer)?;
        follow(&mut sketch, &mut cut, &mut inferred, observer);
        account(&sketch, &cut.segments, &mut counts);
        let performed = (sketch, counts);
        Ok(Outcome::unchecked(inferred, cut, performed, observer))
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

/// What speaks against a motion whose gaps are closed: what checks found that were made, and whether it
/// could be what was acted. Nothing of one that failed.
fn doubts(outcome: &Outcome) -> Vec<Doubt> {
    if outcome.estimate.verdict == Verdict::Failed {
        return Vec::new();
    }
    let checks = outcome.verification.iter();
    let mut doubts: Vec<Doubt> = checks.flat_map(Verification::doubts).collect();
    doubts.extend(credible::doubts(
        &outcome.scene,
        &outcome.sketch,
        &outcome.marks_made_s,
        &outcome.estimate,
    ));
    doubts
}

/// A sketch cut at its marks.
#[derive(Clone, Debug)]
struct Cut {
    segments: Vec<Segment>,
    /// Rounds of refinement.
    rounds: usize,
    marks_made_s: Vec<Option<f64>>,
}

/// Stage 2 after cleaning: marks refined, the sketch cut.
fn cut(
    scene: &Scene,
    sketch: &mut Sketch,
    counts: &mut SampleCounts,
    observer: &mut dyn Observer,
) -> Result<Cut, SegmentError> {
    observer.phase(Phase::Marks);
    let made_s = sketch.marks_s.iter().enumerate();
    let is_made = |event: usize| !counts.marks.proposed.contains(&event);
    let made_s = made_s.map(|(event, made_s)| is_made(event).then_some(*made_s));
    let mut marks_made_s: Vec<Option<f64>> = made_s.collect();
    let mut rounds = segment::refine(scene, sketch);
    counts.marks.moved = segment::relocate_marks(scene, sketch);
    if !counts.marks.moved.is_empty() {
        // A mark that was far from any kink is none; that it was is said.
        for event in &counts.marks.moved {
            marks_made_s[*event] = Some(sketch.marks_s[*event]);
        }
        rounds += segment::refine(scene, sketch);
    }
    segment::loosen(sketch);
    let segments = segment::cut(scene, sketch)?;
    Ok(Cut {
        segments,
        rounds,
        marks_made_s,
    })
}

/// Stages 3 and 4.
fn solve(
    scene: &Scene,
    sketch: &mut Sketch,
    cut: &Cut,
    observer: &mut dyn Observer,
) -> Result<Inferred, PipelineError> {
    let segments = &cut.segments;
    observer.phase(Phase::ArcFits);
    let guessed = initialise::guess(scene, sketch, segments);
    initialise::weigh(scene, sketch, segments, &guessed.guesses[0]);
    let recipe = Recipe::default();
    let mut inferred = infer(scene, sketch, segments, &guessed.guesses, &recipe, observer)
        .map_err(|NoContact { event }| PipelineError::NoContact {
            event: scene.events[event].name.clone(),
        })?;
    let counters = &mut inferred.solved.estimate.counters;
    counters.fit_iterations = guessed.fit_iterations;
    counters.assignment_rounds = cut.rounds;
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
