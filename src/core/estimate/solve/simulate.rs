//! A motion simulated from its first states: every collision where its feature first touches after
//! the one before, with the impact law.

use crate::estimate::problem::{ArcCollision, Problem};
use crate::estimate::unknowns::point::Point;
use crate::physics::impact::{Impact, Side};
use crate::physics::{Body, State, flow};

/// Steps of the scan for a contact, in the time from the last event to this one in the motion from
/// which it starts; and how many of these times are scanned.
const STEPS: usize = 64;
const TIMES: usize = 3;
/// Greatest number of steps to a contact's time, and the gap at which it is found \[m\].
const REFINEMENTS: usize = 80;
const GAP_M: f64 = 1e-14;

/// The motion from the states of first flights in `point`; flights after collisions and the times of
/// these are replaced. `None` where a collision does not happen or has several contacts, or where
/// velocities may jump.
pub(in crate::estimate) fn simulate(
    problem: &Problem,
    epochs_s: &[f64],
    mut point: Point,
) -> Option<Point> {
    if problem.velocity_gap_weight.is_some() {
        return None;
    }
    let gravity = problem.gravity(&point.parameters);
    let known_s = point.event_times_s.clone();
    let mut collisions: Vec<&ArcCollision> = problem.collisions.iter().collect();
    collisions.sort_by_key(|of| of.event);
    for of in collisions {
        if of.contacts.as_slice().len() > 1 {
            return None;
        }
        let approach = Approach {
            problem,
            epochs_s,
            of,
            point: &point,
        };
        let from_s = approach.begins_s(&point.event_times_s);
        let lasts_s = known_s[of.event] - approach.begins_s(&known_s);
        let time_s = approach.first_touch_s(from_s, lasts_s)?;
        let (impact, left) = approach.at(time_s)?;
        if impact.speeds_m_s[0] >= 0.0 {
            return None;
        }
        point.event_times_s[of.event] = time_s;
        problem.hold(&mut point, Some(of.event));
        let left_s = time_s + of.contact_s(&point.parameters).unwrap_or(0.0);
        for (side, state) in of.sides.iter().zip(&left) {
            let body = problem.body_of(side.after);
            let since_s = epochs_s[side.after] - left_s;
            point.arcs[side.after] = flow::advance(body, &gravity, state, since_s);
        }
    }
    Some(point)
}

/// The flights before a collision.
struct Approach<'a> {
    problem: &'a Problem,
    epochs_s: &'a [f64],
    of: &'a ArcCollision,
    point: &'a Point,
}

impl Approach<'_> {
    /// When the last of the flights begins, given the times of events \[s\].
    fn begins_s(&self, event_times_s: &[f64]) -> f64 {
        let begins_s = self.of.sides.iter().map(|side| {
            let arc = &self.problem.arcs[side.before];
            let first_s = || {
                let [first, _] = arc.ends()?;
                let point = self.point;
                Some(first.stamped_s(&point.node_times_s, &point.parameters))
            };
            let event_s = arc.start.map(|event| event_times_s[event]);
            event_s.or_else(first_s).unwrap_or(f64::NAN)
        });
        begins_s.fold(f64::NEG_INFINITY, f64::max)
    }

    /// The impact, were it at a time, and the states in which it leaves the bodies.
    fn at(&self, time_s: f64) -> Option<(Impact, Vec<State>)> {
        let gravity = self.problem.gravity(&self.point.parameters);
        let states = self.of.sides.iter().map(|side| {
            let since_s = time_s - self.epochs_s[side.before];
            let state = &self.point.arcs[side.before];
            flow::advance(self.problem.body_of(side.before), &gravity, state, since_s)
        });
        let held = self.of.held.map(|held| self.held_at(held, time_s));
        let states: Vec<State> = states.chain(held).collect();
        let sides = states.iter().enumerate().map(|(index, state)| {
            let body = match self.of.sides.get(index) {
                Some(side) => self.problem.body_of(side.before),
                None => &Body::IMMOVABLE,
            };
            Side { body, state }
        });
        let sides: Vec<Side> = sides.collect();
        let sides = [sides.first(), sides.get(1)];
        self.of.struck(sides, &gravity, &self.point.parameters)
    }

    /// The smoothed state of a held body, were the collision at a time.
    fn held_at(&self, held: usize, time_s: f64) -> State {
        let mut point = self.point.clone();
        point.event_times_s[self.of.event] = time_s;
        self.problem.held[held].expected(self.problem, &point)
    }

    fn gap_m(&self, time_s: f64) -> Option<f64> {
        self.at(time_s).map(|(impact, _)| impact.gaps_m[0])
    }

    /// The first time after `from_s` at which the gap closes, by a scan, then by regula falsi in
    /// the manner of Illinois.
    fn first_touch_s(&self, from_s: f64, lasts_s: f64) -> Option<f64> {
        let step_s = lasts_s / STEPS as f64;
        if !(step_s > 0.0) {
            return None;
        }
        let mut open: Option<(f64, f64)> = None;
        for step in 1..=TIMES * STEPS {
            let time_s = from_s + step as f64 * step_s;
            let gap_m = self.gap_m(time_s)?;
            if gap_m > 0.0 {
                open = Some((time_s, gap_m));
            } else if let Some(open) = open {
                return self.closed_s(open, (time_s, gap_m));
            }
        }
        None
    }

    fn closed_s(&self, mut open: (f64, f64), mut closed: (f64, f64)) -> Option<f64> {
        let mut best = if open.1 < -closed.1 { open } else { closed };
        for _ in 0..REFINEMENTS {
            let time_s = (open.0 * closed.1 - closed.0 * open.1) / (closed.1 - open.1);
            let gap_m = self.gap_m(time_s)?;
            if gap_m.abs() < best.1.abs() || best.1.abs() <= GAP_M {
                best = (time_s, gap_m);
            }
            if gap_m.abs() <= GAP_M {
                break;
            }
            // The end that stays counts half.
            if gap_m > 0.0 {
                open = (time_s, gap_m);
                closed.1 *= 0.5;
            } else {
                closed = (time_s, gap_m);
                open.1 *= 0.5;
            }
        }
        Some(best.0)
    }
}
