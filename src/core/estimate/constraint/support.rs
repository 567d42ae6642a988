//! What holds where a body is on a support from the start of the performance on. With the plane's point `P` and
//! normal `n`, its tangents `t`, and the state at the arc's epoch,
//!
//! ```text
//! n·(x − P) = r             or  n·(x + R p − P) = 0,  t·R f = 0     a ball, a face with normal f
//! n·R a = 0                                                         the side of a cylinder with the axis a
//! n·v = 0                                                           it stays there
//! t·R ω = 0                                                         what lies flat turns about n alone
//! t·(v − r R ω × n) = 0                                             what rolls does not slip
//! b·ω = 0                                                           a cylinder rolls about its axis, across `b`
//! v = 0,  ω = 0                                                     what rests
//! ```
//!
//! and at a pivot, with the place `P`, the body's point `p` and the axis, `a` in the body and `A` in the world,
//!
//! ```text
//! x + R p − P = 0,   v + R (ω × p) = 0                              its point stays
//! t·R a = 0,   b·ω = 0                                              at a pin, with the tangents `t` of `A`, `b` of `a`
//! ```
//!
//! All of them hold along the arc where they hold at one of its moments.

use nalgebra::{Matrix3, RowSVector, Vector3};

use super::kind::{At, Constraint, Filled};
use super::rows::STATE;
use crate::estimate::problem::{ArcSupport, Problem, SupportPlace, unit};
use crate::estimate::unknowns::layout::Layout;
use crate::math::so3;
use crate::motion::Gap;
use crate::optimise::block::{Block, BlockPattern};
use crate::physics::contact::Feature;
use crate::physics::state::part;
use crate::physics::support::{Pivot, PivotAxes};
use crate::physics::{OnPlane, PlaneSupport, State, Support, Sustained};

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
        let mut rows = SupportRows::of(state);
        match (self.at, support.expect("an arc on a support")) {
            (SupportPlace::Plane { point_m }, Support::Plane(plane)) => {
                rows.on_plane(&plane, &point_m);
            }
            (SupportPlace::Pivot { place_m, axis }, Support::Pivot(pivot)) => {
                rows.placed(&pivot, place_m, axis);
                if !self.is_caught {
                    rows.turning(&pivot);
                }
            }
            (place, support) => panic!("{support:?} at {place:?}"),
        }
        rows.rows
    }
}

/// The rows of one state.
struct SupportRows<'a> {
    state: &'a State,
    to_world: Matrix3<f64>,
    rows: Vec<SupportRow>,
}

impl<'a> SupportRows<'a> {
    fn of(state: &'a State) -> Self {
        Self {
            state,
            to_world: so3::matrix(&state.orientation),
            rows: Vec::new(),
        }
    }

    fn push(&mut self, value: f64, unit: f64, parts: &[(usize, RowSVector<f64, 3>)]) {
        let mut by_state = RowSVector::<f64, STATE>::zeros();
        for (at, by) in parts {
            by_state.fixed_columns_mut::<3>(*at).copy_from(by);
        }
        self.rows.push(SupportRow {
            value,
            unit,
            by_state,
        });
    }

    /// `∂(R a)/∂δ` of a vector in body axes.
    fn turned(&self, axis: &Vector3<f64>) -> Matrix3<f64> {
        -self.to_world * so3::hat(axis)
    }

    /// That it stands still.
    fn still(&mut self) {
        for axis in 0..3 {
            let row = Vector3::ith(axis, 1.0).transpose();
            let State {
                velocity_m_s,
                angular_velocity_rad_s,
                ..
            } = *self.state;
            let parts = [(part::VELOCITY, row)];
            self.push(velocity_m_s[axis], unit::VELOCITY_M_S, &parts);
            let parts = [(part::ANGULAR_VELOCITY, row)];
            let turning = angular_velocity_rad_s[axis];
            self.push(turning, unit::ANGULAR_VELOCITY_RAD_S, &parts);
        }
    }

    /// That an axis of the body is along one of the world.
    fn along(&mut self, of_body: &Vector3<f64>, of_world: &Vector3<f64>) {
        let here = self.to_world * of_body;
        for across in Feature::tangents(of_world) {
            let by = across.transpose() * self.turned(of_body);
            let parts = [(part::ORIENTATION, by)];
            self.push(across.dot(&here), unit::ORIENTATION_RAD, &parts);
        }
    }

    /// Where the pivot is.
    fn placed(&mut self, pivot: &Pivot, place_m: Option<Vector3<f64>>, axis: Option<Vector3<f64>>) {
        let state = self.state;
        let point_m = state.position_m + self.to_world * pivot.at_m;
        if let Some(place_m) = place_m {
            for axis in 0..3 {
                let row = Vector3::ith(axis, 1.0).transpose();
                let parts = [
                    (part::POSITION, row),
                    (part::ORIENTATION, row * self.turned(&pivot.at_m)),
                ];
                self.push(point_m[axis] - place_m[axis], unit::POSITION_M, &parts);
            }
        }
        if let (PivotAxes::One(of_body), Some(of_world)) = (pivot.axes, axis) {
            self.along(&of_body, &of_world);
        }
    }

    /// How a body moves at a pivot.
    fn turning(&mut self, pivot: &Pivot) {
        if pivot.axes == PivotAxes::None {
            self.still();
            return;
        }
        let state = self.state;
        let moving = state.angular_velocity_rad_s.cross(&pivot.at_m);
        let velocity = state.velocity_m_s + self.to_world * moving;
        for axis in 0..3 {
            let row = Vector3::ith(axis, 1.0).transpose();
            let parts = [
                (part::ORIENTATION, row * self.turned(&moving)),
                (part::VELOCITY, row),
                (part::ANGULAR_VELOCITY, row * self.turned(&pivot.at_m)),
            ];
            self.push(velocity[axis], unit::VELOCITY_M_S, &parts);
        }
        if let PivotAxes::One(axis) = pivot.axes {
            self.spins_about(&axis);
        }
    }

    /// That what touches the plane does.
    fn on_plane(&mut self, plane: &PlaneSupport, point_m: &Vector3<f64>) {
        let normal = plane.normal;
        let state = self.state;
        let height_m = normal.dot(&(state.position_m - point_m));
        let up = normal.transpose();
        match plane.touching {
            OnPlane::Ball { radius_m } | OnPlane::Side { radius_m, .. } => {
                let off_m = height_m - radius_m;
                self.push(off_m, unit::POSITION_M, &[(part::POSITION, up)]);
            }
            OnPlane::Face { point_m, normal } => {
                let off_m = height_m + plane.normal.dot(&(self.to_world * point_m));
                let parts = [
                    (part::POSITION, up),
                    (part::ORIENTATION, up * self.turned(&point_m)),
                ];
                self.push(off_m, unit::POSITION_M, &parts);
                self.along(&normal, &plane.normal);
            }
        }
        if let OnPlane::Side { axis, .. } = plane.touching {
            let parts = [(part::ORIENTATION, up * self.turned(&axis))];
            let risen = normal.dot(&(self.to_world * axis));
            self.push(risen, unit::ORIENTATION_RAD, &parts);
        }
        if plane.sustained == Sustained::Rest {
            self.still();
            return;
        }
        let parts = [(part::VELOCITY, up)];
        let rising_m_s = normal.dot(&state.velocity_m_s);
        self.push(rising_m_s, unit::VELOCITY_M_S, &parts);
        match (plane.touching, plane.sustained) {
            (OnPlane::Face { .. }, _) => self.turns_about(&normal),
            (of, Sustained::Roll) => {
                self.rolls(&normal, of.radius_m().unwrap_or(0.0));
                if let OnPlane::Side { axis, .. } = of {
                    self.spins_about(&axis);
                }
            }
            _ => {}
        }
    }

    /// That it turns about a direction of the world alone.
    fn turns_about(&mut self, normal: &Vector3<f64>) {
        let omega = self.state.angular_velocity_rad_s;
        for along in Feature::tangents(normal) {
            let along = along.transpose();
            let parts = [
                (part::ORIENTATION, along * self.turned(&omega)),
                (part::ANGULAR_VELOCITY, along * self.to_world),
            ];
            let turning = (along * self.to_world * omega)[0];
            self.push(turning, unit::ANGULAR_VELOCITY_RAD_S, &parts);
        }
    }

    /// That it turns about an axis of its own alone.
    fn spins_about(&mut self, axis: &Vector3<f64>) {
        for across in Feature::tangents(axis) {
            let parts = [(part::ANGULAR_VELOCITY, across.transpose())];
            let turning = across.dot(&self.state.angular_velocity_rad_s);
            self.push(turning, unit::ANGULAR_VELOCITY_RAD_S, &parts);
        }
    }

    /// That it does not slip.
    fn rolls(&mut self, normal: &Vector3<f64>, radius_m: f64) {
        let omega = self.state.angular_velocity_rad_s;
        let lever = so3::hat(normal) * radius_m;
        let slip = self.state.velocity_m_s + lever * (self.to_world * omega);
        for along in Feature::tangents(normal) {
            let along = along.transpose();
            let parts = [
                (part::ORIENTATION, along * lever * self.turned(&omega)),
                (part::VELOCITY, along),
                (part::ANGULAR_VELOCITY, along * lever * self.to_world),
            ];
            self.push((along * slip)[0], unit::VELOCITY_M_S, &parts);
        }
    }
}

#[cfg(test)]
mod tests;
