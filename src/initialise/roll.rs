//! How bodies are turned about an axis that alone is seen of them.
//!
//! A flight of a body with three equal moments, turned by `φ` about the seen axis `a`
//!
//! ```text
//! R → R Exp(aφ),   ω → Exp(−aφ) ω
//! ```
//!
//! shows the same; of one with other moments that is so at half a turn about a principal axis. So a
//! flight is turned to where it goes on as the one before. Which turn is left for all flights
//! together a bounce tells: its point must reach the plane, and the change of the angular
//! velocity is that by the impulse there ([`Rebound::off_m`]).

use std::f64::consts::{PI, TAU};

use nalgebra::{UnitQuaternion, Vector3};

use super::between::is_fitted;
use super::flights::Flights;
use super::readings::Readings;
use super::rebound::Rebound;
use crate::math::so3;
use crate::motion::{GoalTarget, Guess, Mechanism, MechanismIndex, Scene, Segment};
use crate::physics::State;
use crate::physics::body::{Body, Symmetry};

/// Number of turns that are compared.
const TURNS: usize = 72;
/// Greatest number of starts.
const STARTS: usize = 2;

/// A guess with the flights of which one axis alone is seen turned about it: to go on from one to the next,
/// and all together in every way that bounces tell.
pub(super) fn guesses(
    scene: &Scene,
    segments: &[Segment],
    readings: &[Readings],
    mut guess: Guess,
) -> Vec<Guess> {
    let mut turned: Vec<(Vec<usize>, Vector3<f64>, Vec<f64>)> = Vec::new();
    for mechanism in scene.mechanisms.keys() {
        let own = (0..segments.len()).filter(|at| segments[*at].mechanism == mechanism);
        let own: Vec<usize> = own.filter(|at| is_fitted(&segments[*at])).collect();
        let Some(axis) = own.iter().find_map(|at| readings[*at].axis()) else {
            continue;
        };
        let Mechanism::Free(link) = scene.mechanisms[mechanism];
        let kind = Kind::of(&scene.links[link].body, &axis);
        if kind == Kind::Fixed || own.iter().any(|at| readings[*at].turns.is_empty()) {
            continue;
        }
        let flights = Flights {
            scene,
            segments,
            own,
        };
        // A flight whose orientation is seen tells those beside it.
        let is_whole = |at: &usize| readings[*at].axis().is_none();
        let whole = flights.own.iter().position(is_whole);
        flights.carry(&axis, kind, whole, &mut guess);
        if whole.is_none() {
            let rolls = flights.rolls(mechanism, &axis, kind, &guess);
            turned.push((flights.own, axis, rolls));
        }
    }
    let mut guesses = vec![guess];
    for (own, axis, rolls) in turned {
        let all = guesses.iter().flat_map(|guess| {
            rolls.iter().map(|roll_rad| {
                let mut guess = guess.clone();
                for at in &own {
                    roll(&mut guess.arcs[*at].state, &axis, *roll_rad);
                }
                guess
            })
        });
        guesses = all.collect();
    }
    guesses
}

/// By which turns about an axis a body's flight shows the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Any,
    Half,
    Fixed,
}

impl Kind {
    fn of(body: &Body, axis: &Vector3<f64>) -> Self {
        let share = axis.normalize().amax();
        match body.symmetry() {
            Symmetry::Spherical => Self::Any,
            _ if share > 1.0 - 1e-9 => Self::Half,
            _ => Self::Fixed,
        }
    }

    /// The allowed turn that is nearest.
    fn nearest(self, roll_rad: f64) -> f64 {
        match self {
            Self::Any => roll_rad,
            Self::Half => PI * (roll_rad / PI).round(),
            Self::Fixed => 0.0,
        }
    }
}

fn roll(state: &mut State, axis: &Vector3<f64>, roll_rad: f64) {
    let turn = so3::exp(&(axis * roll_rad));
    state.orientation *= turn;
    state.angular_velocity_rad_s = turn.inverse() * state.angular_velocity_rad_s;
}

/// The angle of the turn about an axis that brings one orientation nearest to another: its twist.
fn twist_rad(from: &UnitQuaternion<f64>, to: &UnitQuaternion<f64>, axis: &Vector3<f64>) -> f64 {
    let turn = from.inverse() * to;
    2.0 * turn.imag().dot(axis).atan2(turn.w)
}

impl Flights<'_> {
    /// Turns each flight to where it goes on as the one beside it, from the first or from one that is whole.
    fn carry(&self, axis: &Vector3<f64>, kind: Kind, whole: Option<usize>, guess: &mut Guess) {
        let from = whole.unwrap_or(0);
        let after = (from + 1..self.own.len()).map(|to| (to - 1, to));
        let before = (0..from).rev().map(|to| (to + 1, to));
        for (like, at) in after.chain(before) {
            let later = self.own[like.max(at)];
            let Some(event) = self.segments[later].start_event else {
                continue;
            };
            let time_s = guess.event_times_s[event];
            let [like, own] = [like, at].map(|at| {
                let at = self.own[at];
                self.advanced(&guess.arcs[at], at, time_s).orientation
            });
            let roll_rad = kind.nearest(twist_rad(&own, &like, axis));
            roll(&mut guess.arcs[self.own[at]].state, axis, roll_rad);
        }
    }

    /// Turns of all flights together that agree with goals and bounces, the best first.
    fn rolls(
        &self,
        mechanism: MechanismIndex,
        axis: &Vector3<f64>,
        kind: Kind,
        guess: &Guess,
    ) -> Vec<f64> {
        let told = self.told_of_roll(mechanism, guess);
        let turns = match kind {
            Kind::Any => TURNS,
            Kind::Half => 2,
            Kind::Fixed => 1,
        };
        let every_rad = TAU / turns as f64;
        if told.is_empty() {
            return vec![0.0];
        }
        let off_m2 = |turn: usize| -> f64 {
            let roll = so3::exp(&(axis * (every_rad * turn as f64)));
            told.iter().map(|told| told.off_m2(&roll)).sum()
        };
        let off_m2: Vec<f64> = (0..turns).map(off_m2).collect();
        let is_least = |turn: &usize| {
            let beside = [(turn + 1) % turns, (turn + turns - 1) % turns];
            kind == Kind::Half || beside.iter().all(|other| off_m2[*turn] <= off_m2[*other])
        };
        let mut least: Vec<usize> = (0..turns).filter(is_least).collect();
        least.sort_by(|a, b| off_m2[*a].total_cmp(&off_m2[*b]));
        let least = least.into_iter().take(STARTS);
        least.map(|turn| every_rad * turn as f64).collect()
    }

    fn told_of_roll(&self, mechanism: MechanismIndex, guess: &Guess) -> Vec<Told<'_>> {
        let Mechanism::Free(link) = self.scene.mechanisms[mechanism];
        let body = &self.scene.links[link].body;
        let goals = self.at_goals(mechanism, |target| match target {
            GoalTarget::Pose { world_from_body } => Some(world_from_body.rotation),
            _ => None,
        });
        let goals = goals.iter().filter_map(|(event, goal)| {
            let [before, after] = self.beside(*event, guess);
            Some(Told::Goal {
                goal: *goal,
                orientation: before.or(after)?.orientation,
                // The radius of gyration makes a length of an angle.
                arm_m: (body.moments_kg_m2().mean() / body.mass_kg()).sqrt(),
            })
        });
        let starts = self
            .own
            .iter()
            .filter_map(|at| self.segments[*at].start_event);
        let bounces = starts.filter_map(|event| {
            let [before, after] = self.beside(event, guess);
            Some(Told::Bounce {
                rebound: Rebound::of(self.scene, mechanism, event)?,
                states: Box::new([before?, after?]),
            })
        });
        goals.chain(bounces).collect()
    }
}

/// What tells how a body is turned about an axis.
enum Told<'a> {
    Goal {
        goal: UnitQuaternion<f64>,
        orientation: UnitQuaternion<f64>,
        arm_m: f64,
    },
    Bounce {
        rebound: Rebound<'a>,
        states: Box<[State; 2]>,
    },
}

impl Told<'_> {
    /// How far a turn is off \[m²\].
    fn off_m2(&self, roll: &UnitQuaternion<f64>) -> f64 {
        match self {
            Self::Goal {
                goal,
                orientation,
                arm_m,
            } => (arm_m * (orientation * roll).angle_to(goal)).powi(2),
            Self::Bounce { rebound, states } => {
                let rolled = states.map(|state| State {
                    orientation: state.orientation * roll,
                    angular_velocity_rad_s: roll.inverse() * state.angular_velocity_rad_s,
                    ..state
                });
                rebound.off_m(&rolled).norm_squared()
            }
        }
    }
}
