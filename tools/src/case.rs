//! One performance and everything that is needed to judge the estimate of it.

use std::collections::BTreeMap;

use enact::estimate::problem::Problem;
use enact::estimate::unknowns::layout::Layout;
use enact::initialise;
use enact::motion::{
    ArcGuess, Feature, Guess, LinkIndex, Observer, Performer, Scene, Segment, Sketch, Stamp,
    TakeEvent, TrackIndex, VelocityGaps, Verdict,
};
use enact::physics::{State, contact, flow};
use enact::pipeline::{Outcome, Pipeline, PipelineError};
use enact::segment;
use typed_index_collections::TiVec;

use crate::perform::{Acting, Performance, Style, Truth, perform};

/// A performance and the hidden physical time of every sample.
pub struct Case {
    /// What was performed, and the truth.
    pub performance: Performance,
    hidden_s: BTreeMap<(TrackIndex, Stamp), f64>,
}

impl Case {
    /// A pencil in the style's own scene; `acting` says whether stamps are physical times.
    pub fn pencil(style: Style, acting: &Acting, seed: u64) -> Self {
        Self::new(&style.truth(), acting, seed)
    }

    /// Acts a true motion.
    pub fn new(truth: &Truth, acting: &Acting, seed: u64) -> Self {
        let performance = perform(truth, acting, seed);
        let mut hidden_s = BTreeMap::new();
        let mut next = performance
            .sample_times_s
            .iter()
            .map(|_| 0)
            .collect::<TiVec<TrackIndex, _>>();
        for event in &performance.events {
            if let TakeEvent::Pose { track, sample, .. } = event {
                let time_s = performance.sample_times_s[*track][next[*track]];
                next[*track] += 1;
                hidden_s.insert((*track, sample.stamp), time_s);
            }
        }
        Self {
            performance,
            hidden_s,
        }
    }

    /// The same as if nobody acted it: samples count one by one.
    pub fn one_by_one(mut self) -> Self {
        self.performance.truth.scene.performer = Performer::Nobody;
        self
    }

    /// What it happens in, with what its stamps mean.
    pub fn scene(&self) -> &Scene {
        &self.performance.truth.scene
    }

    /// Moves the mark of an event by an acted time \[s\], at most to a hundredth of a second from the mark
    /// before it or after it, and not beyond the samples. For performances whose marks have names.
    ///
    /// # Panics
    /// Where no mark has the name.
    pub fn move_mark(&mut self, name: &str, by_s: f64) {
        const APART_NS: i64 = 10_000_000;
        let named = |event: &TakeEvent| match event {
            TakeEvent::Mark(mark) => mark.event.as_deref() == Some(name),
            TakeEvent::Pose { .. } => false,
        };
        let events = &mut self.performance.events;
        let of = events.iter().position(named).expect("a mark of that name");
        let stamp = |event: &TakeEvent| match event {
            TakeEvent::Mark(mark) => mark.stamp.0,
            TakeEvent::Pose { sample, .. } => sample.stamp.0,
        };
        let is_mark = |event: &&TakeEvent| matches!(event, TakeEvent::Mark(_));
        let now_ns = stamp(&events[of]);
        let marks = || events.iter().filter(is_mark).map(stamp);
        // All bodies are seen there.
        let seen = self.hidden_s.keys();
        let mut extents: BTreeMap<TrackIndex, (i64, i64)> = BTreeMap::new();
        for (track, stamp) in seen {
            let extent = extents.entry(*track).or_insert((stamp.0, stamp.0));
            *extent = (extent.0.min(stamp.0), extent.1.max(stamp.0));
        }
        let first = extents.values().map(|of| of.0).max();
        let last = extents.values().map(|of| of.1).min();
        let before = marks().filter(|at| *at < now_ns).max();
        let after = marks().filter(|at| *at > now_ns).min();
        let least = before.into_iter().chain(first).max().unwrap_or(now_ns) + APART_NS;
        let most = after.into_iter().chain(last).min().unwrap_or(now_ns) - APART_NS;
        let moved_ns = (now_ns + (1e9 * by_s) as i64).max(least).min(most);
        if let TakeEvent::Mark(mark) = &mut events[of] {
            mark.stamp = Stamp(moved_ns);
        }
    }

    /// The estimate, as the program makes it.
    pub fn estimated(&self, observer: &mut dyn Observer) -> Result<Outcome, PipelineError> {
        estimated(self.scene(), &self.performance.events, observer)
    }

    /// The performance on its way.
    pub fn pipeline(&self) -> Pipeline {
        Pipeline::of(self.scene().clone(), self.performance.events.clone())
    }

    /// The verdict with all checks.
    pub fn checked(&self) -> Option<Verdict> {
        let outcome = self.pipeline().finish(&mut ()).ok()?;
        Some(outcome.estimate.verdict)
    }

    /// Hidden physical time of a sample [s since the start of the motion].
    pub fn hidden_s(&self, track: TrackIndex, stamp: Stamp) -> f64 {
        self.hidden_s[&(track, stamp)]
    }

    /// What to add to hidden times to have them on the time line of an estimate: the zero of
    /// physical time is a convention, and the first sample that is used has it.
    pub fn offset_s(&self, posed: &Posed, sketch: &Sketch) -> f64 {
        let times = posed.segments.iter().zip(&posed.guesses[0].arcs);
        let firsts = times.filter_map(|(segment, arc)| {
            let view = &segment.views[0];
            let sample = sketch.samples_of(view).first()?;
            let guessed_s = arc.sample_times_s.first()?;
            Some((*guessed_s, self.hidden_s(view.track, sample.stamp)))
        });
        let first = firsts.min_by(|a, b| a.0.total_cmp(&b.0));
        first.map_or(0.0, |(guessed_s, hidden_s)| guessed_s - hidden_s)
    }

    /// The true state of an arc at a time on the estimate's time line.
    pub fn true_state(&self, arc: usize, time_s: f64, offset_s: f64) -> State {
        let truth = &self.performance.truth;
        let arc = &truth.arcs[arc];
        truth
            .scene
            .flown(arc, &truth.scene.gravity_m_s2, time_s - offset_s)
    }

    /// The problem of an outcome, and the truth as a guess for it: the program's own guess where
    /// velocities may jump, for then no motion is true.
    pub fn posed(&self, outcome: &Outcome) -> (Posed, Guess) {
        self.with_truth(Posed::new(&outcome.given, &outcome.sketch), outcome)
    }

    /// The same without the performer's marks, and without what the program sets free by itself: for
    /// methods and solvers that are asked about the samples alone. They know no clocks of flights.
    pub fn posed_without_marks(&self, outcome: &Outcome) -> (Posed, Guess) {
        let posed = Posed::without_marks(self.scene(), &outcome.sketch);
        self.with_truth(posed, outcome)
    }

    fn with_truth(&self, mut posed: Posed, outcome: &Outcome) -> (Posed, Guess) {
        if is_bent(&outcome.scene) {
            posed.problem = posed.problem.with_velocity_gaps();
            posed.layout = Layout::new(&posed.problem);
            let guess = posed.guesses[0].clone();
            return (posed, guess);
        }
        let mut guess = self.true_guess(&posed, &outcome.sketch);
        if !posed.problem.times_are_unknown() {
            // Stamps are rounded to nanoseconds, and where they are called physical by mistake the
            // true times are those of another problem.
            for (arc, own) in guess.arcs.iter_mut().zip(&posed.guesses[0].arcs) {
                arc.sample_times_s.clone_from(&own.sample_times_s);
            }
        }
        (posed, guess)
    }

    /// The truth as a guess, at the epochs of the program's own.
    pub fn true_guess(&self, posed: &Posed, sketch: &Sketch) -> Guess {
        let offset_s = self.offset_s(posed, sketch);
        let own = &posed.guesses[0];
        let arcs = posed.segments.iter().zip(&own.arcs).enumerate();
        let arcs = arcs.map(|(index, (segment, arc))| {
            let view = &segment.views[0];
            let samples = sketch.samples_of(view);
            let hidden_s = |stamp| self.hidden_s(view.track, stamp) + offset_s;
            ArcGuess {
                epoch_s: arc.epoch_s,
                state: self.true_state(index, arc.epoch_s, offset_s),
                sample_times_s: samples
                    .iter()
                    .map(|sample| hidden_s(sample.stamp))
                    .collect(),
            }
        });
        let event_times_s = self.performance.truth.event_times_s.iter();
        Guess {
            arcs: arcs.collect(),
            event_times_s: event_times_s.map(|time_s| time_s + offset_s).collect(),
            parameters: own.parameters.clone(),
        }
    }
}

/// Whether velocities may jump in a scene.
pub fn is_bent(scene: &Scene) -> bool {
    scene.velocity_gaps == VelocityGaps::Always
}

/// The verdict of a right answer: a motion with jumps is none that physics allows.
pub fn best_verdict(scene: &Scene) -> Verdict {
    if is_bent(scene) {
        Verdict::Plausible
    } else {
        Verdict::Physical
    }
}

/// A take through the pipeline.
pub fn estimated(
    scene: &Scene,
    events: &[TakeEvent],
    observer: &mut dyn Observer,
) -> Result<Outcome, PipelineError> {
    Pipeline::of(scene.clone(), events.to_vec()).estimate(observer)
}

/// Whether another point than the one that touches would be inside a table at z = 0 by more than
/// a millimetre, at any collision of the first body.
pub fn another_leads(outcome: &Outcome) -> bool {
    const LEAD_M: f64 = 1e-3;
    let (scene, estimate) = (&outcome.scene, &outcome.estimate);
    let features = &scene.links[LinkIndex(0)].features;
    let collisions = scene.events.iter().zip(&estimate.events);
    let mut collisions = collisions.filter_map(|(of_scene, event)| {
        let feature = of_scene.kind.collision()?.contacts[0].feature?;
        let arc = estimate.arcs.iter().find(|arc| arc.end_s == event.time_s)?;
        Some((feature, event.time_s, arc))
    });
    collisions.any(|(feature, time_s, arc)| {
        let state = flow::advance(
            &scene.links[LinkIndex(0)].body,
            &estimate.gravity_m_s2,
            &arc.state,
            time_s - arc.epoch_s,
        );
        let height_m = |feature: &Feature| match feature.geometry {
            contact::Feature::Point { point_m, .. } => {
                (state.position_m + state.orientation * point_m).z
            }
            _ => f64::INFINITY,
        };
        let lowest_m = features.iter().map(height_m).fold(f64::INFINITY, f64::min);
        height_m(&features[feature]) - lowest_m > LEAD_M
    })
}

/// The problem that the pipeline solved, and where it started from.
pub struct Posed {
    /// How the sketch was cut.
    pub segments: Vec<Segment>,
    /// The program's own guesses.
    pub guesses: Vec<Guess>,
    /// The problem.
    pub problem: Problem,
    /// Where its unknowns sit.
    pub layout: Layout,
}

impl Posed {
    /// The same without the performer's marks: for methods and solvers that are asked about the
    /// samples alone.
    pub fn without_marks(scene: &Scene, sketch: &Sketch) -> Self {
        let mut sketch = sketch.clone();
        sketch.marks.fill(None);
        Self::new(scene, &sketch)
    }

    /// From an outcome's sketch, whose marks are refined already.
    pub fn new(scene: &Scene, sketch: &Sketch) -> Self {
        let segments = segment::cut(scene, sketch).expect("it was cut before");
        let guesses = initialise::guess(scene, sketch, &segments, &mut ()).guesses;
        let problem = Problem::new(scene, sketch, &segments);
        let layout = Layout::new(&problem);
        Self {
            segments,
            guesses,
            problem,
            layout,
        }
    }
}
