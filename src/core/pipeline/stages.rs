//! The stages, one after the other, as the pipeline and its previews call them.

use super::infer::{Inferred, NoContact, infer};
use super::outcome::{Outcome, PipelineError};
use crate::estimate::Recipe;
use crate::initialise;
use crate::motion::{
    Doubt, DropReason, Observer, Penetration, Phase, SampleCounts, Scene, Segment, Sketch,
    TrackIndex, Verdict, Verification,
};
use crate::segment::{self, SegmentError};
use crate::verify::{credible, overlaps};

/// A sketch cut at its marks.
#[derive(Clone, Debug)]
pub(super) struct Cut {
    pub(super) segments: Vec<Segment>,
    /// Number of rounds of mark refinement.
    pub(super) rounds: usize,
    /// See [`Outcome::marks_made_s`].
    pub(super) marks_made_s: Vec<Option<f64>>,
}

/// Stage 2 after cleaning: marks refined, the sketch cut.
pub(super) fn cut(
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
        // A mark that was far from any kink is not used; the counts report it.
        for event in &counts.marks.moved {
            marks_made_s[*event] = Some(sketch.marks_s[*event]);
        }
        rounds += segment::refine(scene, sketch);
    }
    segment::regrip(scene, sketch);
    segment::press(scene, sketch);
    segment::loosen(scene, sketch);
    segment::hold(scene, sketch)?;
    let segments = segment::cut(scene, sketch)?;
    Ok(Cut {
        segments,
        rounds,
        marks_made_s,
    })
}

/// Stages 3 and 4: guesses, then the estimation.
pub(super) fn solve(
    scene: &Scene,
    sketch: &mut Sketch,
    cut: &Cut,
    observer: &mut dyn Observer,
) -> Result<Inferred, PipelineError> {
    let segments = &cut.segments;
    let scene = &segment::stuck(scene, sketch, segments)?;
    observer.phase(Phase::ArcFits);
    let guessed = initialise::guess(scene, sketch, segments, observer);
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

/// Counts the samples that segments use, and all of held bodies, but none of what is apart; those between a track's segments are near a collision.
pub(super) fn account(
    scene: &Scene,
    sketch: &Sketch,
    segments: &[Segment],
    counts: &mut SampleCounts,
) {
    counts.used = segments.iter().map(Segment::sample_count).sum();
    for (index, track) in sketch.tracks.iter_enumerated() {
        if !scene.sees_moving(index) {
            // All samples of what is held tell its motion.
            counts.used += usize::from(scene.sees_held(index)) * track.samples.len();
            continue;
        }
        let of_track = || {
            let views = segments.iter().flat_map(|segment| &segment.views);
            views.filter(move |view| view.track == index)
        };
        let first = of_track().map(|view| view.samples.start).min();
        let last = of_track().map(|view| view.samples.end).max();
        let (first, last) = (first.unwrap_or(0), last.unwrap_or(0));
        let used: usize = of_track().map(|view| view.samples.len()).sum();
        // What is in a hand is told by all samples of it.
        let gripped = gripped(scene, sketch, index);
        if let Some([from, until]) = gripped {
            let outside = from.min(first) + track.samples.len() - until.max(last);
            let within = track.samples.len() - outside;
            counts.used += within - used;
            counts.drop(DropReason::BeforeStart, from.min(first));
            counts.drop(DropReason::AfterEnd, track.samples.len() - until.max(last));
            continue;
        }
        counts.drop(DropReason::BeforeStart, first);
        counts.drop(DropReason::NearCollision, last - first - used);
        counts.drop(DropReason::AfterEnd, track.samples.len() - last);
    }
}

/// From the first sample of a body in a hand to after the last, of its own tracker; `None` where it is in none.
fn gripped(scene: &Scene, sketch: &Sketch, track: TrackIndex) -> Option<[usize; 2]> {
    let own = scene.phases.iter().filter(|phase| {
        let hand = scene.seen_in_hand(phase);
        hand.is_some_and(|hand| hand.track == track)
    });
    let samples = &sketch.tracks[track].samples;
    let ends = own.map(|phase| {
        let [from_s, until_s] = phase.events.map(|event| sketch.marks_s[event]);
        let from = samples.partition_point(|of| of.acted_s < from_s);
        [from, samples.partition_point(|of| of.acted_s <= until_s)]
    });
    ends.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
}

/// The same, with the deepest overlap that is found until the observer ends it: all that a preview looks at.
pub(super) fn doubts_with_overlap(outcome: &Outcome, observer: &mut dyn Observer) -> Vec<Doubt> {
    let mut all = doubts(outcome);
    if outcome.estimate.verdict != Verdict::Failed {
        let found = overlaps(&outcome.scene, &outcome.estimate, observer).into_iter();
        let deepest = found.fold(None, |deepest, of| Penetration::deeper(deepest, Some(of)));
        all.extend(deepest.map(|of| of.doubt(outcome.scene.tolerance_m)));
    }
    all
}

/// Doubts about a motion whose gaps are closed: from the checks that were made, and from its
/// credibility. None for a failed estimate.
pub(super) fn doubts(outcome: &Outcome) -> Vec<Doubt> {
    if outcome.estimate.verdict == Verdict::Failed {
        return Vec::new();
    }
    let checks = outcome.verification.iter();
    let mut doubts: Vec<Doubt> = checks.flat_map(Verification::doubts).collect();
    doubts.extend(credible::doubts(
        &outcome.scene,
        &outcome.given,
        &outcome.sketch,
        &outcome.marks_made_s,
        &outcome.estimate,
    ));
    doubts
}
