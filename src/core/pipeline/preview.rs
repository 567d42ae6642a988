//! Previews: estimates during the performance.
//!
//! When the first `k` events of a scene are marked, the preview is the estimate of those events,
//! with the flight after the last of them open, from all samples so far; later events, their goals
//! and their parameters are left out. When the last event is marked it is that of the whole scene.
//!
//! With every mark the estimation begins anew, as the final one does. Between marks it continues
//! from the last solution: states, times, parameters and contacts are kept, moved to the flights'
//! new middles, and the steps of the finish suffice. It also begins anew where they do not suffice,
//! where another contact would come first, and whenever an open flight has grown by half, so that a
//! start from too few samples is not kept. Where samples fit worse than before, both are tried and
//! the better is kept.
//!
//! Unnamed marks of a scene with a repeated collision are taken as collisions: that the last one
//! was the end is known only when the take is over.

use super::follow::follow;
use super::infer::Inferred;
use super::outcome::{Outcome, PipelineError};
use super::sound::is_sound;
use super::stages::{account, cut, doubts_with_overlap, solve};
use super::warm::{self, Known};
use crate::estimate::{self, Deviations, Recipe, Solved};
use crate::motion::{
    Estimate, EventKind, Observer, Phase, Scene, Segment, Sketch, TakeEvent, Verdict,
};
use crate::segment;

/// Growth of the number of samples after which the estimation begins anew.
const GROWTH: f64 = 1.5;

/// Growth of the objective per sample after which both ways are tried.
const DOUBT: f64 = 1.25;

/// A performance in progress.
#[derive(Clone, Debug)]
pub struct Preview {
    scene: Scene,
    events: Vec<TakeEvent>,
    last: Option<Last>,
}

/// The last preview.
#[derive(Clone, Debug)]
struct Last {
    /// The part of the scene that was estimated.
    asked: Scene,
    segments: Vec<Segment>,
    outcome: Outcome,
    /// The solver's verdict, before doubts.
    solved: Verdict,
    begun: Begun,
}

/// The state when the estimation last began anew.
#[derive(Clone, Copy, Debug)]
struct Begun {
    /// Number of samples used.
    samples: usize,
    /// The objective, divided by them.
    per_sample: f64,
}

impl Begun {
    fn new(samples: usize, estimate: &Estimate) -> Self {
        Self {
            samples,
            per_sample: estimate.objective / samples.max(1) as f64,
        }
    }
}

/// A preview.
#[derive(Clone, Copy, Debug)]
pub struct Previewed<'a> {
    /// The estimate of the marked part of the scene, with a doubt where solids overlap; it is not led out of them, and nothing
    /// else is checked.
    pub outcome: &'a Outcome,
    /// Whether it continued from the previous one.
    pub is_warm: bool,
}

impl Preview {
    /// An empty take of a scene.
    pub fn new(scene: Scene) -> Self {
        Self {
            scene,
            events: Vec::new(),
            last: None,
        }
    }

    /// Adds an event, in any order.
    pub fn push(&mut self, event: TakeEvent) {
        self.events.push(event);
    }

    /// Number of marks so far.
    pub fn marks(&self) -> usize {
        self.mark_names().count()
    }

    /// The estimate from the events so far. `None` before the scene's start event; an error
    /// where an estimate is not possible yet, such as with too few samples after a mark.
    pub fn estimate(
        &mut self,
        observer: &mut dyn Observer,
    ) -> Result<Option<Previewed<'_>>, PipelineError> {
        let Some(scene) = self.scene_so_far() else {
            return Ok(None);
        };
        observer.phase(Phase::Clean);
        let (mut sketch, mut counts) = segment::clean::clean(&scene, &self.events)?;
        let mut cut = cut(&scene, &mut sketch, &mut counts, observer)?;
        let used: usize = cut.segments.iter().map(Segment::sample_count).sum();
        let last = self.last.take().filter(|last| last.asked == scene);
        let last = last.filter(|last| (used as f64) < GROWTH * last.begun.samples as f64);
        let marks = sketch.marks.clone();
        let warm = last.and_then(|last| {
            // Marks keep their weights.
            sketch.marks.clone_from(&last.outcome.sketch.marks);
            let tracks = sketch.tracks.iter_mut().zip(&last.outcome.sketch.tracks);
            for (track, last) in tracks {
                for (held, last) in track.motions_mut().zip(last.motions()) {
                    held.counted = last.counted;
                }
            }
            let solved = last.next(&sketch, &cut.segments, observer)?;
            Some((last.begun, last.continued(solved)))
        });
        let is_trusted = warm.as_ref().is_some_and(|(begun, warm)| {
            warm.solved.estimate.objective <= DOUBT * begun.per_sample * used as f64
        });
        let (begun, mut inferred, is_warm) = match warm {
            Some((begun, warm)) if is_trusted => (begun, warm, true),
            warm => {
                let weighed = std::mem::replace(&mut sketch.marks, marks);
                let anew = solve(&scene, &mut sketch, &cut, observer)?;
                let is_better = |warm: &Inferred| {
                    let (warm, anew) = (&warm.solved.estimate, &anew.solved.estimate);
                    warm.verdict == anew.verdict && warm.objective < anew.objective
                };
                let warm = warm.map(|(_, warm)| warm).filter(is_better);
                if warm.is_some() {
                    sketch.marks = weighed;
                }
                let (best, is_warm) = warm.map_or((anew, false), |warm| (warm, true));
                (Begun::new(used, &best.solved.estimate), best, is_warm)
            }
        };
        inferred.solved.estimate.counters.assignment_rounds = cut.rounds;
        follow(&mut sketch, &mut cut, &mut inferred, observer);
        account(&scene, &sketch, &cut.segments, &mut counts);
        let (segments, solved) = (cut.segments.clone(), inferred.solved.estimate.verdict);
        let mut outcome = Outcome::unchecked(
            inferred,
            cut.marks_made_s,
            sketch,
            counts,
            Deviations::OfNumbers,
            observer,
        );
        let doubts = doubts_with_overlap(&outcome, observer);
        outcome.estimate.doubt(doubts);
        let last = self.last.insert(Last {
            asked: scene,
            segments,
            outcome,
            solved,
            begun,
        });
        observer.phase(Phase::Done);
        Ok(Some(Previewed {
            outcome: &last.outcome,
            is_warm,
        }))
    }

    /// The marked part of the scene. Joined bodies are estimated when the take is over.
    fn scene_so_far(&self) -> Option<Scene> {
        if self.scene.joint_trees().next().is_some() {
            return None;
        }
        let events = &self.scene.events;
        let marks = self.marks();
        let is_named = |name: &str| self.mark_names().any(|mark| mark == Some(name));
        let repeat =
            |event: &&crate::motion::Event| matches!(event.kind, EventKind::Collisions { .. });
        // Events after the repeated one are still to come, except those that a mark names.
        let after = events.iter().rev().take_while(|event| !repeat(event));
        let to_come = after.filter(|event| !is_named(&event.name)).count();
        let whole = self.scene.with_marks(marks + to_come);
        let marked = whole.events_marked(self.mark_names());
        let waits = marked == 0 && events.first().is_some_and(|e| e.kind == EventKind::Start);
        if waits {
            return None;
        }
        // Of a phase that is not over the motion is told up to its beginning.
        let mut phases = whole.phases.iter();
        let begun = phases.find(|phase| phase.events[0] < marked && marked <= phase.events[1]);
        match begun.map(|phase| phase.events[0]) {
            None => Some(whole.first_events(marked)),
            Some(begun) => (begun > 0 && begun + 1 == marked).then(|| whole.until(begun)),
        }
    }

    fn mark_names(&self) -> impl Iterator<Item = Option<&str>> {
        self.events.iter().filter_map(|event| match event {
            TakeEvent::Mark(mark) => Some(mark.event.as_deref()),
            TakeEvent::Pose { .. } => None,
        })
    }
}

impl Last {
    /// The new motion in place of this one, in the scene with its inferred contacts.
    fn continued(self, solved: Solved) -> Inferred {
        Inferred {
            scene: self.outcome.given,
            events: self.outcome.inferred,
            search: self.outcome.search,
            rivals: self.outcome.estimate.contact_rivals,
            solved,
        }
    }

    /// The motion estimated from this one as the start; `None` where that gives no motion.
    fn next(
        &self,
        sketch: &Sketch,
        segments: &[Segment],
        observer: &mut dyn Observer,
    ) -> Option<Solved> {
        let known = Known {
            segments: &self.segments,
            estimate: &self.outcome.estimate,
        };
        if self.solved == Verdict::Failed {
            return None;
        }
        let scene = &self.outcome.given;
        let guess = [warm::guess(&known, scene, sketch, segments)?];
        let recipe = Recipe::default().from_the_last();
        let solved = estimate::estimate(scene, sketch, segments, &guess, &recipe, observer);
        let open = &self.outcome.inferred;
        let estimate = &solved.estimate;
        let is_good = estimate.verdict == self.solved && is_sound(scene, estimate, open);
        is_good.then_some(solved)
    }
}
