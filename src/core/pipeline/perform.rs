//! From the events of a take to a motion without deviations and checks: stages 2 to 4.

use nalgebra::UnitQuaternion;

use super::follow::follow;
use super::infer::Inferred;
use super::outcome::{Outcome, PipelineError};
use super::stages::{Cut, account, cut, solve};
use super::stick;
use crate::estimate::{Deviations, Solved};
use crate::motion::{
    Doubt, GoalTarget, Observer, Performance, Phase, Sample, SampleCounts, Scene, Segment, Sketch,
    TakeEvent, TrackIndex,
};
use crate::verify::credible;
use crate::{estimate, initialise, segment};

/// A take that is cleaned and cut.
pub(super) struct Prepared {
    scene: Scene,
    sketch: Sketch,
    counts: SampleCounts,
    cut: Cut,
}

/// A motion, and the performance that it is of.
#[derive(Clone)]
pub(super) struct Performed {
    pub(super) inferred: Inferred,
    pub(super) sketch: Sketch,
    pub(super) counts: SampleCounts,
    /// See [`Outcome::marks_made_s`].
    pub(super) marks_made_s: Vec<Option<f64>>,
    /// How the sketch is cut.
    pub(super) segments: Vec<Segment>,
}

impl Performed {
    /// What the motion is an estimate of.
    pub(super) fn performance(&self) -> Performance<'_> {
        Performance {
            scene: &self.inferred.scene,
            sketch: &self.sketch,
            segments: &self.segments,
        }
    }

    /// Whether and why the motion is doubted for how it is as a performance.
    pub(super) fn doubts(&self) -> Vec<Doubt> {
        let Inferred { scene, solved, .. } = &self.inferred;
        credible::doubts(
            &scene.as_estimated(&solved.estimate),
            scene,
            &self.sketch,
            &self.marks_made_s,
            &solved.estimate,
        )
    }

    /// Goes on to the motion with the likeliest errors of a hand.
    pub(super) fn refine(&mut self, observer: &mut dyn Observer) {
        let (solved, performance) = self.parts();
        solved.refine(performance, observer);
        self.stick(observer);
    }

    /// Goes on so from a motion that was led elsewhere, where samples did not show a hand before.
    pub(super) fn refine_again(&mut self, observer: &mut dyn Observer) {
        match self.inferred.solved.errs_in_time() {
            true => self.stick(observer),
            false => self.refine(observer),
        }
    }

    /// Goes on to the motion in which bodies stick together where they meet in it.
    fn stick(&mut self, observer: &mut dyn Observer) {
        stick::again(&mut self.inferred, &self.sketch, &self.segments, observer);
    }

    /// Looks whether the motion explains the performance.
    pub(super) fn judge(&mut self, observer: &mut dyn Observer) {
        let (solved, performance) = self.parts();
        solved.judge(performance, observer);
    }

    /// The motion, and the performance that it is of.
    pub(super) fn parts(&mut self) -> (&mut Solved, Performance<'_>) {
        let Inferred { scene, solved, .. } = &mut self.inferred;
        let performance = Performance {
            scene,
            sketch: &self.sketch,
            segments: &self.segments,
        };
        (solved, performance)
    }

    /// The motion with its deviations.
    pub(super) fn outcome(self, observer: &mut dyn Observer) -> Outcome {
        Outcome::unchecked(
            self.inferred,
            self.marks_made_s,
            self.sketch,
            self.counts,
            Deviations::OfMotion,
            observer,
        )
    }
}

impl Prepared {
    /// Cleans and cuts a take. A repeated collision happens as often as marks say.
    pub(super) fn new(
        scene: &Scene,
        events: &[TakeEvent],
        observer: &mut dyn Observer,
    ) -> Result<Self, PipelineError> {
        observer.phase(Phase::Clean);
        let scene = scene.with_marks(marks(events)).with_flight_clocks();
        let (mut sketch, mut counts) = segment::clean::clean(&scene, events)?;
        let cut = cut(&scene, &mut sketch, &mut counts, observer)?;
        let scene = scene.with_sample_times(&sketch, &cut.segments);
        Ok(Self {
            scene,
            sketch,
            counts,
            cut,
        })
    }

    /// Root mean square distance of the flights from their samples when each is fitted by itself,
    /// in the scene's weights; infinite where nothing can touch at a collision.
    pub(super) fn alone(&self, observer: &mut dyn Observer) -> f64 {
        let segments = &self.cut.segments;
        // Without constraints it does not matter what touches.
        let mut scene = self.scene.clone();
        for event in scene.open_events() {
            let Some(any) = scene.candidates(event).into_iter().next() else {
                return f64::INFINITY;
            };
            scene.set_contacts(event, &any);
        }
        let guessed = initialise::guess(&self.scene, &self.sketch, segments, observer);
        let cost = estimate::cost(&scene, &self.sketch, segments, &guessed.guesses[0]);
        let samples: usize = segments.iter().map(Segment::sample_count).sum();
        (2.0 * cost / samples.max(1) as f64).sqrt()
    }

    /// What is seen of the flights, and the events at which they end.
    pub(super) fn flights(&self) -> impl Iterator<Item = (TrackIndex, &[Sample], Option<usize>)> {
        let segments = self.cut.segments.iter();
        segments.flat_map(|segment| {
            let views = segment.views.iter();
            views.map(|view| (view.track, self.sketch.samples_of(view), segment.end_event))
        })
    }

    /// The orientation that the scene asks of what a track sees at an event.
    pub(super) fn asked(&self, track: TrackIndex, event: usize) -> Option<UnitQuaternion<f64>> {
        let link = self.scene.tracks[track].link;
        self.scene.goals.iter().find_map(|goal| match goal.target {
            GoalTarget::Pose { world_from_body } if (goal.event, goal.link) == (event, link) => {
                Some(world_from_body.rotation)
            }
            _ => None,
        })
    }

    /// The motion.
    pub(super) fn performed(self, observer: &mut dyn Observer) -> Result<Performed, PipelineError> {
        let mut performed = self.one_by_one(observer)?;
        performed.refine(observer);
        Ok(performed)
    }

    /// The motion at which each sample errs by itself: the nearest to all of them.
    pub(super) fn one_by_one(
        self,
        observer: &mut dyn Observer,
    ) -> Result<Performed, PipelineError> {
        let Self {
            scene,
            mut sketch,
            mut counts,
            mut cut,
        } = self;
        let mut inferred = solve(&scene, &mut sketch, &cut, observer)?;
        follow(&mut sketch, &mut cut, &mut inferred, observer);
        account(&scene, &sketch, &cut.segments, &mut counts);
        Ok(Performed {
            inferred,
            sketch,
            counts,
            marks_made_s: cut.marks_made_s,
            segments: cut.segments,
        })
    }
}

/// Number of marks in a take.
pub(super) fn marks(events: &[TakeEvent]) -> usize {
    let is_mark = |event: &&TakeEvent| matches!(event, TakeEvent::Mark(_));
    events.iter().filter(is_mark).count()
}
