//! Hard conditions at events: contact and continuity through an impact (paper eq. 3, 8,
//! §5.2), and goals (§3.1), as rows `lower ≤ v ≤ upper` in the units of [`mod@unit`].

use std::ops::Range;

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::point::Point;
use super::problem::{ArcGoal, ArcTarget, Collision, Problem, unit};
use crate::math::so3;
use crate::motion::{FreeParameter, Gap};
use crate::physics::impact;
use crate::physics::state::{StateTangent, part};
use crate::physics::{Body, State, flow};

/// Rows of a collision: contact, approach, then post-impact position, orientation, velocity,
/// angular velocity.
pub const COLLISION_ROWS: usize = 14;
/// Row of the approach speed, the only inequality among them.
pub const APPROACH_ROW: usize = 1;

/// Values of some rows and their derivatives by the unknowns they touch.
#[derive(Clone, Debug, Default)]
pub struct Block {
    /// Values, in units.
    pub values: Vec<f64>,
    /// Least and greatest allowed, in units.
    pub bounds: Vec<(f64, f64)>,
    /// Derivatives, column by column, in the order of the layout's columns.
    pub jacobian: Vec<f64>,
}

impl Block {
    /// Distance of row `row` from its bounds, signed; zero inside.
    pub fn violation(&self, row: usize) -> f64 {
        let (lower, upper) = self.bounds[row];
        self.values[row] - self.values[row].clamp(lower, upper)
    }

    /// Largest violation among `rows`.
    fn largest(&self, rows: Range<usize>) -> f64 {
        rows.map(|row| self.violation(row).abs())
            .fold(0.0, f64::max)
    }

    fn reset(&mut self, rows: usize) {
        self.values.clear();
        self.values.resize(rows, 0.0);
        self.bounds.clear();
        self.bounds.resize(rows, (0.0, 0.0));
        self.jacobian.clear();
    }

    fn push_columns<const R: usize, const C: usize>(&mut self, columns: &SMatrix<f64, R, C>) {
        self.jacobian.extend_from_slice(columns.as_slice());
    }
}

/// An arc's state at an event, with what its derivatives need.
struct Arrival {
    state: State,
    duration_s: f64,
    by_orientation: Matrix3<f64>,
    turn_by_spin: Matrix3<f64>,
    spin_by_spin: Matrix3<f64>,
    rate: StateTangent,
}

impl Arrival {
    fn new(
        body: &Body,
        gravity_m_s2: &Vector3<f64>,
        (state, epoch_s): (&State, f64),
        time_s: f64,
    ) -> Self {
        let duration_s = time_s - epoch_s;
        let omega = &state.angular_velocity_rad_s;
        let turn = flow::turn(body, &state.orientation, omega, duration_s);
        let state_then = State {
            position_m: flow::position(gravity_m_s2, state, duration_s),
            orientation: turn.orientation,
            velocity_m_s: state.velocity_m_s + gravity_m_s2 * duration_s,
            angular_velocity_rad_s: turn.angular_velocity_rad_s,
        };
        Self {
            rate: flow::rate(body, gravity_m_s2, &state_then),
            state: state_then,
            duration_s,
            by_orientation: turn.orientation_by_orientation,
            turn_by_spin: turn.orientation_by_angular_velocity,
            spin_by_spin: turn.angular_velocity_by_angular_velocity,
        }
    }

    /// Chains derivatives by the arriving state to those by the state at the epoch, by the
    /// event's time and by gravity.
    fn chain<const R: usize>(
        &self,
        rows: &SMatrix<f64, R, 12>,
    ) -> (SMatrix<f64, R, 12>, SVector<f64, R>, SMatrix<f64, R, 3>) {
        let s = self.duration_s;
        let position = rows.fixed_columns::<3>(part::POSITION);
        let orientation = rows.fixed_columns::<3>(part::ORIENTATION);
        let velocity = rows.fixed_columns::<3>(part::VELOCITY);
        let spin = rows.fixed_columns::<3>(part::ANGULAR_VELOCITY);
        let mut by_state = SMatrix::<f64, R, 12>::zeros();
        by_state
            .fixed_columns_mut::<3>(part::POSITION)
            .copy_from(&position);
        by_state
            .fixed_columns_mut::<3>(part::ORIENTATION)
            .copy_from(&(orientation * self.by_orientation));
        by_state
            .fixed_columns_mut::<3>(part::VELOCITY)
            .copy_from(&(position * s + velocity));
        by_state
            .fixed_columns_mut::<3>(part::ANGULAR_VELOCITY)
            .copy_from(&(orientation * self.turn_by_spin + spin * self.spin_by_spin));
        (
            by_state,
            rows * self.rate,
            position * (0.5 * s * s) + velocity * s,
        )
    }
}

/// Fills `block` with the rows of a collision. `approach_limit_m_s` is the greatest normal
/// speed the contact point may have on arrival (zero: it must not recede).
pub fn collision(
    problem: &Problem,
    collision: &Collision,
    point: &Point,
    epochs_s: &[f64],
    approach_limit_m_s: f64,
    block: &mut Block,
) {
    let body = &problem.bodies[problem.arcs[collision.before].body];
    let gravity = problem.gravity(&point.parameters);
    let time_s = point.event_times_s[collision.event];
    let arrive =
        |arc: usize| Arrival::new(body, &gravity, (&point.arcs[arc], epochs_s[arc]), time_s);
    let (before, after) = (arrive(collision.before), arrive(collision.after));
    let restitution = collision
        .restitution_parameter
        .map_or(collision.restitution, |p| point.parameters[p]);
    let contact = &collision.contact;
    let tilt: Vector3<f64> = collision
        .tilts
        .iter()
        .map(|(axis, p)| axis * point.parameters[*p])
        .sum();
    let normal = so3::exp(&tilt) * contact.surface_normal;
    let bounced = impact::bounce(body, contact, &normal, restitution, &before.state);
    let derivative = impact::bounce_derivative(body, contact, &normal, restitution, &before.state);

    block.reset(COLLISION_ROWS);
    block.values[0] = contact.gap_m(&before.state) / unit::POSITION_M;
    block.values[APPROACH_ROW] = contact.normal_speed_m_s(&before.state) / unit::VELOCITY_M_S;
    block.bounds[APPROACH_ROW] = (f64::NEG_INFINITY, approach_limit_m_s / unit::VELOCITY_M_S);
    let gap = after.state.minus(&bounced);
    for row in 0..12 {
        block.values[2 + row] = gap[row] / STATE_UNITS[row];
    }

    let normal_rows = surface_rows(contact, &before.state);
    let logarithm: Vector3<f64> = gap.fixed_rows::<3>(part::ORIENTATION).into();
    let by_after_turn = so3::right_jacobian_inverse(&logarithm);
    let mut by_before = SMatrix::<f64, COLLISION_ROWS, 12>::zeros();
    by_before
        .fixed_view_mut::<2, 12>(0, 0)
        .copy_from(&normal_rows);
    by_before
        .fixed_view_mut::<3, 3>(2, part::POSITION)
        .fill_diagonal(-1.0);
    by_before
        .fixed_view_mut::<3, 3>(5, part::ORIENTATION)
        .copy_from(&-by_after_turn.transpose());
    by_before
        .fixed_view_mut::<6, 9>(8, part::ORIENTATION)
        .copy_from(&-derivative.by_state);
    let mut by_after = SMatrix::<f64, COLLISION_ROWS, 12>::zeros();
    by_after.fixed_view_mut::<12, 12>(2, 0).fill_diagonal(1.0);
    by_after
        .fixed_view_mut::<3, 3>(5, part::ORIENTATION)
        .copy_from(&by_after_turn);
    scale_rows(&mut by_before);
    scale_rows(&mut by_after);

    let (before_state, before_time, before_gravity) = before.chain(&by_before);
    let (after_state, after_time, after_gravity) = after.chain(&by_after);
    block.push_columns(&before_state);
    block.push_columns(&after_state);
    block.push_columns(&(before_time + after_time));
    push_gravity(problem, block, &(before_gravity + after_gravity));
    let mut velocity_column = |change: SMatrix<f64, 6, 1>| {
        let mut column = SVector::<f64, COLLISION_ROWS>::zeros();
        for row in 0..6 {
            column[8 + row] = -change[row] / STATE_UNITS[6 + row];
        }
        block.push_columns(&column);
    };
    if collision.restitution_parameter.is_some() {
        velocity_column(derivative.by_restitution);
    }
    let left = so3::exp_and_left_jacobian(&tilt).1;
    for (axis, _) in &collision.tilts {
        velocity_column(derivative.by_normal * (left * axis).cross(&normal));
    }
}

/// Units of a state's tangent.
const STATE_UNITS: [f64; 12] = {
    let (x, r) = (unit::POSITION_M, unit::ORIENTATION_RAD);
    let (v, w) = (unit::VELOCITY_M_S, unit::ANGULAR_VELOCITY_RAD_S);
    [x, x, x, r, r, r, v, v, v, w, w, w]
};

fn scale_rows(rows: &mut SMatrix<f64, COLLISION_ROWS, 12>) {
    rows.row_mut(0).scale_mut(1.0 / unit::POSITION_M);
    rows.row_mut(APPROACH_ROW)
        .scale_mut(1.0 / unit::VELOCITY_M_S);
    for row in 0..12 {
        rows.row_mut(2 + row).scale_mut(1.0 / STATE_UNITS[row]);
    }
}

/// Derivatives of the gap and of the normal speed by the arriving state.
fn surface_rows(contact: &impact::Contact, state: &State) -> SMatrix<f64, 2, 12> {
    let normal = &contact.surface_normal;
    let in_body = state.orientation.inverse_transform_vector(normal);
    let arm = contact.point_m.cross(&in_body);
    // δc = p × (Rᵀn × δθ), dotted with ω.
    let speed_by_turn = (state.angular_velocity_rad_s.cross(&contact.point_m)).cross(&in_body);
    let mut rows = SMatrix::<f64, 2, 12>::zeros();
    rows.fixed_view_mut::<1, 3>(0, part::POSITION)
        .tr_copy_from(normal);
    rows.fixed_view_mut::<1, 3>(0, part::ORIENTATION)
        .tr_copy_from(&arm);
    rows.fixed_view_mut::<1, 3>(1, part::ORIENTATION)
        .tr_copy_from(&speed_by_turn);
    rows.fixed_view_mut::<1, 3>(1, part::VELOCITY)
        .tr_copy_from(normal);
    rows.fixed_view_mut::<1, 3>(1, part::ANGULAR_VELOCITY)
        .tr_copy_from(&arm);
    rows
}

fn push_gravity<const R: usize>(
    problem: &Problem,
    block: &mut Block,
    by_gravity: &SMatrix<f64, R, 3>,
) {
    for axis in 0..3 {
        if problem.gravity_parameters[axis].is_some() {
            block.push_columns(&by_gravity.fixed_columns::<1>(axis).into_owned());
        }
    }
}

/// Fills `block` with the rows of a goal.
pub fn goal(problem: &Problem, goal: &ArcGoal, point: &Point, epochs_s: &[f64], block: &mut Block) {
    let body = &problem.bodies[problem.arcs[goal.arc].body];
    let gravity = problem.gravity(&point.parameters);
    let time_s = point.event_times_s[goal.event];
    let arrival = Arrival::new(
        body,
        &gravity,
        (&point.arcs[goal.arc], epochs_s[goal.arc]),
        time_s,
    );
    match &goal.target {
        ArcTarget::Pose(pose) => {
            let logarithm = so3::log(&(pose.rotation.inverse() * arrival.state.orientation));
            let offset = arrival.state.position_m - pose.translation.vector;
            block.reset(6);
            for axis in 0..3 {
                block.values[axis] = offset[axis] / unit::POSITION_M;
                block.values[3 + axis] = logarithm[axis] / unit::ORIENTATION_RAD;
            }
            let mut rows = SMatrix::<f64, 6, 12>::zeros();
            rows.fixed_view_mut::<3, 3>(0, part::POSITION)
                .fill_diagonal(1.0 / unit::POSITION_M);
            rows.fixed_view_mut::<3, 3>(3, part::ORIENTATION)
                .copy_from(&(so3::right_jacobian_inverse(&logarithm) / unit::ORIENTATION_RAD));
            push_goal(problem, goal, block, &arrival, &rows);
        }
        ArcTarget::Coordinate {
            axis,
            lower_m,
            upper_m,
        } => {
            block.reset(1);
            block.values[0] = arrival.state.position_m[*axis] / unit::POSITION_M;
            block.bounds[0] = (lower_m / unit::POSITION_M, upper_m / unit::POSITION_M);
            let mut rows = SMatrix::<f64, 1, 12>::zeros();
            rows[*axis] = 1.0 / unit::POSITION_M;
            push_goal(problem, goal, block, &arrival, &rows);
        }
    }
}

fn push_goal<const R: usize>(
    problem: &Problem,
    goal: &ArcGoal,
    block: &mut Block,
    arrival: &Arrival,
    rows: &SMatrix<f64, R, 12>,
) {
    let (by_state, by_time, by_gravity) = arrival.chain(rows);
    block.push_columns(&by_state);
    if problem.event_is_free[goal.event] {
        block.push_columns(&by_time);
    }
    push_gravity(problem, block, &by_gravity);
}

/// Fills `block` with a parameter's bounds; its unit is its prior, or the width of its bounds.
pub fn bound(free: &FreeParameter, value: f64, block: &mut Block) {
    let unit = free.length();
    block.reset(1);
    block.values[0] = value / unit;
    block.bounds[0] = (free.lower / unit, free.upper / unit);
    block.jacobian.push(1.0 / unit);
}

/// What a collision's rows leave, in SI units.
pub fn collision_gap(block: &Block) -> Gap {
    Gap {
        position_m: block.largest(0..1).max(block.largest(2..5)) * unit::POSITION_M,
        orientation_rad: block.largest(5..8) * unit::ORIENTATION_RAD,
        velocity_m_s: block.largest(APPROACH_ROW..2).max(block.largest(8..11)) * unit::VELOCITY_M_S,
        angular_velocity_rad_s: block.largest(11..14) * unit::ANGULAR_VELOCITY_RAD_S,
    }
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
