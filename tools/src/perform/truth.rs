//! True motions: bodies in free flight between collisions, to rounding.

use std::f64::consts::TAU;

use enact::math::{Pose, so3};
use enact::motion::{
    ArcEstimate, Event, EventKind, Goal, GoalTarget, LinkIndex, MechanismIndex, Moment, Scene,
};
use enact::physics::{Body, State, flow};
use nalgebra::Vector3;
use thiserror::Error;
use typed_index_collections::{TiSlice, TiVec};

use super::encounter::{Encounter, still};

/// Contacts are looked for at this spacing \[s\]: no feature of an object one throws dips under a
/// surface and comes out again within it, except to graze.
pub(super) const SCAN_S: f64 = 2.5e-4;

/// A motion that obeys physics exactly; or, where no motion can, flights through what the scene
/// wants.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// What it happens in.
    pub scene: Scene,
    /// Whether collisions change velocities as physics has it. Where they do not, no motion is
    /// true, and this one is only what the performer had in mind.
    pub is_physical: bool,
    /// True values of the scene's free parameters, in the scene's order.
    pub parameters: Vec<f64>,
    /// In order of their ends, then of mechanisms; physical time is zero at the start of the motion.
    pub arcs: Vec<ArcEstimate>,
    /// Physical time of each of the scene's events \[s\].
    pub event_times_s: Vec<f64>,
    /// Physical time of the end \[s\].
    pub duration_s: f64,
}

/// Why there is no such motion.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum TruthError {
    /// More or fewer bodies than there should be.
    #[error("the scene has {count} bodies, expected {expected}")]
    Bodies {
        /// The scene's.
        count: usize,
        /// As many as there are initial states.
        expected: usize,
    },
    /// A collision does not happen.
    #[error("event {event}: no contact between {from_s} and {to_s} s")]
    NoContact {
        /// Index into the scene's events.
        event: usize,
        /// Start of the arc \[s\].
        from_s: f64,
        /// Where the search ended \[s\].
        to_s: f64,
    },
    /// The scene is not what the style needs.
    #[error("the scene lacks {what}")]
    Lacks {
        /// What it should have.
        what: &'static str,
    },
    /// A random search found no motion.
    #[error("no motion with {count} bounces found in {tries} tries")]
    NotFound {
        /// Bounces asked for.
        count: usize,
        /// Arcs looked at.
        tries: usize,
    },
}

impl Truth {
    /// State of a link at a physical time; at the instant of a bounce, the state after it.
    ///
    /// # Panics
    /// If the link has no arc: a truth has arcs for every mechanism of its scene.
    pub fn state(&self, link: LinkIndex, time_s: f64) -> State {
        let mechanism = self.scene.mechanism_of(link);
        let mut arcs = self.arcs.iter().filter(|arc| arc.mechanism == mechanism);
        let first = arcs.next().expect("a truth has arcs for every mechanism");
        let arc = arcs
            .take_while(|arc| arc.start_s <= time_s)
            .last()
            .unwrap_or(first);
        self.flown(arc, time_s)
    }

    /// The state of a link at a side of an event.
    pub fn state_at(&self, link: LinkIndex, (event, moment): (usize, Moment)) -> State {
        let mechanism = self.scene.mechanism_of(link);
        let time_s = self.event_times_s[event];
        let arcs = self.arcs.iter().filter(|arc| arc.mechanism == mechanism);
        let has_begun = |arc: &&ArcEstimate| match moment {
            Moment::Before => arc.start_s < time_s,
            Moment::After => arc.start_s <= time_s,
        };
        let arc = arcs.clone().rfind(has_begun);
        let arc = arc.or_else(|| arcs.clone().next());
        self.flown(arc.expect("a truth has arcs for every mechanism"), time_s)
    }

    /// Where a link is at a physical time.
    pub fn world_from_body(&self, link: LinkIndex, time_s: f64) -> Pose {
        self.state(link, time_s).world_from_body()
    }

    /// The same motion with a waypoint of a link at a time: the event after the last that is not later.
    /// Returns its index too.
    pub fn with_waypoint(mut self, name: &str, link: LinkIndex, time_s: f64) -> (Self, usize) {
        let events = self.scene.events.iter().zip(&self.event_times_s);
        let earlier = events.filter(|(of, at_s)| of.kind != EventKind::End && **at_s <= time_s);
        let at = earlier.count();
        let place = |event: usize| event + usize::from(event >= at);
        for goal in &mut self.scene.goals {
            goal.place_events(place);
        }
        for free in &mut self.scene.parameters {
            free.quantity = free.quantity.at_event(place);
        }
        let waypoint = Event::new(name, EventKind::Waypoint(link));
        self.scene.events.insert(at, waypoint);
        self.event_times_s.insert(at, time_s);
        (self, at)
    }

    /// The largest miss of a pose goal, metres and radians alike.
    pub fn goal_miss(&self) -> f64 {
        let miss = |goal: &Goal| match &goal.target {
            GoalTarget::Pose { world_from_body } => {
                let pose = self.world_from_body(goal.link, self.event_times_s[goal.event]);
                let turn = world_from_body.rotation.inverse() * pose.rotation;
                let shift = pose.translation.vector - world_from_body.translation.vector;
                shift.norm().max(so3::log(&turn).norm())
            }
            GoalTarget::PositionWithin { lower_m, upper_m } => {
                let x = self
                    .state(goal.link, self.event_times_s[goal.event])
                    .position_m;
                (lower_m - x).sup(&(x - upper_m)).max().max(0.0)
            }
            GoalTarget::Condition(condition) => {
                let time_of = |event: usize| self.event_times_s.get(event).copied();
                let at = (goal.event, condition.moment);
                let state_of = |link| Some(self.state_at(link, at));
                let distance = self
                    .scene
                    .condition_distance(goal, condition, &time_of, &state_of);
                distance.map_or(f64::INFINITY, |distance| distance.max(0.0))
            }
        };
        self.scene.goals.iter().map(miss).fold(0.0, f64::max)
    }
}

/// Simulates a scene through all its collisions in the scene's order, up to `duration_s`, with
/// these values of its free parameters and one initial state per mechanism.
pub fn simulate(
    scene: &Scene,
    parameters: &[f64],
    initial: &[State],
    duration_s: f64,
) -> Result<Truth, TruthError> {
    if initial.len() != scene.mechanisms.len() {
        return Err(TruthError::Bodies {
            count: scene.mechanisms.len(),
            expected: initial.len(),
        });
    }
    let mut truth = Truth {
        scene: scene.clone(),
        is_physical: true,
        parameters: parameters.to_vec(),
        arcs: Vec::new(),
        event_times_s: Vec::new(),
        duration_s,
    };
    let mut flights: TiVec<MechanismIndex, ArcEstimate> = scene
        .mechanisms
        .keys()
        .zip(initial)
        .map(|(mechanism, state)| arc(mechanism, *state, 0.0))
        .collect();
    let mut now_s = 0.0;
    for (event, kind) in scene.events.iter().map(|event| &event.kind).enumerate() {
        now_s = match kind {
            EventKind::Start => 0.0,
            EventKind::End => duration_s,
            EventKind::Collisions { .. } => return Err(TruthError::Lacks { what: "a number" }),
            // Nothing happens there: `with_waypoint` says when it is.
            EventKind::Change(_) | EventKind::Waypoint(_) => {
                return Err(TruthError::Lacks { what: "a time" });
            }
            EventKind::Collision(_) => {
                let encounter = Encounter::of(scene, parameters, event)
                    .ok_or(TruthError::Lacks { what: "a contact" })?;
                truth.collide(&encounter, &mut flights, now_s, event)?
            }
        };
        truth.event_times_s.push(now_s);
    }
    for flight in &mut flights {
        flight.end_s = duration_s;
    }
    truth.arcs.append(flights.as_mut());
    Ok(truth)
}

/// An arc that begins, and has not ended.
pub(super) fn arc(mechanism: MechanismIndex, state: State, start_s: f64) -> ArcEstimate {
    ArcEstimate {
        mechanism,
        epoch_s: start_s,
        state,
        start_s,
        end_s: f64::INFINITY,
        support: None,
        certainty: None,
    }
}

impl Truth {
    /// Ends the flights of who meets after `from_s`, and begins the next ones. Returns when.
    fn collide(
        &mut self,
        encounter: &Encounter,
        flights: &mut TiSlice<MechanismIndex, ArcEstimate>,
        from_s: f64,
        event: usize,
    ) -> Result<f64, TruthError> {
        let states_at = |time_s: f64| {
            let flight_of = |link| &flights[self.scene.mechanism_of(link)];
            let b = encounter.other.map(|b| self.flown(flight_of(b), time_s));
            let a = self.flown(flight_of(encounter.link), time_s);
            (a, b.unwrap_or_else(still))
        };
        let flown_s = crossing_s(SCAN_S, self.duration_s - from_s, |time_s| {
            let (a, b) = states_at(from_s + time_s);
            encounter.gap_m(&a, &b)
        })
        .ok_or(TruthError::NoContact {
            event,
            from_s,
            to_s: self.duration_s,
        })?;
        let time_s = from_s + flown_s;
        let (a, b) = states_at(time_s);
        let (a, b) = encounter.after(&a, &b);
        for (link, state) in [(encounter.link, a)]
            .into_iter()
            .chain(encounter.other.map(|other| (other, b)))
        {
            let mechanism = self.scene.mechanism_of(link);
            let begun = arc(mechanism, state, time_s);
            let mut ended = std::mem::replace(&mut flights[mechanism], begun);
            ended.end_s = time_s;
            self.arcs.push(ended);
        }
        self.sort_arcs();
        Ok(time_s)
    }

    /// Adds a link's flights from pose to pose, from time zero on: durations \[s\], and whole turns
    /// beyond the least that the poses need.
    pub(super) fn fly_through(&mut self, link: LinkIndex, poses: &[Pose], flights: &[(f64, f64)]) {
        let mut start_s = 0.0;
        for (pair, (duration_s, turns)) in poses.windows(2).zip(flights) {
            let flight = Flight::of(&self.scene, link);
            let state = flight.between(&pair[0], &pair[1], *duration_s, *turns);
            let mut flown = arc(self.scene.mechanism_of(link), state, start_s);
            start_s += duration_s;
            flown.end_s = start_s;
            self.arcs.push(flown);
        }
        self.sort_arcs();
        self.duration_s = self.duration_s.max(start_s);
    }

    /// In order of ends, then of mechanisms, as segments are.
    fn sort_arcs(&mut self) {
        self.arcs.sort_by(|x, y| {
            let by_end = x.end_s.total_cmp(&y.end_s);
            by_end.then(x.mechanism.cmp(&y.mechanism))
        });
    }

    /// The state at a time on an arc or beyond.
    pub(super) fn flown(&self, arc: &ArcEstimate, time_s: f64) -> State {
        self.scene.flown(arc, &self.scene.gravity_m_s2, time_s)
    }
}

/// Free flight of one body.
#[derive(Clone, Copy)]
pub struct Flight<'a> {
    /// What flies.
    pub body: &'a Body,
    /// Gravity [m/s²].
    pub gravity_m_s2: &'a Vector3<f64>,
}

impl<'a> Flight<'a> {
    /// That link's of the scene.
    pub fn of(scene: &'a Scene, link: LinkIndex) -> Self {
        Self {
            body: &scene.links[link].body,
            gravity_m_s2: &scene.gravity_m_s2,
        }
    }

    /// The state `duration_s` later, or earlier.
    pub fn advance(&self, state: &State, duration_s: f64) -> State {
        flow::advance(self.body, self.gravity_m_s2, state, duration_s)
    }

    /// The flight from one pose to another, spinning as little as it can and `turns` whole turns
    /// more about the same axis. For bodies with three equal moments only, whose spin is steady.
    pub fn between(&self, from: &Pose, to: &Pose, duration_s: f64, turns: f64) -> State {
        let way_m = to.translation.vector - from.translation.vector;
        let turn = so3::log(&(from.rotation.inverse() * to.rotation));
        let more = turn.try_normalize(1e-9).unwrap_or_else(Vector3::z) * (TAU * turns);
        State {
            position_m: from.translation.vector,
            orientation: from.rotation,
            velocity_m_s: way_m / duration_s - self.gravity_m_s2 * (0.5 * duration_s),
            angular_velocity_rad_s: (turn + more) / duration_s,
        }
    }
}

/// First time at which a gap goes from positive to not positive, by scan and bisection.
pub(super) fn crossing_s(scan_s: f64, limit_s: f64, gap_m: impl Fn(f64) -> f64) -> Option<f64> {
    let steps = (limit_s / scan_s).ceil() as usize;
    let (mut low_s, mut outside) = (0.0, false);
    for step in 1..=steps {
        let time_s = (step as f64 * scan_s).min(limit_s);
        let is_outside = gap_m(time_s) > 0.0;
        if outside && !is_outside {
            return Some(bisect(low_s, time_s, &gap_m));
        }
        (low_s, outside) = (time_s, is_outside);
    }
    None
}

/// Root of a gap that is positive at `low_s` and not at `high_s`: the neighbour with the smaller
/// gap of the last two floating-point numbers.
fn bisect(mut low_s: f64, mut high_s: f64, gap_m: &impl Fn(f64) -> f64) -> f64 {
    loop {
        let middle_s = 0.5 * (low_s + high_s);
        if middle_s <= low_s || middle_s >= high_s {
            let nearer = gap_m(low_s).abs() < gap_m(high_s).abs();
            return if nearer { low_s } else { high_s };
        }
        if gap_m(middle_s) > 0.0 {
            low_s = middle_s;
        } else {
            high_s = middle_s;
        }
    }
}
