//! Hard conditions as rows `lower ≤ v ≤ upper` in the units of [`mod@unit`]: what a row is
//! ([`Block`]), goals (paper §3.1), bounds and cones of parameters. The rows of collisions are in
//! [`super::collision`].

use std::ops::Range;

use nalgebra::{DVector, Matrix3, SMatrix, SVector, Vector3};

use super::layout::STATE;
use super::point::Point;
use super::problem::{ArcGoal, ArcTarget, Problem, unit};
use crate::math::envelope::{Envelope, Pattern};
use crate::math::so3;
use crate::motion::{Cone, FreeParameter, Gap};
use crate::physics::state::{StateTangent, part};
use crate::physics::{Body, State, flow};

/// Rows of the largest block: three contacts and their approach speeds, two states.
pub const ROWS_MAX: usize = 3 + 3 + 2 * STATE;

/// Values of some rows and their derivatives by the unknowns they touch.
#[derive(Clone, Debug, Default)]
pub struct Block {
    /// Values, in units.
    pub values: Vec<f64>,
    /// Least and greatest allowed, in units.
    pub bounds: Vec<(f64, f64)>,
    /// Derivatives, column by column, in the order of the layout's columns.
    pub jacobian: Vec<f64>,
    /// Rows that hold approach speeds.
    pub approach: Range<usize>,
    /// Second derivative of the first row by each of the unknowns, where the row is curved
    /// alike in all of them.
    pub curvature: f64,
}

impl Block {
    /// Distance of row `row` from its bounds, signed; zero inside.
    pub fn violation(&self, row: usize) -> f64 {
        let (lower, upper) = self.bounds[row];
        self.values[row] - self.values[row].clamp(lower, upper)
    }

    /// Largest violation among `rows`.
    pub(super) fn largest(&self, rows: Range<usize>) -> f64 {
        rows.map(|row| self.violation(row).abs())
            .fold(0.0, f64::max)
    }

    /// Empties it for so many equalities and so many columns, all zero.
    pub(super) fn reset(&mut self, rows: usize, columns: usize) {
        self.values.clear();
        self.values.resize(rows, 0.0);
        self.bounds.clear();
        self.bounds.resize(rows, (0.0, 0.0));
        self.jacobian.clear();
        self.jacobian.resize(rows * columns, 0.0);
        self.approach = 0..0;
        self.curvature = 0.0;
    }

    /// Adds derivatives from a row and a column on.
    pub(super) fn add<const R: usize, const C: usize>(
        &mut self,
        (row, column): (usize, usize),
        derivatives: &SMatrix<f64, R, C>,
    ) {
        let rows = self.values.len();
        for (index, entries) in derivatives.column_iter().enumerate() {
            let at = (column + index) * rows + row;
            for (entry, derivative) in self.jacobian[at..at + R].iter_mut().zip(entries.iter()) {
                *entry += derivative;
            }
        }
    }

    /// Adds `Jᵀ diag(w) J` to a matrix whose unknowns `columns` the block touches. Most rows touch few
    /// of them, and rows of no weight none.
    pub(super) fn add_square(
        &self,
        pattern: &Pattern,
        columns: &[usize],
        weight: impl Fn(usize) -> f64,
        matrix: &mut Envelope,
    ) {
        let rows = self.values.len();
        let mut ascending: Vec<(usize, usize)> = columns.iter().copied().zip(0..).collect();
        ascending.sort_unstable();
        let mut touched = Vec::with_capacity(columns.len());
        for row in (0..rows).filter(|row| weight(*row) != 0.0) {
            let derivatives = ascending
                .iter()
                .map(|(at, column)| (*at, self.jacobian[column * rows + row]));
            touched.clear();
            touched.extend(derivatives.filter(|(_, derivative)| *derivative != 0.0));
            matrix.add_outer(pattern, weight(row), &touched);
        }
    }

    /// Adds `Jᵀ p` for a pull `p` on every row.
    pub(super) fn add_pull(
        &self,
        columns: &[usize],
        pull: impl Fn(usize) -> f64,
        gradient: &mut DVector<f64>,
    ) {
        let rows = self.values.len();
        let mut pulls = [0.0; ROWS_MAX];
        for (row, entry) in pulls[..rows].iter_mut().enumerate() {
            *entry = pull(row);
        }
        for (column, at) in columns.iter().enumerate() {
            let derivatives = self.jacobian[column * rows..][..rows].iter();
            gradient[*at] += derivatives.zip(&pulls).map(|(d, p)| d * p).sum::<f64>();
        }
    }
}

/// An arc's state at an event, with what its derivatives need.
pub(super) struct Arrival {
    pub(super) state: State,
    duration_s: f64,
    by_orientation: Matrix3<f64>,
    turn_by_spin: Matrix3<f64>,
    spin_by_spin: Matrix3<f64>,
    rate: StateTangent,
}

impl Arrival {
    pub(super) fn new(
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
    pub(super) fn chain<const R: usize>(
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
    let columns = goal_columns(problem, goal);
    match &goal.target {
        ArcTarget::Pose(pose) => {
            let logarithm = so3::log(&(pose.rotation.inverse() * arrival.state.orientation));
            let offset = arrival.state.position_m - pose.translation.vector;
            block.reset(6, columns);
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
            block.reset(1, columns);
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
    block.add((0, 0), &by_state);
    let mut column = STATE;
    if problem.event_is_free[goal.event] {
        block.add((0, column), &by_time);
        column += 1;
    }
    add_gravity(problem, block, (0, column), &by_gravity);
}

/// State, time, gravity.
fn goal_columns(problem: &Problem, goal: &ArcGoal) -> usize {
    STATE + usize::from(problem.event_is_free[goal.event]) + problem.gravity_count()
}

/// Adds derivatives by the free components of gravity.
pub(super) fn add_gravity<const R: usize>(
    problem: &Problem,
    block: &mut Block,
    (row, column): (usize, usize),
    by_gravity: &SMatrix<f64, R, 3>,
) {
    let free = (0..3).filter(|axis| problem.gravity_parameters[*axis].is_some());
    for (index, axis) in free.enumerate() {
        let by_axis = by_gravity.fixed_columns::<1>(axis).into_owned();
        block.add((row, column + index), &by_axis);
    }
}

/// Fills `block` with a parameter's bounds; its unit is its prior, or the width of its bounds.
pub fn bound(free: &FreeParameter, value: f64, block: &mut Block) {
    let unit = free.length();
    block.reset(1, 1);
    block.values[0] = value / unit;
    block.bounds[0] = (free.lower / unit, free.upper / unit);
    block.jacobian[0] = 1.0 / unit;
}

/// Fills `block` with a cone: `(p₀² + p₁²)/limit² ≤ 1`.
pub fn cone(cone: &Cone, values: [f64; 2], block: &mut Block) {
    let scale = 1.0 / (cone.limit * cone.limit);
    block.reset(1, 2);
    block.values[0] = (values[0] * values[0] + values[1] * values[1]) * scale;
    block.bounds[0] = (f64::NEG_INFINITY, 1.0);
    for (entry, value) in block.jacobian.iter_mut().zip(values) {
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
