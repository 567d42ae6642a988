//! Hard conditions as rows `lower ≤ v ≤ upper` in the units of [`mod@unit`]: goals (paper §3.1),
//! bounds and cones of parameters. The rows of collisions are in [`super::collision`]; what a row
//! is, in [`super::block`].

use super::arc_end::ArcEnd;
use super::block::{Block, BlockPattern};
use super::layout::Layout;
use super::point::Point;
use super::problem::{ArcGoal, ArcTarget, Problem, unit};
use crate::math::so3;
use crate::motion::{Cone, FreeParameter, Gap};
use crate::physics::state::part;

/// What the rows of a goal touch: position and velocity along an axis, row by row, and for a pose
/// orientation and angular velocity; the event's time, where that is free; gravity.
pub fn goal_pattern(problem: &Problem, layout: &Layout, goal: &ArcGoal) -> BlockPattern {
    let state = layout.arcs[goal.arc];
    let time = layout.events[goal.event];
    let mut pattern = BlockPattern::default();
    let mut push_position = |axis: usize| {
        let state = [state + part::POSITION + axis, state + part::VELOCITY + axis];
        let gravity = problem.gravity_parameters[axis].map(|p| layout.parameters[p]);
        pattern.push(1, state.into_iter().chain(time).chain(gravity));
    };
    match &goal.target {
        ArcTarget::Pose(_) => {
            (0..3).for_each(&mut push_position);
            let turn = [part::ORIENTATION, part::ANGULAR_VELOCITY];
            let turn = turn.map(|part| state + part..state + part + 3);
            pattern.push(3, turn.into_iter().flatten().chain(time));
        }
        ArcTarget::Coordinate { axis, .. } => push_position(*axis),
    }
    pattern
}

/// Fills `block` with the rows of a goal.
pub fn goal(
    problem: &Problem,
    goal: &ArcGoal,
    point: &Point,
    epochs_s: &[f64],
    (pattern, block): (&BlockPattern, &mut Block),
) {
    let body = &problem.bodies[problem.arcs[goal.arc].body];
    let gravity = problem.gravity(&point.parameters);
    let flight = (&point.arcs[goal.arc], epochs_s[goal.arc]);
    let time_s = point.event_times_s[goal.event];
    let arrival = ArcEnd::new(body, &gravity, flight, time_s);
    block.reset(pattern);
    // What is there besides the state: time, then gravity.
    let time = usize::from(problem.event_is_free[goal.event]);
    let mut fill_position = |row: usize, axis: usize, offset_m: f64| {
        block.values[row] = offset_m / unit::POSITION_M;
        let s = arrival.duration_s;
        let by = block.derivatives_mut(pattern, row);
        let rest = [arrival.rate[part::POSITION + axis], 0.5 * s * s];
        by[..2].copy_from_slice(&[1.0, s]);
        let count = by.len() - 2;
        by[2..].copy_from_slice(&rest[1 - time..][..count]);
        by.iter_mut().for_each(|by| *by /= unit::POSITION_M);
    };
    match &goal.target {
        ArcTarget::Pose(pose) => {
            let offset = arrival.state.position_m - pose.translation.vector;
            (0..3).for_each(|axis| fill_position(axis, axis, offset[axis]));
            let logarithm = so3::log(&(pose.rotation.inverse() * arrival.state.orientation));
            let by_turn = so3::right_jacobian_inverse(&logarithm) / unit::ORIENTATION_RAD;
            let by_orientation = by_turn * arrival.by_orientation;
            let by_spin = by_turn * arrival.turn_by_spin;
            let by_time = by_turn * arrival.rate.fixed_rows::<3>(part::ORIENTATION);
            for axis in 0..3 {
                block.values[3 + axis] = logarithm[axis] / unit::ORIENTATION_RAD;
                let by = block.derivatives_mut(pattern, 3 + axis);
                for other in 0..3 {
                    by[other] = by_orientation[(axis, other)];
                    by[3 + other] = by_spin[(axis, other)];
                }
                by[6..].fill(by_time[axis]);
            }
        }
        ArcTarget::Coordinate {
            axis,
            lower_m,
            upper_m,
        } => {
            fill_position(0, *axis, arrival.state.position_m[*axis]);
            block.bounds[0] = (lower_m / unit::POSITION_M, upper_m / unit::POSITION_M);
        }
    }
}

/// Fills `block` with a parameter's bounds; its unit is its prior, or the width of its bounds.
pub fn bound(free: &FreeParameter, value: f64, (pattern, block): (&BlockPattern, &mut Block)) {
    let unit = free.length();
    block.reset(pattern);
    block.values[0] = value / unit;
    block.bounds[0] = (free.lower / unit, free.upper / unit);
    block.derivatives_mut(pattern, 0)[0] = 1.0 / unit;
}

/// Fills `block` with a cone: `(p₀² + p₁²)/limit² ≤ 1`.
pub fn cone(cone: &Cone, values: [f64; 2], (pattern, block): (&BlockPattern, &mut Block)) {
    let scale = 1.0 / (cone.limit * cone.limit);
    block.reset(pattern);
    block.values[0] = (values[0] * values[0] + values[1] * values[1]) * scale;
    block.bounds[0] = (f64::NEG_INFINITY, 1.0);
    for (entry, value) in block.derivatives_mut(pattern, 0).iter_mut().zip(values) {
        *entry = 2.0 * value * scale;
    }
    block.curvature = 2.0 * scale;
}

/// What a goal's rows leave, in SI units.
pub fn goal_gap(block: &Block) -> Gap {
    let rows = block.values.len();
    Gap {
        position_m: block.largest(0..rows.min(3)) * unit::POSITION_M,
        orientation_rad: block.largest(rows.min(3)..rows) * unit::ORIENTATION_RAD,
        ..Gap::default()
    }
}
