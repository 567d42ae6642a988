//! A goal (paper §3.1): a link's pose at an event, or a coordinate of its centre of mass within
//! bounds:
//!
//! ```text
//! x − x_goal = 0, Log(R_goalᵀ R) = 0      or      lower ≤ x_axis ≤ upper
//! ```

use super::kind::{At, Constraint, Filled};
use super::rows::STATE;
use crate::estimate::covariance::timing;
use crate::estimate::problem::influence::Influence;
use crate::estimate::problem::{ArcGoal, ArcTarget, Problem, unit};
use crate::estimate::reach::arc_end::ArcEnd;
use crate::estimate::reach::arrival::{ByStates, GeneralArrival};
use crate::estimate::unknowns::layout::Layout;
use crate::math::so3;
use crate::motion::Gap;
use crate::optimise::block::{Block, BlockPattern, SecondDerivative};
use crate::physics::state::{StateTangent, part};

impl Constraint for ArcGoal {
    /// Columns: position and velocity along an axis, row by row, and for a pose orientation and
    /// angular velocity; the event's time, where that is free; gravity.
    fn patterns(&self, problem: &Problem, layout: &Layout) -> [BlockPattern; 2] {
        let of = &problem.arcs[self.arc];
        if !of.is_plain {
            let acting = of.acting.iter().map(|a| layout.parameters[a.parameter]);
            let time = layout.events[self.event];
            let all = layout.state(self.arc).chain(time).chain(acting);
            let rows = match &self.target {
                ArcTarget::Pose(_) => 6,
                ArcTarget::Coordinate { .. } => 1,
            };
            return [
                BlockPattern::dense(rows, all.collect()),
                BlockPattern::default(),
            ];
        }
        let state = layout.arcs[self.arc];
        let time = layout.events[self.event];
        let mut pattern = BlockPattern::default();
        let mut push_position = |axis: usize| {
            let state = [state + part::POSITION + axis, state + part::VELOCITY + axis];
            let gravity = problem.gravity_parameters[axis].map(|p| layout.parameters[p]);
            pattern.push(1, state.into_iter().chain(time).chain(gravity));
        };
        match &self.target {
            ArcTarget::Pose(_) => {
                (0..3).for_each(&mut push_position);
                let turn = [part::ORIENTATION, part::ANGULAR_VELOCITY];
                let turn = turn.map(|part| state + part..state + part + 3);
                pattern.push(3, turn.into_iter().flatten().chain(time));
            }
            ArcTarget::Coordinate { axis, .. } => push_position(*axis),
        }
        [pattern, BlockPattern::default()]
    }

    fn fill(&self, at: &mut At, [(pattern, block), _]: [Filled; 2]) {
        let problem = at.problem;
        if !problem.arcs[self.arc].is_plain {
            if self.fill_general(at, (pattern, &mut *block)).is_none() {
                block.spoil();
            }
            return;
        }
        let body = problem.body_of(self.arc);
        let gravity = problem.gravity(&at.point.parameters);
        let time_s = at.event_time_s(self.event);
        let arrival = ArcEnd::new(
            body,
            &gravity,
            at.point,
            self.arc,
            [at.epochs_s[self.arc], time_s],
        );
        block.reset(pattern);
        // Columns after the state: time, then gravity.
        let time = usize::from(problem.event_is_free[self.event]);
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
        match &self.target {
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
                if time == 1 {
                    let acceleration_m_s2 = arrival.rate[part::VELOCITY + axis];
                    let is_gravity_free = problem.gravity_parameters[*axis].is_some();
                    block.second = by_time(arrival.duration_s, acceleration_m_s2, is_gravity_free);
                }
            }
        }
    }

    fn event(&self) -> Option<usize> {
        Some(self.event)
    }

    fn gap(&self, _: &Problem, [block, _]: [&Block; 2]) -> Gap {
        let rows = block.values.len();
        Gap {
            position_m: block.largest(0..rows.min(3)) * unit::POSITION_M,
            orientation_rad: block.largest(rows.min(3)..rows) * unit::ORIENTATION_RAD,
            ..Gap::default()
        }
    }

    /// A coordinate has its second derivatives in closed form.
    fn is_curved(&self) -> bool {
        matches!(self.target, ArcTarget::Pose(_))
    }
}

/// Second derivatives of `x + v s + ½ g s²` by the time and, in the order of the columns, by
/// velocity, time and, where it is free, gravity. At an apex the first derivative by the time
/// vanishes, and these are all that say where it is.
fn by_time(
    duration_s: f64,
    acceleration_m_s2: f64,
    is_gravity_free: bool,
) -> Vec<SecondDerivative> {
    const VELOCITY: usize = 1;
    const TIME: usize = 2;
    const GRAVITY: usize = 3;
    let by = |other: usize, value: f64| SecondDerivative {
        row: 0,
        by: [TIME, other],
        value: value / unit::POSITION_M,
    };
    let by_gravity = is_gravity_free.then(|| by(GRAVITY, duration_s));
    let others = [by(VELOCITY, 1.0), by(TIME, acceleration_m_s2)];
    others.into_iter().chain(by_gravity).collect()
}

impl ArcGoal {
    /// The rows in general, with drag or with parameters that act on the flight; `None` where there
    /// is no such flight. A moved centre of mass moves the point of the body whose pose is the goal.
    fn fill_general(&self, at: &At, (pattern, block): Filled) -> Option<()> {
        let (problem, parameters) = (at.problem, &at.point.parameters);
        let of = &problem.arcs[self.arc];
        let clock = timing::clock_at(problem, of, self.event);
        let time_s = at.event_time_s(self.event) + clock.map_or(0.0, |clock| parameters[clock]);
        let arrival =
            GeneralArrival::new(problem, at.point, self.arc, at.epochs_s[self.arc], time_s)?;
        let state = &arrival.end.state;
        block.reset(pattern);
        // Derivatives of the rows by the arriving state, and by the centre of mass in body axes.
        let mut by = ByStates::zeros();
        let mut by_centre = nalgebra::SMatrix::<f64, 6, 3>::zeros();
        let mut values = nalgebra::SVector::<f64, 6>::zeros();
        let rows = match &self.target {
            ArcTarget::Pose(pose) => {
                let centre_m =
                    of.acting
                        .iter()
                        .fold(nalgebra::Vector3::zeros(), |mut sum, acting| {
                            if let Influence::Centre(axis) = acting.influence {
                                sum[axis] += parameters[acting.parameter];
                            }
                            sum
                        });
                let offset = state.position_m - pose.translation.vector - pose.rotation * centre_m;
                let logarithm = so3::log(&(pose.rotation.inverse() * state.orientation));
                values
                    .fixed_rows_mut::<3>(0)
                    .copy_from(&(offset / unit::POSITION_M));
                values
                    .fixed_rows_mut::<3>(3)
                    .copy_from(&(logarithm / unit::ORIENTATION_RAD));
                by.fixed_view_mut::<3, 3>(0, part::POSITION).copy_from(
                    &nalgebra::Matrix3::from_diagonal_element(1.0 / unit::POSITION_M),
                );
                let by_turn = so3::right_jacobian_inverse(&logarithm) / unit::ORIENTATION_RAD;
                by.fixed_view_mut::<3, 3>(3, part::ORIENTATION)
                    .copy_from(&by_turn);
                let turned = so3::matrix(&pose.rotation) / -unit::POSITION_M;
                by_centre.fixed_view_mut::<3, 3>(0, 0).copy_from(&turned);
                6
            }
            ArcTarget::Coordinate {
                axis,
                lower_m,
                upper_m,
            } => {
                values[0] = state.position_m[*axis] / unit::POSITION_M;
                by[(0, part::POSITION + axis)] = 1.0 / unit::POSITION_M;
                block.bounds[0] = (lower_m / unit::POSITION_M, upper_m / unit::POSITION_M);
                if problem.event_is_free[self.event] {
                    let by = |other: usize, value: f64| SecondDerivative {
                        row: 0,
                        by: [STATE, other],
                        value: value / unit::POSITION_M,
                    };
                    let acceleration_m_s2 = arrival.end.rate[part::VELOCITY + axis];
                    let by_velocity = arrival.velocity_by_velocity(*axis);
                    block.second = vec![
                        by(part::VELOCITY + axis, by_velocity),
                        by(STATE, acceleration_m_s2),
                    ];
                }
                1
            }
        };
        let chained = by * arrival.by_state();
        let mut columns: Vec<StateTangent> = chained
            .column_iter()
            .map(|column| column.into_owned())
            .collect();
        if problem.event_is_free[self.event] {
            columns.push(by * arrival.end.rate);
        }
        columns.extend(of.acting.iter().map(|acting| {
            let value = parameters[acting.parameter];
            let mut column = by * arrival.by(acting.influence, value);
            if let Influence::Centre(axis) = acting.influence {
                let mut own = column.fixed_rows_mut::<6>(0);
                own += by_centre.column(axis);
            }
            if clock == Some(acting.parameter) {
                column += by * arrival.end.rate;
            }
            column
        }));
        for row in 0..rows {
            block.values[row] = values[row];
            let entries = block.derivatives_mut(pattern, row);
            for (entry, column) in entries.iter_mut().zip(&columns) {
                *entry = column[row];
            }
        }
        Some(())
    }
}
