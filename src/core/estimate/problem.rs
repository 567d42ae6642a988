//! The estimation problem in the solver's terms: arcs, events, constraints and free unknowns.

pub mod arc_condition;
pub mod clearance;
pub mod influence;
pub(in crate::estimate) mod pull;
pub mod weave;

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::{Matrix6, UnitQuaternion, Vector3};
use typed_index_collections::TiVec;

use self::arc_condition::ArcCondition;
use self::clearance::Clearance;
use self::influence::{Acting, Influence, Role};
use self::pull::Pull;
use self::weave::Weave;
use crate::math::Pose;
use crate::motion::held::StateCovariance;
use crate::motion::{
    Cone, FreeParameter, HeldMotion, LinkIndex, MechanismIndex, Performer, Stamp, TrackIndex,
};
use crate::physics::impact::{ContactSet, Impact, Law, Pressed, PressedOn, Side};
use crate::physics::support::Caught;
use crate::physics::{Body, State, state};

/// Units of constraints: violations of one unit have equal weight.
pub mod unit {
    use crate::motion::GoalUnit;

    /// Contact gap and position \[m\].
    pub const POSITION_M: f64 = 0.01;
    /// Orientation \[rad\].
    pub const ORIENTATION_RAD: f64 = 0.1;
    /// Velocity [m/s].
    pub const VELOCITY_M_S: f64 = 0.1;
    /// Angular velocity [rad/s].
    pub const ANGULAR_VELOCITY_RAD_S: f64 = 1.0;
    /// Time of an event, or interval between two \[s\].
    pub const TIME_S: f64 = 0.01;

    /// One unit of a row, in the unit of its quantity.
    pub fn of(quantity: GoalUnit) -> f64 {
        match quantity {
            GoalUnit::Metre => POSITION_M,
            GoalUnit::Radian => ORIENTATION_RAD,
            GoalUnit::MetrePerSecond => VELOCITY_M_S,
            GoalUnit::RadianPerSecond => ANGULAR_VELOCITY_RAD_S,
            GoalUnit::Second => TIME_S,
        }
    }
}

/// Weight of a squared unit of velocity gap, per [`Problem::information`]. At one the motion stays
/// near the performance; ten times as much reduces the gaps of a die with six given faces by a
/// tenth, and increases the distance from the performance to four times.
pub(super) const VELOCITY_GAP_WEIGHT: f64 = 1.0;

/// One sample of an arc: what of it counts is said by its view ([`Shows`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcSample {
    /// When the tracker measured it.
    pub stamp: Stamp,
    /// Centre of mass, or the point that is seen; zero where no position is [m, world].
    pub position_m: Vector3<f64>,
    /// World from body; that of a direction turns the axis to it; the identity where neither is seen.
    pub orientation: UnitQuaternion<f64>,
    /// Index into [`Problem::nodes_acted_s`]: the node at or before it.
    pub node: usize,
    /// Its share of the interval to the next node; zero at a node.
    pub share: f64,
    /// Parameter that holds what is to be added to its time, where that is not known.
    pub open: Option<usize>,
}

impl ArcSample {
    /// Its physical time, given those of the nodes \[s\].
    #[inline]
    pub fn time_s(&self, node_times_s: &[f64]) -> f64 {
        let node_s = node_times_s[self.node];
        if self.share > 0.0 {
            node_s + self.share * (node_times_s[self.node + 1] - node_s)
        } else {
            node_s
        }
    }

    /// The nodes that it follows, with by how much.
    pub fn shares(&self) -> impl Iterator<Item = (usize, f64)> + Clone + use<> {
        let both = [(self.node, 1.0 - self.share), (self.node + 1, self.share)];
        both.into_iter().filter(|(_, share)| *share > 0.0)
    }

    /// Its time with what is added where it is not known, before any correction of its clock \[s\].
    pub fn stamped_s(&self, node_times_s: &[f64], parameters: &[f64]) -> f64 {
        let added_s = self.open.map_or(0.0, |parameter| parameters[parameter]);
        self.time_s(node_times_s) + added_s
    }
}

/// Least number of samples of an arc that tell its state.
pub(in crate::estimate) const INFORMED_MIN: usize = 3;

/// What the samples of a view show of the state `q = (x, R, v, ω)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shows {
    /// `x` and `R`.
    Pose,
    /// `x + R p` of the point `p` on which the tracker is mounted.
    Point,
    /// `R`.
    Orientation,
    /// `R a` of an axis `a` of the link.
    Direction(Vector3<f64>),
}

impl Shows {
    /// Whether positions, and whether orientations or directions, are seen.
    pub fn kinds(self) -> [bool; 2] {
        match self {
            Shows::Pose => [true, true],
            Shows::Point => [true, false],
            Shows::Orientation | Shows::Direction(_) => [false, true],
        }
    }
}

/// What one track shows of an arc.
#[derive(Clone, Debug)]
pub struct View {
    /// What saw it.
    pub track: TrackIndex,
    /// What its samples show.
    pub shows: Shows,
    /// Its samples in order.
    pub samples: Vec<ArcSample>,
    /// Units of its residuals \[m, rad\]; infinite for what is not seen.
    pub units: [f64; 2],
    /// Where the weights of samples differ, for every sample `L⁻¹`, with the covariance `L Lᵀ` of the
    /// tracker's position and rotation vector in world axes; empty otherwise.
    pub whitenings: Vec<Matrix6<f64>>,
    /// `(L Lᵀ)⁻¹` of each of them.
    pub informations: Vec<Matrix6<f64>>,
    /// Whether the short form of its residuals serves ([`samples`](crate::estimate::terms::samples)): of a parabola on
    /// which at most gravity acts it shows the centre of mass, the orientation or both, with the same
    /// weight in all samples and at times that no parameter changes.
    pub is_plain: bool,
}

impl View {
    /// Whether positions, and whether orientations or directions, are seen with a weight that counts.
    pub fn kinds(&self) -> [bool; 2] {
        self.units.map(f64::is_finite)
    }
}

/// Flight of one mechanism between two events.
#[derive(Clone, Debug)]
pub struct Arc {
    /// What flies.
    pub mechanism: MechanismIndex,
    /// Its equations of motion there, where nothing of them is free.
    pub body: Body,
    /// Event at its start.
    pub start: Option<usize>,
    /// Event at its end.
    pub end: Option<usize>,
    /// What is seen of it.
    pub views: Vec<View>,
    /// Parameter that holds the friction of what supports it, where that is free.
    pub friction_parameter: Option<usize>,
    /// Parameter that holds its clock, where its stamps count from a zero of their own.
    pub clock: Option<usize>,
    /// Parameters that act on it or on what is seen of it, where it is not plain; gravity among
    /// them.
    pub acting: Vec<Acting>,
    /// Whether it is a parabola on which at most gravity acts.
    pub is_plain: bool,
}

impl Arc {
    /// Number of samples of all its views.
    pub fn sample_count(&self) -> usize {
        self.views.iter().map(|view| view.samples.len()).sum()
    }

    /// Its samples as they are in the sketch: of each track in order of time, whatever each shows.
    pub fn samples_as_read(&self) -> impl Iterator<Item = (TrackIndex, Vec<&ArcSample>)> {
        let tracks = self.views.chunk_by(|a, b| a.track == b.track);
        tracks.map(|kinds| {
            let mut samples: Vec<&ArcSample> = kinds.iter().flat_map(|of| &of.samples).collect();
            samples.sort_by_key(|sample| sample.stamp);
            (kinds[0].track, samples)
        })
    }

    /// Its samples, one view after the other.
    pub fn samples(&self) -> impl Iterator<Item = &ArcSample> + Clone {
        self.views.iter().flat_map(|view| &view.samples)
    }

    /// Its first and its last sample in order of time.
    pub fn ends(&self) -> Option<[&ArcSample; 2]> {
        let place = |sample: &ArcSample| (sample.node, sample.share);
        let earlier = |a: &ArcSample, b: &ArcSample| place(a).partial_cmp(&place(b));
        let earlier = move |a: &&ArcSample, b: &&ArcSample| earlier(a, b).expect("finite shares");
        let firsts = self.views.iter().filter_map(|view| view.samples.first());
        let lasts = self.views.iter().filter_map(|view| view.samples.last());
        Some([firsts.min_by(earlier)?, lasts.max_by(earlier)?])
    }

    /// Whether its samples say anything of its places (0) or of its turn (1).
    pub fn shows(&self, kind: usize) -> bool {
        let mut views = self.views.iter().filter(|view| !view.samples.is_empty());
        views.any(|view| {
            let is_lever = view.shows == Shows::Point && !view.is_plain;
            view.kinds()[kind] || kind == 1 && is_lever
        })
    }

    /// Whether its own samples tell its state, or only the impacts beside it.
    pub fn is_informed(&self) -> bool {
        self.sample_count() >= INFORMED_MIN
    }
}

/// Arcs of one mechanism before and after an event.
#[derive(Clone, Copy, Debug)]
pub struct ArcPair {
    /// What flies.
    pub mechanism: MechanismIndex,
    /// Arc before.
    pub before: usize,
    /// Arc after.
    pub after: usize,
}

/// An impact that ties the arcs of one mechanism, or of two.
#[derive(Clone, Debug)]
pub struct ArcCollision {
    /// Event at which it happens.
    pub event: usize,
    /// The body, and the other one unless it hits the static world or a held body.
    pub sides: Vec<ArcPair>,
    /// The held body that it hits (index into [`Problem::held`]).
    pub held: Option<usize>,
    /// Its contacts.
    pub contacts: ContactSet,
    /// Whether a goal fixes the body in contact, so that no row is needed for the gap.
    pub touches_by_goal: bool,
    /// Restitutions, friction and tilt, where they are not free.
    pub law: Law,
    /// Parameter that holds the restitution.
    pub restitution_parameter: Option<usize>,
    /// Parameter that holds the friction.
    pub friction_parameter: Option<usize>,
    /// Parameter that holds the tangential restitution.
    pub tangential_parameter: Option<usize>,
    /// Tangents of the first contact's face and the parameters that hold the tilt about them.
    pub tilts: Vec<(usize, usize)>,
    /// Parameters that act on its flights, bodies or surface, where it is not plain; gravity among
    /// them.
    pub acting: Vec<Acting>,
    /// Whether its flights are parabolas on which at most gravity acts, between bodies and a
    /// surface that are given.
    pub is_plain: bool,
}

impl ArcCollision {
    /// How long its contact lasts \[s\]; `None` of one moment.
    pub fn contact_s(&self, parameters: &[f64]) -> Option<f64> {
        let mut acting = self.acting.iter();
        let lasting = acting.find(|acting| acting.influence == Influence::ContactDuration);
        Some(parameters[lasting?.parameter])
    }

    /// How a body is pressed whose contact lasts, at a speed of the first contact along its normal [m/s]; `None` of one
    /// moment.
    pub fn pressed(
        &self,
        body: &Body,
        gravity_m_s2: &Vector3<f64>,
        parameters: &[f64],
        speed_m_s: f64,
    ) -> Option<Pressed> {
        let duration_s = self.contact_s(parameters)?;
        let on = match (self.sides.len(), self.held) {
            (1, None) => PressedOn::World,
            (1, Some(_)) => PressedOn::Held,
            _ => PressedOn::Flying,
        };
        let restitution = self.law(parameters).restitution;
        let contacts = &self.contacts;
        Some(Pressed::new(
            contacts,
            on,
            body,
            gravity_m_s2,
            speed_m_s,
            restitution,
            duration_s,
        ))
    }

    /// The impact, and the states in which the bodies come off.
    pub fn struck(
        &self,
        sides: [Option<&Side>; 2],
        gravity_m_s2: &Vector3<f64>,
        parameters: &[f64],
    ) -> Option<(Impact, Vec<State>)> {
        let [a, b] = sides;
        let (a, law) = (a?, self.law(parameters));
        let at_once = self.contacts.impact(a, b, &law).ok()?;
        let pressed = |side: &Side| {
            let speed_m_s = at_once.speeds_m_s[0];
            self.pressed(side.body, gravity_m_s2, parameters, speed_m_s)
        };
        let impact = match pressed(a) {
            None => at_once,
            Some(pressed) => self.contacts.impact(a, b, &pressed.law(&law)).ok()?,
        };
        let left = [Some(a), b].into_iter().flatten().zip(&impact.after);
        let left = left.map(|(side, after)| match pressed(side) {
            Some(pressed) => pressed.left(side.state, after).state,
            None => after.in_pose_of(side.state),
        });
        let left = left.collect();
        Some((impact, left))
    }

    /// Its law with free quantities taken from `parameters`.
    pub fn law(&self, parameters: &[f64]) -> Law {
        let value = |index: Option<usize>, otherwise| index.map_or(otherwise, |p| parameters[p]);
        let mut tilt_rad = self.law.tilt_rad;
        for (tangent, parameter) in &self.tilts {
            tilt_rad[*tangent] = parameters[*parameter];
        }
        Law {
            restitution: value(self.restitution_parameter, self.law.restitution),
            friction: value(self.friction_parameter, self.law.friction),
            tangential_restitution: value(
                self.tangential_parameter,
                self.law.tangential_restitution,
            ),
            tilt_rad,
        }
    }
}

/// An event at which a motion on a support or in a hand ends, or begins, without an impact.
#[derive(Clone, Debug)]
pub struct ArcChange {
    /// The event.
    pub event: usize,
    /// What moves the body before and after it; an arc at least on one side.
    pub sides: [MovedBy; 2],
    /// Whether its velocities go on, too: not where a hand takes it, or puts it down.
    pub keeps_velocities: bool,
    /// Whether friction ends the slip there.
    pub slip_ends: bool,
    /// What catches the body there: its impulse ends what of the velocities it does not allow.
    pub caught: Option<Caught>,
    /// Parameters that act on its arcs; gravity among them.
    pub acting: Vec<Acting>,
}

/// An event from which on two bodies are one.
#[derive(Clone, Debug)]
pub struct ArcSticking {
    /// The event.
    pub event: usize,
    /// The arcs of both.
    pub sides: [ArcPair; 2],
    /// A moment of inertia of both together [kg m²]: angular momenta over it are rates.
    pub per_kg_m2: f64,
    /// Parameters that act on the arcs; gravity among them.
    pub acting: Vec<Acting>,
}

/// What moves a body beside an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MovedBy {
    /// Its own motion (index into [`Problem::arcs`]).
    Arc(usize),
    /// A hand (index into [`Problem::held`]).
    Hand(usize),
}

/// What holds from the beginning of an arc where a body is on a support without an impact.
#[derive(Clone, Copy, Debug)]
pub struct ArcSupport {
    /// The arc.
    pub arc: usize,
    /// Whether its velocities follow from an event at which it was caught.
    pub is_caught: bool,
    /// Where what supports it is.
    pub at: SupportPlace,
}

/// Where in the world something supports a body.
#[derive(Clone, Copy, Debug)]
pub enum SupportPlace {
    /// On a plane.
    Plane {
        /// A point of the plane [m, world].
        point_m: Vector3<f64>,
    },
    /// At a pivot.
    Pivot {
        /// Where that is [m, world]; `None`: where the body is.
        place_m: Option<Vector3<f64>>,
        /// Along the axis about which the body turns, where there is one \[world\].
        axis: Option<Vector3<f64>>,
    },
}

/// A held body at one of its collisions, or what is in a hand where that takes it or lets go.
#[derive(Clone, Debug)]
pub struct HeldState {
    /// The event (index into `Scene::events`).
    pub event: usize,
    /// The body.
    pub link: LinkIndex,
    /// Its tracker, or that of the hand.
    pub track: TrackIndex,
    /// How that tracker moves.
    pub motion: HeldMotion,
    /// Link from tracker.
    pub mount: Pose,
    /// `c^½ L⁻¹`.
    pub root: StateCovariance,
    /// Covariance of the smoothed state, where nothing strays.
    pub covariance: StateCovariance,
    /// Whether its own tracker shows both what is held and what flies, so that a hand strays in both.
    pub strays: bool,
    /// Parameters of the tracker.
    pub acting: Vec<Acting>,
    /// The nodes of the time map about the event, where sample times are unknown.
    pub nodes: Option<[usize; 2]>,
}

/// The mark of an event whose time is an unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EventMark {
    /// Index into [`Problem::event_is_free`].
    pub event: usize,
    /// Acted time of the mark \[s\].
    pub acted_s: f64,
    /// Standard deviation with which it is weighted among the samples, in acted time \[s\].
    pub sd_s: f64,
    /// Multiplicity: the mark counts `counted` times, so that its residual has this variance.
    pub counted: f64,
    /// The nodes about the event, where sample times are unknown.
    pub nodes: Option<[usize; 2]>,
}

/// A hard condition on an arc at an event.
#[derive(Clone, Debug)]
pub struct ArcGoal {
    /// Event at which it holds.
    pub event: usize,
    /// Arc that ends there (or begins there, if none ends).
    pub arc: usize,
    /// What must hold.
    pub target: ArcTarget,
}

/// The target of a goal.
#[derive(Clone, Debug)]
pub enum ArcTarget {
    /// The pose of its link.
    Pose(Pose),
    /// One coordinate of the centre of mass within bounds \[m\].
    Coordinate {
        /// World axis.
        axis: usize,
        /// Least value.
        lower_m: f64,
        /// Greatest value.
        upper_m: f64,
    },
}

/// A bound of an event's time, at an acted time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeBound {
    /// Index into [`Problem::event_is_free`].
    pub event: usize,
    /// Which bound.
    pub side: TimeSide,
    /// The acted time at which it is \[s\].
    pub acted_s: f64,
    /// The nodes about it, where sample times are unknown.
    pub nodes: Option<[usize; 2]>,
    /// Half the time between the earliest and the latest, infinite where there is only one
    /// \[s, acted\].
    pub half_width_s: f64,
}

/// Which bound of a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeSide {
    /// No earlier.
    Earliest,
    /// No later.
    Latest,
    /// No other.
    Only,
}

/// A parameter that has bounds of its own; its unit is its prior, or the width of its bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounded {
    /// Index into [`Problem::parameters`].
    pub parameter: usize,
}

/// Two events in their order of time: of which no sample in between can tell, or a waypoint and what is
/// next to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ordered {
    /// Indices into [`Problem::event_is_free`].
    pub events: [usize; 2],
}

/// A moment of a flight at which goals hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Waypoint {
    /// Index into [`Problem::event_is_free`].
    pub event: usize,
    /// The flight (index into [`Problem::arcs`]).
    pub arc: usize,
}

/// A sample whose time is not known, no earlier than the one before it in its flight, or within the
/// flight where it is the first or the last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleOrder {
    /// Index into [`Problem::arcs`].
    pub arc: usize,
    /// What saw the sample.
    pub track: TrackIndex,
    /// The sample.
    pub sample: ArcSample,
    /// What is before or after it.
    pub beside: Beside,
}

/// What is beside a sample in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Beside {
    /// Another sample of the same track is no earlier; its time is not known either.
    Next(ArcSample),
    /// The event that begins the flight is no later.
    Begin(usize),
    /// The event that ends the flight is no earlier.
    End(usize),
}

/// Everything the solver needs, and nothing else.
#[derive(Clone, Debug)]
pub struct Problem {
    /// What flies: the body of each of the scene's mechanisms.
    pub bodies: TiVec<MechanismIndex, Body>,
    /// Gravity, where it is not free [m/s², world].
    pub gravity_m_s2: Vector3<f64>,
    /// Parameters that hold components of gravity.
    pub gravity_parameters: [Option<usize>; 3],
    /// Roles of the free parameters but gravity and laws.
    pub roles: Vec<Role>,
    /// How the trackers are mounted: link from tracker.
    pub mounts: TiVec<TrackIndex, Pose>,
    /// All arcs, in order of time.
    pub arcs: Vec<Arc>,
    /// Whether the time of each of the scene's events is an unknown.
    pub event_is_free: Vec<bool>,
    /// Acted times of the scene's events \[s\].
    pub events_acted_s: Vec<f64>,
    /// Whether start and end are where the first and the last sample are, as in an edited sketch.
    pub ends_are_samples: bool,
    /// Marks of the events whose time is an unknown.
    pub marks: Vec<EventMark>,
    /// Waypoints, in the order of the events.
    pub waypoints: Vec<Waypoint>,
    /// Collisions.
    pub collisions: Vec<ArcCollision>,
    /// Held bodies at their collisions, and what is in a hand where that takes it or lets go.
    pub held: Vec<HeldState>,
    /// Goals that are poses or coordinates.
    pub goals: Vec<ArcGoal>,
    /// All other goals.
    pub conditions: Vec<ArcCondition>,
    /// Events about flights that have few samples, and about waypoints.
    pub ordered: Vec<Ordered>,
    /// Events at which a motion on a support ends or begins without an impact.
    pub changes: Vec<ArcChange>,
    /// How uncertain it is where the stream is cut, by their event \[s\].
    pub cuts_sd_s: BTreeMap<usize, f64>,
    /// Events from which on two bodies are one.
    pub stickings: Vec<ArcSticking>,
    /// Where motions on a support begin with the performance.
    pub supports: Vec<ArcSupport>,
    /// Events between which a hand moves something.
    pub grips: Vec<[usize; 2]>,
    /// Order of samples whose times are not known.
    pub sample_orders: Vec<SampleOrder>,
    /// Bounds of events' times.
    pub time_bounds: Vec<TimeBound>,
    /// Free parameters.
    pub parameters: Vec<FreeParameter>,
    /// Parameters with bounds of their own.
    pub bounded: Vec<Bounded>,
    /// Pairs of parameters within a circle.
    pub cones: Vec<Cone>,
    /// Solids that would go into each other otherwise; none before a motion showed them.
    pub clearances: Vec<Clearance>,
    /// Weight of a squared unit of velocity gap; `None` where velocities must follow the impact
    /// law.
    pub velocity_gap_weight: Option<f64>,
    /// Acted times of the time map's nodes, distinct and increasing \[s\]: those of all samples, or
    /// of some where times are unknown and samples many.
    pub nodes_acted_s: Vec<f64>,
    /// Strength `σ` of the tempo prior [1/√s]; `None` where physical times are the acted ones.
    pub tempo_sd_per_sqrt_s: Option<f64>,
    /// How often the tempo prior counts: as often as there are samples for one, where each errs by itself.
    pub tempo_counts: f64,
    /// Whether a hand acted the performance.
    pub performer: Performer,
    /// Which samples err together; `None` where each errs by itself.
    pub weave: Option<Weave>,
    /// One unit of position residual \[m\].
    pub position_unit_m: f64,
    /// One unit of orientation residual \[rad\].
    pub orientation_unit_rad: f64,
    /// Whether flights of few samples start as guessed, and not as the impact before them hands
    /// on.
    pub keeps_starts: bool,
    /// Pulls to rest on arcs that are not seen whole.
    pub regulariser: Vec<Pull>,
    /// Temporary pulls on states of arcs.
    pub pulls: Vec<Pull>,
}

impl Problem {
    /// What flies on an arc.
    pub fn body_of(&self, arc: usize) -> &Body {
        &self.arcs[arc].body
    }

    /// Strength of the tempo prior with how often it counts, `σ/√n` [1/√s].
    pub fn counted_tempo_sd(&self) -> Option<f64> {
        let sd = self.tempo_sd_per_sqrt_s;
        sd.map(|sd| sd / self.tempo_counts.sqrt())
    }

    /// Whether sample times are unknowns.
    pub fn times_are_unknown(&self) -> bool {
        self.tempo_sd_per_sqrt_s.is_some()
    }

    /// Information of the samples of an arc, relative to 48 samples in the units of [`mod@unit`]:
    /// `(n/48)(u_constraint/u_residual)²` with `n` samples per arc, the greater of positions' and
    /// orientations'. Weights of constraints and damping are multiples of it, so that the way to
    /// the optimum depends neither on the number of samples nor on the weights' scale.
    /// One where nothing is seen of what flies.
    pub fn information(&self) -> f64 {
        let [position, orientation] = self.informations();
        let greater = position.max(orientation);
        if greater > 0.0 { greater } else { 1.0 }
    }

    /// [`Problem::information`] with the lesser of positions' and orientations', where both are seen.
    pub fn least_information(&self) -> f64 {
        let seen = self.informations().into_iter().filter(|of| *of > 0.0);
        seen.reduce(f64::min).unwrap_or(1.0)
    }

    /// Information of positions and of orientations.
    fn informations(&self) -> [f64; 2] {
        const REFERENCE_SAMPLES: f64 = 48.0;
        let units = [self.position_unit_m, self.orientation_unit_rad];
        let constraints = [unit::POSITION_M, unit::ORIENTATION_RAD];
        [0, 1].map(|kind| {
            // Samples in the scene's unit that would count as much.
            let views = self.views().map(|(_, view)| {
                let ratio = units[kind] / view.units[kind];
                ratio * ratio * view.samples.len() as f64
            });
            let per_arc = views.sum::<f64>() / self.seen_arcs().max(1) as f64;
            let ratio = constraints[kind] / units[kind];
            per_arc / REFERENCE_SAMPLES * ratio * ratio
        })
    }

    /// The problem with velocity gaps priced instead of closed (overconstrained sketches).
    pub fn with_velocity_gaps(&self) -> Self {
        Self {
            velocity_gap_weight: Some(VELOCITY_GAP_WEIGHT * self.information()),
            ..self.clone()
        }
    }

    /// The problem with velocity gaps closed.
    pub fn without_velocity_gaps(&self) -> Self {
        Self {
            velocity_gap_weight: None,
            ..self.clone()
        }
    }

    /// Whether there are more equalities than unknowns besides sample times: then, except by
    /// coincidence, no motion satisfies all of them.
    pub fn is_overconstrained(&self) -> bool {
        let collisions = self.collisions.iter().map(|collision| {
            let contacts = collision.contacts.as_slice().len();
            let states = state::DIMENSION * collision.sides.len();
            let contacts = if collision.touches_by_goal {
                0
            } else {
                contacts
            };
            states + contacts
        });
        let goals = self.goals.iter().map(|goal| match &goal.target {
            ArcTarget::Pose(_) => 6,
            ArcTarget::Coordinate {
                lower_m, upper_m, ..
            } => usize::from(lower_m == upper_m),
        });
        let free_events = self.event_is_free.iter().filter(|is_free| **is_free);
        let states = state::DIMENSION * self.arcs.len();
        let unknowns = states + free_events.count() + self.parameters.len();
        let times = self.time_bounds.iter();
        let times = times.map(|bound| usize::from(bound.side == TimeSide::Only));
        let equalities = collisions.chain(goals).chain(times).sum::<usize>();
        equalities + self.condition_equalities() > unknowns
    }

    /// Gravity with its free components taken from `parameters` [m/s², world].
    pub fn gravity(&self, parameters: &[f64]) -> Vector3<f64> {
        let mut gravity = self.gravity_m_s2;
        for axis in 0..3 {
            if let Some(index) = self.gravity_parameters[axis] {
                gravity[axis] = parameters[index];
            }
        }
        gravity
    }

    /// How long the contact of a collision lasts \[s\]: the arcs after it begin so much later; zero at other events.
    pub fn contact_s(&self, event: Option<usize>, parameters: &[f64]) -> f64 {
        let mut collisions = self.collisions.iter();
        let of = collisions.find(|of| Some(of.event) == event);
        of.and_then(|of| of.contact_s(parameters)).unwrap_or(0.0)
    }

    /// Components of gravity that are free.
    pub fn free_gravity(&self) -> impl Iterator<Item = usize> + '_ {
        (0..3).filter(|axis| self.gravity_parameters[*axis].is_some())
    }

    /// Number of arcs with samples.
    pub fn seen_arcs(&self) -> usize {
        let seen = self.arcs.iter().filter(|arc| arc.sample_count() > 0);
        seen.count()
    }

    /// All samples of all arcs.
    pub fn sample_count(&self) -> usize {
        self.arcs.iter().map(Arc::sample_count).sum()
    }

    /// All views, arc by arc, with the index of their arc.
    pub fn views(&self) -> impl Iterator<Item = (usize, &View)> + Clone {
        let arcs = self.arcs.iter().enumerate();
        arcs.flat_map(|(arc, of)| of.views.iter().map(move |view| (arc, view)))
    }

    /// The places of an arc's views among [`Problem::views`].
    pub fn views_of(&self, arc: usize) -> Range<usize> {
        let before = self.arcs[..arc].iter().map(|arc| arc.views.len());
        let first: usize = before.sum();
        first..first + self.arcs[arc].views.len()
    }
}
