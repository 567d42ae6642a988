//! What follows from what is held: times of collisions, found as roots, and states after them.

use enact::estimate::problem::{ArcCollision, Problem, unit};
use enact::estimate::unknowns::point::Point;
use enact::physics::impact::{self, Impact};
use enact::physics::state::StateTangent;
use enact::physics::{State, flow};

use super::columns::{Columns, GAP};
use super::split::{Grid, Split};

/// Units of a state's tangent, as the program's.
pub fn units() -> StateTangent {
    let (x, r) = (unit::POSITION_M, unit::ORIENTATION_RAD);
    let (v, w) = (unit::VELOCITY_M_S, unit::ANGULAR_VELOCITY_RAD_S);
    StateTangent::from_column_slice(&[x, x, x, r, r, r, v, v, v, w, w, w])
}

/// Newton steps at most, and how far one may go \[s\].
const STEPS: usize = 12;
const STEP_MAX_S: f64 = 0.03;
/// A root is found when the next step is shorter than this \[s\].
const EXACT_S: f64 = 1e-14;
/// Spacing and reach of the search where Newton's method finds no approach \[s\].
const SCAN_S: f64 = 8e-3;
const SCANS: usize = 40;

/// Fills times and states that follow, beginning the search for each root at the point's own time;
/// `gaps` are velocities that jump beyond the impacts. `None` where a contact is never made.
pub fn simulate(
    split: &Split,
    columns: &Columns,
    grid: Grid,
    point: &mut Point,
    gaps: &[[StateTangent; 2]],
) -> Option<()> {
    let problem = &split.problem;
    let gravity = problem.gravity(&point.parameters);
    for (index, collision) in problem.collisions.iter().enumerate() {
        if columns.times_follow[index] {
            let near_s = point.event_times_s[collision.event];
            let gap = |time_s: f64| {
                let impact = at(split, collision, point, time_s)?.1;
                Some((impact.gaps_m[0], impact.speeds_m_s[0]))
            };
            point.event_times_s[collision.event] = root_s(&gap, near_s)?;
        }
        if !grid.shoots() {
            continue;
        }
        let time_s = point.event_times_s[collision.event];
        let (arriving, impact) = at(split, collision, point, time_s)?;
        for (body, side) in collision.sides.iter().enumerate() {
            let after = &impact.after[body];
            let bounced = State {
                velocity_m_s: after.velocity_m_s,
                angular_velocity_rad_s: after.angular_velocity_rad_s,
                ..arriving[body]
            };
            let jumped = bounced.retract(&gaps[index][body].component_mul(&units()));
            let lasts_s = split.epochs_s[side.after] - time_s;
            let body = &problem.bodies[side.mechanism];
            point.arcs[side.after] = flow::advance(body, &gravity, &jumped, lasts_s);
        }
    }
    let is_finite = point.arcs.iter().all(State::is_finite);
    is_finite.then_some(())
}

/// Gaps in the velocities that the point has beyond its impacts, in units.
pub fn gaps(problem: &Problem, split: &Split, point: &Point) -> Vec<[StateTangent; 2]> {
    let gravity = problem.gravity(&point.parameters);
    let of = |collision: &ArcCollision| {
        let mut gaps = [StateTangent::zeros(); 2];
        let time_s = point.event_times_s[collision.event];
        let Some((_, impact)) = at(split, collision, point, time_s) else {
            return gaps;
        };
        for (body, side) in collision.sides.iter().enumerate() {
            let past_s = time_s - split.epochs_s[side.after];
            let flies = &problem.bodies[side.mechanism];
            let after = flow::advance(flies, &gravity, &point.arcs[side.after], past_s);
            let bounced = State {
                velocity_m_s: impact.after[body].velocity_m_s,
                angular_velocity_rad_s: impact.after[body].angular_velocity_rad_s,
                ..after
            };
            gaps[body] = after.minus(&bounced).component_div(&units());
            gaps[body].rows_mut(0, GAP).fill(0.0);
        }
        gaps
    };
    problem.collisions.iter().map(of).collect()
}

/// States of the bodies of a collision at a time, and their impact then.
fn at(
    split: &Split,
    collision: &ArcCollision,
    point: &Point,
    time_s: f64,
) -> Option<([State; 2], Impact)> {
    let problem = &split.problem;
    let gravity = problem.gravity(&point.parameters);
    let arriving = |side: &enact::estimate::problem::ArcPair| {
        let body = &problem.bodies[side.mechanism];
        let past_s = time_s - split.epochs_s[side.before];
        flow::advance(body, &gravity, &point.arcs[side.before], past_s)
    };
    let first = arriving(&collision.sides[0]);
    let second = collision.sides.get(1).map(arriving);
    let side = |side: usize, state| {
        let body = &problem.bodies[collision.sides[side].mechanism];
        impact::Side { body, state }
    };
    let law = collision.law(&point.parameters);
    let (a, b) = (side(0, &first), second.as_ref().map(|state| side(1, state)));
    let impact = collision.contacts.impact(&a, b.as_ref(), &law).ok()?;
    Some(([first, second.unwrap_or(first)], impact))
}

/// The time at which a gap closes, by Newton's method from a time nearby; else the closing nearest
/// to it.
pub fn root_s(gap: &impl Fn(f64) -> Option<(f64, f64)>, near_s: f64) -> Option<f64> {
    newton_s(gap, near_s).or_else(|| {
        let (low, high) = bracket_s(gap, near_s)?;
        bisected_s(gap, low, high)
    })
}

fn newton_s(gap: &impl Fn(f64) -> Option<(f64, f64)>, near_s: f64) -> Option<f64> {
    let mut time_s = near_s;
    for _ in 0..STEPS {
        let (gap_m, speed_m_s) = gap(time_s)?;
        if !(speed_m_s < 0.0) {
            return None;
        }
        let step_s = -gap_m / speed_m_s;
        time_s += step_s.clamp(-STEP_MAX_S, STEP_MAX_S);
        if step_s.abs() < EXACT_S {
            return Some(time_s);
        }
    }
    // Rounding of a large gap's parts may keep the step from becoming that short.
    let (gap_m, speed_m_s) = gap(time_s)?;
    (speed_m_s < 0.0 && gap_m.abs() < 1e-12).then_some(time_s)
}

/// The nearest stretch within which the gap closes \[s\].
fn bracket_s(gap: &impl Fn(f64) -> Option<(f64, f64)>, near_s: f64) -> Option<(f64, f64)> {
    let closes = |low: f64| {
        let high = low + SCAN_S;
        let (before, after) = (gap(low)?.0, gap(high)?.0);
        (before > 0.0 && after <= 0.0).then_some((low, high))
    };
    (0..SCANS).find_map(|scan| {
        let away_s = scan as f64 * SCAN_S;
        closes(near_s + away_s).or_else(|| closes(near_s - away_s - SCAN_S))
    })
}

/// The root within a bracket: halvings, then Newton's method.
fn bisected_s(
    gap: &impl Fn(f64) -> Option<(f64, f64)>,
    mut low: f64,
    mut high: f64,
) -> Option<f64> {
    loop {
        let middle = 0.5 * (low + high);
        if let Some(root_s) = newton_s(gap, middle).filter(|t| low <= *t && *t <= high) {
            return Some(root_s);
        }
        if middle <= low || middle >= high {
            return None;
        }
        if gap(middle)?.0 > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
}
