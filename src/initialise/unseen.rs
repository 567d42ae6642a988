//! First guesses of what no track shows of a flight: its rotation, or its path.
//!
//! Goals and the flights beside it say how it begins and ends; where neither does, it ends as the nearest
//! event that is known, and a point that touches a plane is turned as little as lets it reach it. Between
//! both ends it turns at a constant rate by the shortest way, and falls: the least motion, since no
//! performance tells a larger one.

use std::collections::BTreeMap;

use nalgebra::{UnitQuaternion, Vector3};

use super::between::is_fitted;
use super::readings::Readings;
use crate::math::so3;
use crate::motion::{
    ArcGuess, GoalTarget, Guess, Mechanism, MechanismIndex, Partner, Scene, Segment,
};
use crate::physics::contact::Feature;
use crate::physics::{Dynamics, State};

/// Places and orientations at events.
type Known<T> = BTreeMap<usize, T>;

/// Sets what is not seen of the fitted flights in a guess.
pub(super) fn fill(scene: &Scene, segments: &[Segment], readings: &[Readings], guess: &mut Guess) {
    for mechanism in scene.mechanisms.keys() {
        let own = (0..segments.len()).filter(|at| segments[*at].mechanism == mechanism);
        let own: Vec<usize> = own.filter(|at| is_fitted(&segments[*at])).collect();
        let of = Flights {
            scene,
            segments,
            own: &own,
        };
        let is_placed = |at: &usize| !readings[*at].places.is_empty();
        let is_turned =
            |at: &usize| !readings[*at].turns.is_empty() || readings[*at].lever_m.is_some();
        if !own.iter().all(is_placed) {
            of.place(mechanism, is_placed, guess);
        }
        if !own.iter().all(is_turned) {
            of.turn(mechanism, is_turned, guess);
        }
    }
}

/// The fitted flights of one mechanism, in order of time.
struct Flights<'a> {
    scene: &'a Scene,
    segments: &'a [Segment],
    own: &'a [usize],
}

impl Flights<'_> {
    fn place(
        &self,
        mechanism: MechanismIndex,
        is_placed: impl Fn(&usize) -> bool,
        guess: &mut Guess,
    ) {
        let mut known = self.at_goals(mechanism, |target| match target {
            GoalTarget::Pose { world_from_body } => Some(world_from_body.translation.vector),
            _ => None,
        });
        self.at_ends(&mut known, &is_placed, guess, |state| state.position_m);
        let pull_m_s2 = self.pull_m_s2(mechanism);
        for at in self.own.iter().filter(|at| !is_placed(at)) {
            let [start, end] = self.ends_s(*at, guess);
            let [from_m, to_m] = self.ends_of(*at).map(|event| nearest(&known, event));
            let from_m = from_m.or(to_m).unwrap_or_default();
            let to_m = to_m.unwrap_or(from_m);
            let lasts_s = (end - start).max(1e-3);
            let arc = &mut guess.arcs[*at];
            let since_s = arc.epoch_s - start;
            let velocity_m_s = (to_m - from_m) / lasts_s - pull_m_s2 * (0.5 * lasts_s);
            arc.state.position_m =
                from_m + velocity_m_s * since_s + pull_m_s2 * (0.5 * since_s * since_s);
            arc.state.velocity_m_s = velocity_m_s + pull_m_s2 * since_s;
        }
    }

    fn turn(
        &self,
        mechanism: MechanismIndex,
        is_turned: impl Fn(&usize) -> bool,
        guess: &mut Guess,
    ) {
        let mut known = self.at_goals(mechanism, |target| match target {
            GoalTarget::Pose { world_from_body } => Some(world_from_body.rotation),
            _ => None,
        });
        self.at_ends(&mut known, &is_turned, guess, |state| state.orientation);
        let events = self.own.iter().flat_map(|at| self.ends_of(*at)).flatten();
        let open: Vec<usize> = events.filter(|event| !known.contains_key(event)).collect();
        let touching = open.into_iter().map(|event| {
            let like = nearest(&known, Some(event)).unwrap_or_default();
            let centre_m = self.centre_m(event, guess);
            (event, self.touching(event, mechanism, (centre_m, like)))
        });
        let touching: Vec<(usize, UnitQuaternion<f64>)> = touching.collect();
        known.extend(touching);
        for at in self.own.iter().filter(|at| !is_turned(at)) {
            let [start_s, end_s] = self.ends_s(*at, guess);
            let [from, to] = self.ends_of(*at).map(|event| nearest(&known, event));
            let from = from.or(to).unwrap_or_default();
            let to = to.unwrap_or(from);
            let rate_rad_s = so3::log(&(from.inverse() * to)) / (end_s - start_s).max(1e-3);
            let arc = &mut guess.arcs[*at];
            let since_s = arc.epoch_s - start_s;
            arc.state.orientation = from * so3::exp(&(rate_rad_s * since_s));
            arc.state.angular_velocity_rad_s = rate_rad_s;
        }
    }

    fn at_goals<T>(
        &self,
        mechanism: MechanismIndex,
        of: impl Fn(&GoalTarget) -> Option<T>,
    ) -> Known<T> {
        let goals = self.scene.goals.iter();
        let own = goals.filter(|goal| self.scene.mechanism_of(goal.link) == mechanism);
        own.filter_map(|goal| Some((goal.event, of(&goal.target)?)))
            .collect()
    }

    /// Adds what flights that are seen have at their ends.
    fn at_ends<T>(
        &self,
        known: &mut Known<T>,
        is_seen: impl Fn(&usize) -> bool,
        guess: &Guess,
        of: impl Fn(State) -> T,
    ) {
        for at in self.own.iter().filter(|at| is_seen(at)) {
            for event in self.ends_of(*at).into_iter().flatten() {
                let state = self.advanced(&guess.arcs[*at], *at, guess.event_times_s[event]);
                known.entry(event).or_insert_with(|| of(state));
            }
        }
    }

    fn ends_of(&self, at: usize) -> [Option<usize>; 2] {
        [self.segments[at].start_event, self.segments[at].end_event]
    }

    /// Times of the beginning and the end of a flight, of its first and last sample where no event
    /// is \[s\].
    fn ends_s(&self, at: usize, guess: &Guess) -> [f64; 2] {
        let times_s = &guess.arcs[at].sample_times_s;
        let first_s = times_s.iter().copied().fold(f64::INFINITY, f64::min);
        let last_s = times_s.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let [start, end] = self.ends_of(at);
        let of = |event: Option<usize>, otherwise_s| {
            event.map_or(otherwise_s, |event| guess.event_times_s[event])
        };
        [of(start, first_s), of(end, last_s)]
    }

    /// Where the centre of mass is at an event, by the flight before it or after it [m, world].
    fn centre_m(&self, event: usize, guess: &Guess) -> Vector3<f64> {
        let has = |at: &&usize| self.ends_of(**at).contains(&Some(event));
        let at = self.own.iter().find(has).expect("the event ends a flight");
        let state = self.advanced(&guess.arcs[*at], *at, guess.event_times_s[event]);
        state.position_m
    }

    fn advanced(&self, arc: &ArcGuess, at: usize, time_s: f64) -> State {
        let dynamics = self.scene.dynamics(self.segments[at].mechanism);
        dynamics.advance(&self.scene.gravity_m_s2, &arc.state, time_s - arc.epoch_s)
    }

    fn pull_m_s2(&self, mechanism: MechanismIndex) -> Vector3<f64> {
        let Dynamics::Free(body) = self.scene.dynamics(mechanism);
        body.pull_m_s2(&self.scene.gravity_m_s2)
    }

    /// The orientation nearest to a given one in which the feature that touches a plane at an event
    /// reaches it, or comes nearest to it.
    fn touching(
        &self,
        event: usize,
        mechanism: MechanismIndex,
        (centre_m, like): (Vector3<f64>, UnitQuaternion<f64>),
    ) -> UnitQuaternion<f64> {
        let collision = self.scene.events[event].kind.collision();
        let touches = collision.and_then(|collision| {
            let Mechanism::Free(link) = self.scene.mechanisms[mechanism];
            let [touching] = collision.contacts.as_slice() else {
                return None;
            };
            let is_own = collision.partner == Partner::World && collision.link == link;
            let plane = self.scene.surfaces[touching.other.filter(|_| is_own)?].plane()?;
            let feature = self.scene.links[link].features[touching.feature?].geometry;
            let Feature::Point { point_m, radius_m } = feature else {
                return None;
            };
            Some((point_m, radius_m, plane))
        });
        let Some((point_m, radius_m, (plane_m, normal))) = touches else {
            return like;
        };
        let arm_m = point_m.norm();
        let lever = like * point_m;
        if arm_m == 0.0 {
            return like;
        }
        let height = (radius_m - normal.dot(&(centre_m - plane_m))) / arm_m;
        let height = height.clamp(-1.0, 1.0);
        let level = lever - normal * normal.dot(&lever);
        let level = level
            .try_normalize(1e-9 * arm_m)
            .unwrap_or_else(|| Feature::tangents(&normal)[0]);
        let there = normal * height + level * (1.0 - height * height).sqrt();
        UnitQuaternion::rotation_between(&lever, &there).map_or(like, |turn| turn * like)
    }
}

/// What is known at an event, or at the nearest one.
fn nearest<T: Copy>(known: &Known<T>, event: Option<usize>) -> Option<T> {
    let event = event?;
    let nearest = known.iter().min_by_key(|(other, _)| other.abs_diff(event));
    nearest.map(|(_, of)| *of)
}
