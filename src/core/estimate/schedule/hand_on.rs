//! Initial states of flights that few samples inform: the impact before one hands its state on.
//!
//! The arcs' fits say little of a flight of a few samples, and nothing of one without any. The state
//! in which the arc before arrives, and the law of impact, say all of it.

use crate::estimate::problem::{ArcCollision, Problem};
use crate::estimate::unknowns::point::Point;
use crate::physics::impact::Side;
use crate::physics::{Body, State, flow};

/// Sets the states of arcs with few samples, in order of time, to those after the impacts with which
/// they begin. Those whose contact recedes, or is degenerate, stay.
pub fn hand_on(problem: &Problem, epochs_s: &[f64], point: &mut Point) {
    if problem.keeps_starts {
        return;
    }
    for collision in &problem.collisions {
        let few = |arc: usize| !problem.arcs[arc].is_informed();
        if collision.sides.iter().any(|side| few(side.after))
            && let Some(after) = after(problem, collision, epochs_s, point)
        {
            for (side, state) in collision.sides.iter().zip(after) {
                if few(side.after) {
                    let contact_s = collision.contact_s(&point.parameters);
                    let left_s = point.event_times_s[collision.event] + contact_s.unwrap_or(0.0);
                    let since_s = epochs_s[side.after] - left_s;
                    let gravity = problem.gravity(&point.parameters);
                    let body = problem.body_of(side.after);
                    point.arcs[side.after] = flow::advance(body, &gravity, &state, since_s);
                }
            }
        }
    }
}

/// States of the bodies just after a collision.
fn after(
    problem: &Problem,
    collision: &ArcCollision,
    epochs_s: &[f64],
    point: &Point,
) -> Option<Vec<State>> {
    let time_s = point.event_times_s[collision.event];
    let gravity = problem.gravity(&point.parameters);
    let arrive = |arc: usize| {
        let body = problem.body_of(arc);
        flow::advance(body, &gravity, &point.arcs[arc], time_s - epochs_s[arc])
    };
    let sides = collision.sides.iter();
    let before = sides.map(|side| arrive(side.before));
    let held = collision.held.map(|held| point.held[held]);
    let before: Vec<State> = before.chain(held).collect();
    let side = |index: usize| {
        let state = before.get(index)?;
        let body = match collision.sides.get(index) {
            Some(side) => problem.body_of(side.before),
            None => &Body::IMMOVABLE,
        };
        Some(Side { body, state })
    };
    let (a, b) = (side(0), side(1));
    let sides = [a.as_ref(), b.as_ref()];
    let (impact, left) = collision.struck(sides, &gravity, &point.parameters)?;
    let contacts = collision.contacts.as_slice().len();
    let approaches = impact.speeds_m_s[..contacts]
        .iter()
        .all(|speed| *speed < 0.0);
    approaches.then_some(left)
}
