//! The result of an estimation: a motion, its timing, and how well both are met and determined.

use nalgebra::Vector3;

use super::certainty::{FlightCertainty, StateDeviation};
use super::contact_rival::ContactRival;
use super::doubt::{About, Doubt};
use super::fit::{Fit, FitUntold, Fits};
use super::held::{GripEstimate, HeldEstimate};
use super::index::{LinkIndex, MechanismIndex, TrackIndex};
use super::joined::TreeEstimate;
use super::reason::{End, Reason};
use super::sample_time::SampleTime;
use super::scene::{Quantity, Scene};
use super::suspect::Suspect;
use super::verdict::Verdict;
use crate::physics::{State, Support};

/// The motion of one mechanism between two of its events.
#[derive(Clone, Debug, PartialEq)]
pub struct ArcEstimate {
    /// What flies.
    pub mechanism: MechanismIndex,
    /// Physical time of `state` [s since the first sample].
    pub epoch_s: f64,
    /// State at the epoch.
    pub state: State,
    /// Physical time at which the arc begins \[s\].
    pub start_s: f64,
    /// Physical time at which it ends \[s\].
    pub end_s: f64,
    /// What supports it; `None` in flight.
    pub support: Option<Support>,
    /// How certain it is; `None` where that was not computed.
    pub certainty: Option<FlightCertainty>,
}

impl ArcEstimate {
    /// How certain pose and velocities at a time are, of the frame in which the scene gives what flies; `None` where that
    /// was not computed. Beyond its ends the flight is continued.
    pub fn deviation(
        &self,
        scene: &Scene,
        gravity_m_s2: &Vector3<f64>,
        time_s: f64,
    ) -> Option<StateDeviation> {
        let certainty = self.certainty.as_ref()?;
        let link = scene.mechanisms[self.mechanism].links().next()?;
        Some(certainty.deviation(
            &scene.body_on(self),
            gravity_m_s2,
            &self.state,
            time_s - self.epoch_s,
            &scene.links[link].link_from_given,
        ))
    }
}

/// Remaining violations of the constraints at an event, the largest of each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gap {
    /// Contact and position \[m\].
    pub position_m: f64,
    /// Orientation \[rad\].
    pub orientation_rad: f64,
    /// Velocity [m/s].
    pub velocity_m_s: f64,
    /// Angular velocity [rad/s].
    pub angular_velocity_rad_s: f64,
}

impl Gap {
    /// The larger of each kind.
    pub fn max(&self, other: &Self) -> Self {
        Self {
            position_m: self.position_m.max(other.position_m),
            orientation_rad: self.orientation_rad.max(other.orientation_rad),
            velocity_m_s: self.velocity_m_s.max(other.velocity_m_s),
            angular_velocity_rad_s: self
                .angular_velocity_rad_s
                .max(other.angular_velocity_rad_s),
        }
    }
}

/// An event as estimated.
#[derive(Clone, Debug, PartialEq)]
pub struct EventEstimate {
    /// Index into `Scene::events`.
    pub event: usize,
    /// Physical time [s since the first sample].
    pub time_s: f64,
    /// How long its contact lasts \[s\]: the flights after it begin so much later; zero of one moment.
    pub contact_s: f64,
    /// Its standard deviation \[s\], the first sample's time being zero; `None` where it is fixed,
    /// undetermined ([`Undetermined::EventTime`]) or was not computed.
    pub sd_s: Option<f64>,
    /// Whether it is given: by a physical stamp, by the scene, or as the zero of time.
    pub is_fixed: bool,
    /// The bound of the scene at which it is.
    pub at_bound: Option<AtBound>,
    /// Acted time, refined [s since `Sketch::origin`].
    pub acted_s: f64,
    /// Remaining violations of the constraints at it.
    pub gap: Gap,
    /// The guess of the scene on which its time leans most, where times are unknown.
    pub leaning: Option<Leaning>,
}

impl EventEstimate {
    /// Physical time at which what touched comes off \[s\].
    pub fn left_s(&self) -> f64 {
        self.time_s + self.contact_s
    }
}

/// How an event's estimated time leans on a value that the scene keeps fixed: its standard deviation supposes that
/// value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaning {
    /// What is guessed.
    pub quantity: Quantity,
    /// Its value in the scene, in the quantity's unit,
    pub value: f64,
    /// a change of it by which guesses are usually off,
    pub change: f64,
    /// and by how much later the event is with that, to first order \[s\].
    pub later_s: f64,
}

/// The duration of the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DurationEstimate {
    /// Physical time from the beginning of the first flight to the end of the last \[s\].
    pub duration_s: f64,
    /// Its standard deviation \[s\], zero where it is fixed; `None` where it is undetermined.
    pub sd_s: Option<f64>,
}

impl DurationEstimate {
    /// Greatest standard deviation of a determined duration, relative to it: beyond, one in twenty
    /// would be off by more than a fifth.
    pub const SHARE_MAX: f64 = 0.1;

    /// Whether the performance determines it, to within [`Self::SHARE_MAX`].
    pub fn is_determined(&self) -> bool {
        let limit_s = Self::SHARE_MAX * self.duration_s;
        self.sd_s.is_some_and(|sd_s| sd_s <= limit_s)
    }
}

/// A free parameter as estimated.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterEstimate {
    /// Its name in the scene.
    pub name: String,
    /// Value, in the quantity's unit.
    pub value: f64,
    /// Standard deviation; `None` where the performance does not determine it
    /// ([`Undetermined::Parameter`]) or it was not computed. At a bound, the bounds count as a prior
    /// with a standard deviation of half their width, and it covers what the performance asks for
    /// beyond the bound.
    pub sd: Option<f64>,
    /// The bound at which it is.
    pub at_bound: Option<AtBound>,
    /// Least value allowed.
    pub lower: f64,
    /// Greatest value allowed.
    pub upper: f64,
}

/// Residuals of what one track saw of one arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentResidual {
    /// Index into [`Estimate::arcs`].
    pub arc: usize,
    /// The track that the samples are of.
    pub track: TrackIndex,
    /// Samples in the objective.
    pub samples: usize,
    /// Root mean square distance of the centre of mass, or of the point that is seen \[m\]; `None`
    /// where none is.
    pub position_rms_m: Option<f64>,
    /// Root mean square angle \[rad\]; `None` where neither orientation nor direction is seen.
    pub orientation_rms_rad: Option<f64>,
}

/// What is left of some samples.
#[derive(Clone, Copy)]
struct SeenRms {
    samples: usize,
    /// Of places \[m\] and of turns \[rad\], where they are seen.
    kinds: [Option<f64>; 2],
}

/// A quantity that the performance does not determine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Undetermined {
    /// A free parameter (index into `Estimate::parameters`).
    Parameter(usize),
    /// The time of an event (index into `Scene::events`).
    EventTime(usize),
    /// What touches at an event where that was inferred (index into `Scene::events`).
    Contact(usize),
    /// How long the motion lasts.
    Duration,
    /// A part of a mechanism's motion, in one of its flights or in all.
    Motion {
        /// What moves.
        mechanism: MechanismIndex,
        /// The part.
        part: MotionPart,
    },
    /// A part of the state of one of several joined bodies, against what it hangs from.
    Link {
        /// The body.
        link: LinkIndex,
        /// The part.
        part: MotionPart,
    },
}

/// A part of the state of a moving body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionPart {
    /// Where its centre of mass is.
    Position,
    /// How it is turned.
    Orientation,
    /// How fast its centre of mass moves.
    Velocity,
    /// How fast it turns.
    Spin,
}

impl MotionPart {
    /// Whether it is of places (0) or of turns (1).
    pub fn kind(self) -> usize {
        match self {
            Self::Position | Self::Velocity => 0,
            Self::Orientation | Self::Spin => 1,
        }
    }

    /// All, in the order of a state.
    pub const ALL: [Self; 4] = [
        Self::Position,
        Self::Orientation,
        Self::Velocity,
        Self::Spin,
    ];

    /// Its name in reports.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Orientation => "orientation",
            Self::Velocity => "velocity",
            Self::Spin => "spin",
        }
    }
}

/// Counts of work by kind; tests hold golden values of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Steps computed in sweep, multiplier rounds and finish.
    pub iterations: usize,
    /// Evaluations of all sample residuals.
    pub evaluations: usize,
    /// Matrix factorisations.
    pub factorisations: usize,
    /// Iterations of the arc fits.
    pub fit_iterations: usize,
    /// Rounds of mark refinement and of time assignment.
    pub assignment_rounds: usize,
    /// Number of guesses tried.
    pub starts: usize,
}

impl Counters {
    /// Adds the work of another solve.
    pub fn add(&mut self, other: &Self) {
        self.iterations += other.iterations;
        self.evaluations += other.evaluations;
        self.factorisations += other.factorisations;
        self.fit_iterations += other.fit_iterations;
        self.assignment_rounds += other.assignment_rounds;
        self.starts += other.starts;
    }
}

impl Estimate {
    /// What is left of the samples of each flight and of joined bodies, of one track each.
    fn rms_of_each(&self) -> impl Iterator<Item = SeenRms> + Clone + '_ {
        let of_flights = self.residuals.iter().map(|of| SeenRms {
            samples: of.samples,
            kinds: [of.position_rms_m, of.orientation_rms_rad],
        });
        let of_trees = self.trees.iter().flat_map(|tree| &tree.residuals);
        let of_trees = of_trees.map(|of| SeenRms {
            samples: of.samples,
            kinds: [of.position_rms_m, of.orientation_rms_rad],
        });
        of_flights.chain(of_trees)
    }

    /// Root mean square distance \[m\] and angle \[rad\] from all samples that show them.
    pub fn residual_rms(&self) -> (f64, f64) {
        let rms = |kind: usize| {
            let seen = self.rms_of_each();
            let seen = seen.filter_map(|of| Some((of.samples as f64, of.kinds[kind]?)));
            // The sum of nothing is not minus zero.
            let sum = seen
                .clone()
                .fold(0.0, |sum, (samples, rms)| sum + samples * rms * rms);
            let samples: f64 = seen.map(|(samples, _)| samples).sum();
            (sum / samples.max(1.0)).sqrt()
        };
        (rms(0), rms(1))
    }

    /// Number of residuals of samples: three of each place and of each turn that is seen.
    pub fn residual_count(&self) -> usize {
        let each = self.rms_of_each();
        each.map(|of| 3 * of.samples * of.kinds.iter().flatten().count())
            .sum()
    }

    /// Whether the motion explains its performance: one that failed, or is doubted for its distance from the samples,
    /// does not. Unknown where nothing tells. How far goals lead it from them does not count.
    pub fn fits(&self) -> Fits {
        let mut abouts = self.doubts.iter().map(|doubt| doubt.about);
        let is_led = abouts.clone().any(|about| about == About::Led);
        let is_far = abouts.any(|of| of.is_distance() && !(is_led && of == About::Ambiguity));
        if self.verdict == Verdict::Failed || is_far {
            return Fits::No;
        }
        self.fit.as_ref().map_or(Fits::Unknown, |fit| fit.fits)
    }

    /// The motion of a link that is held throughout.
    pub fn held_motion(&self, link: LinkIndex) -> Option<&HeldEstimate> {
        self.held.iter().find(|held| held.link == link)
    }

    /// The motions of a link while it is in a hand.
    pub fn grips_of(&self, link: LinkIndex) -> impl Iterator<Item = &GripEstimate> {
        self.grips.iter().filter(move |of| of.motion.link == link)
    }

    /// Physical times of all used samples: of flights, and of bodies in the hand.
    pub fn all_sample_times(&self) -> impl Iterator<Item = &SampleTime> {
        let gripped = self.grips.iter().map(|of| &of.motion);
        let held = self.held.iter().chain(gripped);
        let held = held.flat_map(|held| &held.sample_times);
        self.sample_times.iter().chain(held)
    }

    /// The motion of a tree.
    pub fn tree_motion(&self, mechanism: MechanismIndex) -> Option<&TreeEstimate> {
        self.trees.iter().find(|tree| tree.mechanism == mechanism)
    }

    /// First and last time of the motion \[s\]: of its flights, of what is in a hand for a while, and of trees; `None` where there
    /// are none.
    pub fn extent_s(&self) -> Option<[f64; 2]> {
        let flights = self.arcs.iter().map(|arc| [arc.start_s, arc.end_s]);
        let grips = self.grips.iter().map(|of| of.span_s);
        let trees = self.trees.iter().map(TreeEstimate::span_s);
        let spans = flights.chain(grips).chain(trees);
        spans.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
    }

    /// Ends its flights, and what happens then, at a time at the latest \[s\]. Flights that begin later stay.
    pub fn end_at(&mut self, end_s: f64) {
        for arc in self.arcs.iter_mut().filter(|arc| arc.start_s < end_s) {
            arc.end_s = arc.end_s.min(end_s);
        }
        for grip in self.grips.iter_mut().filter(|of| of.span_s[0] < end_s) {
            grip.span_s[1] = grip.span_s[1].min(end_s);
        }
        for event in &mut self.events {
            event.time_s = event.time_s.min(end_s);
        }
    }

    /// Takes other contacts that are not ruled out: what touches at their events is not determined.
    pub fn is_rivalled_by(&mut self, rivals: Vec<ContactRival>) {
        for rival in &rivals {
            let open = Undetermined::Contact(rival.event);
            if !self.undetermined.contains(&open) {
                self.undetermined.push(open);
            }
        }
        self.contact_rivals = rivals;
    }

    /// There was no time to verify the motion: it is plausible at best.
    pub fn is_not_verified(&mut self) {
        self.verdict = self.verdict.max(Verdict::Plausible);
        if let End::Converged(progress) = self.reason.end {
            self.reason.end = End::Unverified(progress);
        }
    }

    /// Adds doubts: the verdict becomes the best that all of them permit.
    pub fn doubt(&mut self, mut doubts: Vec<Doubt>) {
        doubts.sort_by_key(|doubt| std::cmp::Reverse(doubt.about.best()));
        for doubt in &doubts {
            self.verdict = self.verdict.max(doubt.about.best());
        }
        self.doubts = doubts;
    }
}

/// A bound that holds a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AtBound {
    /// The lower one.
    Lower,
    /// The upper one.
    Upper,
    /// That of the cone it is in with another.
    Cone,
}

impl AtBound {
    /// Its name in files and reports.
    pub fn as_str(self) -> &'static str {
        match self {
            AtBound::Lower => "lower",
            AtBound::Upper => "upper",
            AtBound::Cone => "cone",
        }
    }
}

/// The result of an estimation.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// How physical the motion is.
    pub verdict: Verdict,
    /// Why the estimation ended, with the measured values and their bounds.
    pub reason: Reason,
    /// Doubts from the checks, the gravest first; none where no check was made.
    pub doubts: Vec<Doubt>,
    /// Objective (paper eq. 1, 6): sum of squared weighted residuals, priors included.
    pub objective: f64,
    /// Gravity, given or estimated [m/s², world].
    pub gravity_m_s2: Vector3<f64>,
    /// The motion: arcs mechanism by mechanism, in order of time.
    pub arcs: Vec<ArcEstimate>,
    /// The motions of bodies in the hand.
    pub held: Vec<HeldEstimate>,
    /// The motions of what is in a hand for a while, body by body, in order of time.
    pub grips: Vec<GripEstimate>,
    /// The motions of bodies joined in trees.
    pub trees: Vec<TreeEstimate>,
    /// The scene's events.
    pub events: Vec<EventEstimate>,
    /// The duration of the motion.
    pub duration: DurationEstimate,
    /// The scene's free parameters.
    pub parameters: Vec<ParameterEstimate>,
    /// One per arc, in the order of `arcs`.
    pub residuals: Vec<SegmentResidual>,
    /// Physical time of every used sample of a flight, track by track.
    pub sample_times: Vec<SampleTime>,
    /// How well the motion explains the performance, or why nothing tells that; [`Estimate::fits`] is the answer.
    pub fit: Result<Fit, FitUntold>,
    /// What may be wrong in the scene where it does not, the likeliest first.
    pub suspects: Vec<Suspect>,
    /// Number of other motions that were found and are as near to the keyframes; zero where the
    /// performance is a stream.
    pub rivals: usize,
    /// Other contacts than those that were inferred which are not ruled out ([`Undetermined::Contact`]).
    pub contact_rivals: Vec<ContactRival>,
    /// Names of the quantities that the performance does not determine.
    pub undetermined: Vec<Undetermined>,
    /// Work done.
    pub counters: Counters,
}
