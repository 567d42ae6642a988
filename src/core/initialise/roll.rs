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
use crate::motion::{GoalTarget, Guess, MechanismIndex, Scene, Segment};
use crate::physics::body::Symmetry;
use crate::physics::{Body, State};

/// Number of turns that are compared.
const TURNS: usize = 72;
/// Greatest number of starts: a bounce tells up to two turns.
const STARTS: usize = 2;

/// Guesses with the flights of which one axis alone is seen turned about it: to go on from one to the next,
/// and all together as bounces tell. Of all ways to fit and to turn them those that go together best.
pub(super) fn guesses(
    scene: &Scene,
    segments: &[Segment],
    readings: &[Readings],
    guesses: Vec<Guess>,
) -> Vec<Guess> {
    let mut pointing: Vec<Pointing<'_>> = Vec::new();
    for mechanism in scene.mechanisms.keys() {
        let own = (0..segments.len()).filter(|at| segments[*at].mechanism == mechanism);
        let own: Vec<usize> = own.filter(|at| is_fitted(&segments[*at])).collect();
        let Some(axis) = own.iter().find_map(|at| readings[*at].axis()) else {
            continue;
        };
        if own.iter().any(|at| readings[*at].turns.is_empty()) {
            continue;
        }
        let link = scene.free_link(mechanism);
        let body = &scene.links[link].body;
        pointing.push(Pointing {
            mechanism,
            body,
            axis,
            alike: Alike::of(body, &axis),
            whole: own.iter().position(|at| readings[*at].axis().is_none()),
            flights: Flights {
                scene,
                segments,
                own,
            },
        });
    }
    if pointing.is_empty() {
        return guesses;
    }
    let mut all: Vec<(f64, Guess)> = Vec::new();
    for guess in guesses {
        let mut turned = vec![(0.0, guess)];
        for of in &pointing {
            let further = turned.into_iter().flat_map(|(off_m2, guess)| {
                let own = of.turned(guess).into_iter();
                own.map(move |(more_m2, guess)| (off_m2 + more_m2, guess))
            });
            turned = further.collect();
        }
        all.extend(turned);
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.truncate(STARTS);
    all.into_iter().map(|(_, guess)| guess).collect()
}

/// By which turns about an axis a body's flight shows the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Alike {
    Any,
    Half,
    Never,
}

impl Alike {
    fn of(body: &Body, axis: &Vector3<f64>) -> Self {
        let share = axis.normalize().amax();
        match body.symmetry() {
            Symmetry::Spherical => Self::Any,
            _ if share > 1.0 - 1e-9 => Self::Half,
            _ => Self::Never,
        }
    }

    /// The allowed turn that is nearest.
    fn nearest(self, roll_rad: f64) -> f64 {
        match self {
            Self::Any => roll_rad,
            Self::Half => PI * (roll_rad / PI).round(),
            Self::Never => 0.0,
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

/// A mechanism of which some flights show one axis alone.
struct Pointing<'a> {
    mechanism: MechanismIndex,
    body: &'a Body,
    axis: Vector3<f64>,
    alike: Alike,
    /// A flight whose orientation is seen, which tells those beside it; its place among the flights.
    whole: Option<usize>,
    flights: Flights<'a>,
}

impl Pointing<'_> {
    /// The flights turned to go on from one to the next, in every way that is told, each with how far it is
    /// off \[m²\].
    fn turned(&self, mut guess: Guess) -> Vec<(f64, Guess)> {
        self.carry(&mut guess);
        let apart_m2 = self.apart_m2(&guess);
        let told = self.told(&guess);
        let turns = match self.alike {
            _ if told.is_empty() || self.whole.is_some() => 1,
            Alike::Any => TURNS,
            Alike::Half => 2,
            Alike::Never => 1,
        };
        let every_rad = TAU / turns as f64;
        let off_m2 = |turn: usize| -> f64 {
            let roll = so3::exp(&(self.axis * (every_rad * turn as f64)));
            told.iter().map(|told| told.off_m2(&roll)).sum()
        };
        let off_m2: Vec<f64> = (0..turns).map(off_m2).collect();
        let is_least = |turn: &usize| {
            let beside = [(turn + 1) % turns, (turn + turns - 1) % turns];
            turns <= 2 || beside.iter().all(|other| off_m2[*turn] <= off_m2[*other])
        };
        let least = (0..turns).filter(is_least);
        let turned = least.map(|turn| {
            let mut guess = guess.clone();
            for at in &self.flights.own {
                let state = &mut guess.arcs[*at].state;
                roll(state, &self.axis, every_rad * turn as f64);
            }
            (apart_m2 + off_m2[turn], guess)
        });
        turned.collect()
    }

    /// Turns each flight to where it goes on as the one beside it, from the first or from one that is whole.
    fn carry(&self, guess: &mut Guess) {
        let own = &self.flights.own;
        let from = self.whole.unwrap_or(0);
        let after = (from + 1..own.len()).map(|to| (to - 1, to));
        let before = (0..from).rev().map(|to| (to + 1, to));
        for (like, at) in after.chain(before) {
            if let Some([like, turned]) = self.orientations([own[like], own[at]], guess) {
                let roll_rad = self.alike.nearest(twist_rad(&turned, &like, &self.axis));
                roll(&mut guess.arcs[own[at]].state, &self.axis, roll_rad);
            }
        }
    }

    /// Orientations of two neighbours where the later one begins.
    fn orientations(&self, pair: [usize; 2], guess: &Guess) -> Option<[UnitQuaternion<f64>; 2]> {
        let later = pair[0].max(pair[1]);
        let event = self.flights.segments[later].start_event?;
        let time_s = guess.event_times_s[event];
        let at = |at: usize| self.flights.advanced(&guess.arcs[at], at, time_s);
        Some(pair.map(|flight| at(flight).orientation))
    }

    /// How far flights are turned from those before them \[m²\].
    fn apart_m2(&self, guess: &Guess) -> f64 {
        let pairs = self.flights.own.windows(2);
        let turned = pairs.filter_map(|pair| self.orientations([pair[0], pair[1]], guess));
        let apart_m2 = turned.map(|[from, to]| (self.arm_m() * from.angle_to(&to)).powi(2));
        apart_m2.sum()
    }

    /// The radius of gyration, which makes a length of an angle.
    fn arm_m(&self) -> f64 {
        self.body.gyration_m2().mean().sqrt()
    }

    fn told(&self, guess: &Guess) -> Vec<ToldRoll<'_>> {
        let Flights {
            scene,
            segments,
            own,
        } = &self.flights;
        let goals = self
            .flights
            .at_goals(self.mechanism, |target| match target {
                GoalTarget::Pose { world_from_body } => Some(world_from_body.rotation),
                _ => None,
            });
        let goals = goals.iter().filter_map(|(event, goal)| {
            let [before, after] = self.flights.beside(*event, guess);
            Some(ToldRoll::Goal {
                goal: *goal,
                orientation: before.or(after)?.orientation,
                arm_m: self.arm_m(),
            })
        });
        let starts = own.iter().filter_map(|at| segments[*at].start_event);
        let bounces = starts.filter_map(|event| {
            let [before, after] = self.flights.beside(event, guess);
            Some(ToldRoll::Bounce {
                rebound: Rebound::of(scene, self.mechanism, event)?,
                states: Box::new([before?, after?]),
            })
        });
        goals.chain(bounces).collect()
    }
}

/// What tells how a body is turned about an axis.
enum ToldRoll<'a> {
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

impl ToldRoll<'_> {
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

#[cfg(test)]
mod tests;
