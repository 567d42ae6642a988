//! What holds where a body is on a support from the start of the performance on. With the plane's point `P` and
//! normal `n`, its tangents `t`, and the state at the arc's epoch,
//!
//! ```text
//! n·(x − P) = r             or  n·(x + R p − P) = 0,  t·R f = 0     a ball, a face with normal f
//! n·v = 0                                                           it stays there
//! t·R ω = 0                                                         what lies flat turns about n alone
//! t·(v − r R ω × n) = 0                                             what rolls does not slip
//! v = 0,  ω = 0                                                     what rests
//! ```
//!
//! All of them hold along the arc where they hold at one of its moments.

use nalgebra::{RowSVector, Vector3};

use super::kind::{At, Constraint, Filled};
use super::rows::STATE;
use crate::estimate::problem::{ArcSupport, Problem, unit};
use crate::estimate::unknowns::layout::Layout;
use crate::math::so3;
use crate::motion::Gap;
use crate::optimise::block::{Block, BlockPattern};
use crate::physics::contact::Feature;
use crate::physics::state::part;
use crate::physics::{State, Support, Sustained};

/// A row with its unit and its derivatives by the state.
struct SupportRow {
    value: f64,
    unit: f64,
    by_state: RowSVector<f64, STATE>,
}

impl Constraint for ArcSupport {
    fn patterns(&self, problem: &Problem, layout: &Layout) -> [BlockPattern; 2] {
        let rows = self.rows(problem, &State::at_rest()).len();
        let columns: Vec<usize> = layout.state(self.arc).collect();
        [BlockPattern::dense(rows, columns), BlockPattern::default()]
    }

    fn fill(&self, at: &mut At, [(pattern, block), _]: [Filled; 2]) {
        block.reset(pattern);
        let rows = self.rows(at.problem, &at.point.arcs[self.arc]);
        for (index, row) in rows.iter().enumerate() {
            block.values[index] = row.value / row.unit;
            let scaled = row.by_state / row.unit;
            block
                .derivatives_mut(pattern, index)
                .copy_from_slice(scaled.as_slice());
        }
    }

    fn gap(&self, problem: &Problem, [block, _]: [&Block; 2]) -> Gap {
        let rows = self.rows(problem, &State::at_rest());
        let of = |unit: f64| {
            let own = rows
                .iter()
                .zip(&block.values)
                .filter(|(row, _)| row.unit == unit);
            own.fold(0.0_f64, |most, (_, value)| most.max(value.abs())) * unit
        };
        Gap {
            position_m: of(unit::POSITION_M),
            orientation_rad: of(unit::ORIENTATION_RAD),
            velocity_m_s: of(unit::VELOCITY_M_S),
            angular_velocity_rad_s: of(unit::ANGULAR_VELOCITY_RAD_S),
        }
    }

    fn is_curved(&self) -> bool {
        true
    }
}

impl ArcSupport {
    fn rows(&self, problem: &Problem, state: &State) -> Vec<SupportRow> {
        let support = problem.body_of(self.arc).support();
        let Support {
            normal,
            sustained,
            radius_m,
            ..
        } = support.expect("an arc on a support");
        let tangents = Feature::tangents(&normal);
        let to_world = so3::matrix(&state.orientation);
        let turned = |axis: &Vector3<f64>| -to_world * so3::hat(axis);
        let height_m = normal.dot(&(state.position_m - self.point_m));
        let mut rows = Vec::new();
        let mut push = |value: f64, unit: f64, parts: &[(usize, RowSVector<f64, 3>)]| {
            let mut by_state = RowSVector::<f64, STATE>::zeros();
            for (at, by) in parts {
                by_state.fixed_columns_mut::<3>(*at).copy_from(by);
            }
            rows.push(SupportRow {
                value,
                unit,
                by_state,
            });
        };
        let up = normal.transpose();
        match &self.face {
            None => {
                let off_m = height_m - radius_m.unwrap_or(0.0);
                push(off_m, unit::POSITION_M, &[(part::POSITION, up)]);
            }
            Some(face) => {
                let off_m = height_m + normal.dot(&(to_world * face.point_m));
                let parts = [
                    (part::POSITION, up),
                    (part::ORIENTATION, up * turned(&face.point_m)),
                ];
                push(off_m, unit::POSITION_M, &parts);
                let out = to_world * face.normal;
                for along in &tangents {
                    let by = along.transpose() * turned(&face.normal);
                    let parts = [(part::ORIENTATION, by)];
                    push(along.dot(&out), unit::ORIENTATION_RAD, &parts);
                }
            }
        }
        let (velocity, omega) = (state.velocity_m_s, state.angular_velocity_rad_s);
        let spin = to_world * omega;
        if sustained == Sustained::Rest {
            for axis in 0..3 {
                let unit_row = Vector3::ith(axis, 1.0).transpose();
                let parts = [(part::VELOCITY, unit_row)];
                push(velocity[axis], unit::VELOCITY_M_S, &parts);
                let parts = [(part::ANGULAR_VELOCITY, unit_row)];
                push(omega[axis], unit::ANGULAR_VELOCITY_RAD_S, &parts);
            }
            return rows;
        }
        push(
            normal.dot(&velocity),
            unit::VELOCITY_M_S,
            &[(part::VELOCITY, up)],
        );
        for along in &tangents {
            let along = along.transpose();
            if self.face.is_some() {
                let parts = [
                    (part::ORIENTATION, along * turned(&omega)),
                    (part::ANGULAR_VELOCITY, along * to_world),
                ];
                push((along * spin)[0], unit::ANGULAR_VELOCITY_RAD_S, &parts);
            } else if sustained == Sustained::Roll {
                let lever = so3::hat(&normal) * radius_m.unwrap_or(0.0);
                let slip = velocity + lever * spin;
                let parts = [
                    (part::ORIENTATION, along * lever * turned(&omega)),
                    (part::VELOCITY, along),
                    (part::ANGULAR_VELOCITY, along * lever * to_world),
                ];
                push((along * slip)[0], unit::VELOCITY_M_S, &parts);
            }
        }
        rows
    }
}
