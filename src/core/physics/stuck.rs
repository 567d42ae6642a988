//! Two bodies that are one: how the whole of them flies, and what is kept where they become one.
//!
//! Of masses `m`, moments `I` and centres of mass `x`, the second seen from the first at `a`, turned by `A`:
//!
//! ```text
//! M = m₀ + m₁,   X = (m₀ x₀ + m₁ x₁)/M,   J = I₀ + A I₁ Aᵀ + μ (|a|² − a aᵀ),   μ = m₀ m₁/M
//! P/M = Σ (m/M) v,   L = Σ R I ω + μ (x₀ − x₁) × (v₀ − v₁)                     about X
//! ```

use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, SymmetricEigen, UnitQuaternion, Vector3};

use super::body::Body;
use super::state::{ByStates, State, part};
use super::support::StuckPart;
use crate::math::{Pose, so3};

/// Most sweeps of the eigenvalue iteration; three suffice.
const SWEEPS: usize = 1000;

impl StuckPart {
    /// Each of two bodies as a part of both together, the second of which is at a pose in the axes of the first; `None` where
    /// that is no number.
    pub fn both(bodies: [&Body; 2], first_from_second: &Pose) -> Option<[Self; 2]> {
        let [first_kg, second_kg] = bodies.map(Body::mass_kg);
        let mass_kg = first_kg + second_kg;
        let apart_m = first_from_second.translation.vector;
        let turn = so3::matrix(&first_from_second.rotation);
        let [first, second] = bodies.map(|of| Matrix3::from_diagonal(&of.moments_kg_m2()));
        let square = Matrix3::identity() * apart_m.norm_squared() - apart_m * apart_m.transpose();
        let tensor =
            first + turn * second * turn.transpose() + square * (first_kg * second_kg / mass_kg);
        let size = tensor.amax();
        let eigen = SymmetricEigen::try_new(tensor / size, f64::EPSILON, SWEEPS)?;
        let mut axes = eigen.eigenvectors;
        if axes.determinant() < 0.0 {
            axes.column_mut(2).neg_mut();
        }
        let axes = Rotation3::from_matrix_unchecked(axes);
        let part = Self {
            centre_m: apart_m * (second_kg / mass_kg),
            axes: UnitQuaternion::from_rotation_matrix(&axes),
            mass_kg,
            moments_kg_m2: eigen.eigenvalues * size,
        };
        Body::new(mass_kg, part.moments_kg_m2).ok()?;
        let first_from_whole = Pose::from_parts(part.centre_m.into(), part.axes);
        let second_from_whole = first_from_second.inverse() * first_from_whole;
        let second = Self {
            centre_m: second_from_whole.translation.vector,
            axes: second_from_whole.rotation,
            ..part
        };
        Some([part, second])
    }

    /// The whole.
    ///
    /// # Panics
    /// Of moments that no body has: [`StuckPart::both`] makes none.
    pub fn whole(&self) -> Body {
        Body::new(self.mass_kg, self.moments_kg_m2).expect("moments of two bodies")
    }

    /// The state of the whole, of that of the body.
    pub fn of_whole(&self, body: &State) -> State {
        elsewhere(body, &self.centre_m, &self.axes)
    }

    /// The state of the body, of that of the whole.
    pub fn of_body(&self, whole: &State) -> State {
        let back = self.back();
        elsewhere(whole, &back.translation.vector, &back.rotation)
    }

    /// Derivative of [`StuckPart::of_whole`] at a state of the body.
    pub fn whole_by_body(&self, body: &State) -> ByStates {
        elsewhere_by_state(body, &self.centre_m, &self.axes)
    }

    /// Derivative of [`StuckPart::of_body`] at a state of the whole.
    pub fn body_by_whole(&self, whole: &State) -> ByStates {
        let back = self.back();
        elsewhere_by_state(whole, &back.translation.vector, &back.rotation)
    }

    /// The principal axes of the whole from the body's.
    fn back(&self) -> Pose {
        Pose::from_parts(self.centre_m.into(), self.axes).inverse()
    }
}

/// The state of axes that are at a place in those of a body and turned, and move with it.
fn elsewhere(of: &State, place_m: &Vector3<f64>, turn: &UnitQuaternion<f64>) -> State {
    let omega = of.angular_velocity_rad_s;
    State {
        position_m: of.position_m + of.orientation * place_m,
        orientation: of.orientation * turn,
        velocity_m_s: of.velocity_m_s + of.orientation * omega.cross(place_m),
        angular_velocity_rad_s: turn.inverse() * omega,
    }
}

fn elsewhere_by_state(of: &State, place_m: &Vector3<f64>, turn: &UnitQuaternion<f64>) -> ByStates {
    let to_world = so3::matrix(&of.orientation);
    let moving = of.angular_velocity_rad_s.cross(place_m);
    let arm = to_world * so3::hat(place_m);
    let back = so3::matrix(turn).transpose();
    let [x, r, v, w] = PARTS;
    let mut by = ByStates::identity();
    let mut set = |row: usize, column: usize, block: Matrix3<f64>| {
        by.fixed_view_mut::<3, 3>(row, column).copy_from(&block);
    };
    set(x, r, -arm);
    set(r, r, back);
    set(v, r, -to_world * so3::hat(&moving));
    set(v, w, -arm);
    set(w, w, back);
    by
}

const PARTS: [usize; 4] = [
    part::POSITION,
    part::ORIENTATION,
    part::VELOCITY,
    part::ANGULAR_VELOCITY,
];

/// Three numbers of the motion of a centre of mass, then three of a rotation [m/s, rad/s, world], of two bodies, with their
/// derivatives by both states.
#[derive(Clone, Debug)]
pub struct PairRows {
    /// The numbers.
    pub values: SVector<f64, 6>,
    /// Their derivatives by each state.
    pub by: [SMatrix<f64, 6, 12>; 2],
}

impl PairRows {
    fn zeros() -> Self {
        Self {
            values: SVector::zeros(),
            by: [SMatrix::zeros(); 2],
        }
    }

    fn add(&mut self, row: usize, value: Vector3<f64>) {
        let mut rows = self.values.fixed_rows_mut::<3>(row);
        rows += value;
    }

    fn put(&mut self, side: usize, row: usize, column: usize, block: Matrix3<f64>) {
        let mut to = self.by[side].fixed_view_mut::<3, 3>(row, column);
        to += block;
    }

    /// The momentum of two bodies together over their mass, and their angular momentum about the centre of both over
    /// a moment of inertia [kg m²].
    pub fn momenta(bodies: [&Body; 2], states: [&State; 2], per_kg_m2: f64) -> Self {
        let mut rows = Self::zeros();
        let masses = bodies.map(Body::mass_kg);
        let mass_kg = masses[0] + masses[1];
        let [x, r, v, w] = PARTS;
        let reduced = masses[0] * masses[1] / mass_kg / per_kg_m2;
        let apart = states[0].position_m - states[1].position_m;
        let faster = states[0].velocity_m_s - states[1].velocity_m_s;
        rows.add(3, apart.cross(&faster) * reduced);
        for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
            let (body, state) = (bodies[side], states[side]);
            let share = masses[side] / mass_kg;
            rows.add(0, state.velocity_m_s * share);
            rows.put(side, 0, v, Matrix3::identity() * share);
            let inertia = Matrix3::from_diagonal(&(body.moments_kg_m2() / per_kg_m2));
            let to_world = so3::matrix(&state.orientation);
            let spin = inertia * state.angular_velocity_rad_s;
            rows.add(3, to_world * spin);
            rows.put(side, 3, r, -to_world * so3::hat(&spin));
            rows.put(side, 3, w, to_world * inertia);
            rows.put(side, 3, x, so3::hat(&faster) * (-sign * reduced));
            rows.put(side, 3, v, so3::hat(&apart) * (sign * reduced));
        }
        rows
    }

    /// How two bodies that are one move against each other: the second's centre of mass against the first's axes, and how
    /// much faster the second turns.
    pub fn slip(states: [&State; 2]) -> Self {
        let mut rows = Self::zeros();
        let [x, r, v, w] = PARTS;
        let arm = states[1].position_m - states[0].position_m;
        for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let state = states[side];
            let to_world = so3::matrix(&state.orientation);
            let turning = so3::hat(&state.angular_velocity_rad_s);
            rows.add(0, state.velocity_m_s * sign);
            rows.put(side, 0, v, Matrix3::identity() * sign);
            rows.add(3, to_world * state.angular_velocity_rad_s * sign);
            let by = [to_world * turning * -sign, to_world * sign];
            rows.put(side, 3, r, by[0]);
            rows.put(side, 3, w, by[1]);
        }
        let omega = states[0].orientation * states[0].angular_velocity_rad_s;
        rows.add(0, -omega.cross(&arm));
        for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
            rows.put(side, 0, x, so3::hat(&omega) * sign);
        }
        // −δω × arm = arm × δω.
        let to_world = so3::matrix(&states[0].orientation);
        let turning = so3::hat(&states[0].angular_velocity_rad_s);
        rows.put(0, 0, r, -so3::hat(&arm) * to_world * turning);
        rows.put(0, 0, w, so3::hat(&arm) * to_world);
        rows
    }
}

#[cfg(test)]
mod tests;
