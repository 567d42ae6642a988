//! Arc fits that touch where they are said to: what methods need that find contacts as roots.
//!
//! By themselves the fits of distorted flights may pass a surface by, or close its gap a turn too
//! early. There the fit is moved along the contact's normal so that it touches at the event's time,
//! approaching: the least that lets such a method begin.

use enact::estimate::problem::{ArcCollision, Problem};
use enact::estimate::unknowns::point::Point;
use enact::motion::Guess;
use enact::physics::impact::{self, ImpactDerivative};
use enact::physics::state::part;
use enact::physics::{State, flow};
use nalgebra::Vector3;

use super::simulate::root_s;

/// A contact this far from its event's time is another one \[s\].
const FAR_S: f64 = 0.04;
/// A contact approaches at least this fast [m/s].
const APPROACH_M_S: f64 = 0.1;

/// A contact as a flight has it.
struct Contact {
    gap_m: f64,
    speed_m_s: f64,
    /// Change of the gap by the first body's position.
    normal: Vector3<f64>,
}

/// The point with the flights before collisions moved where they do not touch in time.
pub fn touching(problem: &Problem, guess: &Guess, mut fits: Point) -> Point {
    let gravity = problem.gravity(&fits.parameters);
    for collision in problem.collisions.iter().filter(|c| !c.touches_by_goal) {
        let mark_s = fits.event_times_s[collision.event];
        let gap = |time_s: f64| {
            let at = contact(problem, guess, &fits, collision, time_s)?;
            Some((at.gap_m, at.speed_m_s))
        };
        let touches = |root_s: f64| (root_s - mark_s).abs() < FAR_S;
        if root_s(&gap, mark_s).is_some_and(touches) {
            continue;
        }
        let Some(at) = contact(problem, guess, &fits, collision, mark_s) else {
            continue;
        };
        let side = &collision.sides[0];
        let past_s = mark_s - guess.arcs[side.before].epoch_s;
        let body = &problem.bodies[side.mechanism];
        let then = flow::advance(body, &gravity, &fits.arcs[side.before], past_s);
        let faster_m_s = at.speed_m_s.min(-APPROACH_M_S) - at.speed_m_s;
        let moved = State {
            position_m: then.position_m - at.normal * at.gap_m,
            velocity_m_s: then.velocity_m_s + at.normal * faster_m_s,
            ..then
        };
        fits.arcs[side.before] = flow::advance(body, &gravity, &moved, -past_s);
    }
    fits
}

fn contact(
    problem: &Problem,
    guess: &Guess,
    fits: &Point,
    collision: &ArcCollision,
    time_s: f64,
) -> Option<Contact> {
    let gravity = problem.gravity(&fits.parameters);
    let states = collision.sides.iter().map(|side| {
        let past_s = time_s - guess.arcs[side.before].epoch_s;
        let body = &problem.bodies[side.mechanism];
        flow::advance(body, &gravity, &fits.arcs[side.before], past_s)
    });
    let states: Vec<State> = states.collect();
    let side = |side: usize| {
        let body = &problem.bodies[collision.sides[side].mechanism];
        let state = &states[side];
        impact::Side { body, state }
    };
    let b = (states.len() > 1).then(|| side(1));
    let law = collision.law(&fits.parameters);
    let mut by = ImpactDerivative::default();
    let impact = collision
        .contacts
        .derivative(&side(0), b.as_ref(), &law, &mut by)
        .ok()?;
    let normal = by.gap[0][0].fixed_columns::<3>(part::POSITION).transpose();
    Some(Contact {
        gap_m: impact.gaps_m[0],
        speed_m_s: impact.speeds_m_s[0],
        normal,
    })
}
