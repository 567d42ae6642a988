//! The quantities of conditions with their derivatives by the states of the bodies they are of.
//!
//! With right perturbations, `y` seen from a body B, and a point `p` of the body A,
//!
//! ```text
//! y = R_Bᵀ (x_A + R_A p − x_B)     δy = R_Bᵀ (δx_A − R_A [p]× δθ_A − δx_B) + [y]× δθ_B
//! e = Log(R₀ᵀ R_Bᵀ R_A)            δe = J_r⁻¹(e) (δθ_A − R_Aᵀ R_B δθ_B)
//! d = R_Bᵀ R_A a                   δd = −R_Bᵀ R_A [a]× δθ_A + [d]× δθ_B
//! v + R (ω × p)                    δv − R [ω × p]× δθ − R [p]× δω
//! ```

use nalgebra::{Matrix3, SMatrix, Vector3};

use crate::math::so3;
use crate::motion::{Axes, GoalQuantity};
use crate::physics::State;
use crate::physics::contact::Feature;
use crate::physics::state::part;

/// Derivatives of a vector by a state.
pub(in crate::estimate) type ByState = SMatrix<f64, 3, 12>;

/// A quantity with its derivatives.
#[derive(Clone, Debug)]
pub(in crate::estimate) struct Valued {
    pub(in crate::estimate) value: Vector3<f64>,
    /// By the state of the body, and of that in whose axes it is seen.
    pub(in crate::estimate) by: [ByState; 2],
    /// By the point [body axes].
    pub(in crate::estimate) by_point: Matrix3<f64>,
}

impl Valued {
    fn of(value: Vector3<f64>) -> Self {
        Self {
            value,
            by: [ByState::zeros(); 2],
            by_point: Matrix3::zeros(),
        }
    }

    /// Its point moves with the poses of both bodies: derivatives of that by these.
    pub(in crate::estimate) fn follow(&mut self, point_by: &[SMatrix<f64, 3, 6>]) {
        for (by, of) in self.by.iter_mut().zip(point_by) {
            let mut pose = by.fixed_columns_mut::<6>(part::POSITION);
            pose += self.by_point * of;
        }
    }

    fn set(&mut self, side: usize, part: usize, by: Matrix3<f64>) {
        self.by[side].fixed_view_mut::<3, 3>(0, part).copy_from(&by);
    }
}

/// The quantity at the state of the body and of the one in whose axes it is seen, about a point
/// [m, body axes]. A time has no states.
pub(in crate::estimate) fn valued(
    quantity: &GoalQuantity,
    body: &State,
    other: Option<&State>,
    point_m: &Vector3<f64>,
) -> Valued {
    let hat = so3::hat;
    let rotation = so3::matrix(&body.orientation);
    let frame = other.map_or_else(Matrix3::identity, |other| so3::matrix(&other.orientation));
    let seen = frame.tr_mul(&rotation);
    match quantity {
        GoalQuantity::Position { .. } => {
            let origin_m = other.map_or_else(Vector3::zeros, |other| other.position_m);
            let place_m = frame.tr_mul(&(body.position_m + rotation * point_m - origin_m));
            let mut valued = Valued::of(place_m);
            valued.set(0, part::POSITION, frame.transpose());
            valued.set(0, part::ORIENTATION, -seen * hat(point_m));
            if other.is_some() {
                valued.set(1, part::POSITION, -frame.transpose());
                valued.set(1, part::ORIENTATION, hat(&place_m));
            }
            valued.by_point = seen;
            valued
        }
        GoalQuantity::Turn { from, .. } => {
            let seen_turn = match other {
                Some(other) => other.orientation.inverse() * body.orientation,
                None => body.orientation,
            };
            let turn = so3::log(&(from.inverse() * seen_turn));
            let by = so3::right_jacobian_inverse(&turn);
            let mut valued = Valued::of(turn);
            valued.set(0, part::ORIENTATION, by);
            if other.is_some() {
                valued.set(1, part::ORIENTATION, -by * seen.transpose());
            }
            valued
        }
        GoalQuantity::Direction { axis, towards, .. } => {
            let direction = seen * axis;
            let (value, by_direction) = off(&direction, towards);
            let mut valued = Valued::of(value);
            valued.set(0, part::ORIENTATION, -by_direction * seen * hat(axis));
            if other.is_some() {
                valued.set(1, part::ORIENTATION, by_direction * hat(&direction));
            }
            valued
        }
        GoalQuantity::Velocity { .. } => {
            let omega = &body.angular_velocity_rad_s;
            let arm = omega.cross(point_m);
            let mut valued = Valued::of(body.velocity_m_s + rotation * arm);
            valued.set(0, part::VELOCITY, Matrix3::identity());
            valued.set(0, part::ORIENTATION, -rotation * hat(&arm));
            valued.set(0, part::ANGULAR_VELOCITY, -rotation * hat(point_m));
            valued.by_point = rotation * hat(omega);
            valued
        }
        GoalQuantity::Spin { axes } => {
            let omega = &body.angular_velocity_rad_s;
            let mut valued = Valued::of(*omega);
            valued.set(0, part::ANGULAR_VELOCITY, Matrix3::identity());
            if *axes == Axes::World {
                valued = Valued::of(rotation * omega);
                valued.set(0, part::ANGULAR_VELOCITY, rotation);
                valued.set(0, part::ORIENTATION, -rotation * hat(omega));
            }
            valued
        }
        // Neither is of a body's state.
        GoalQuantity::Angles { .. } | GoalQuantity::Time { .. } => Valued::of(Vector3::zeros()),
    }
}

/// How far a unit direction `d` is from another, `u`, along two tangents `t` of that, and the
/// derivative by `d`: `y_i = k t_i·d` with `k = φ/sin φ` and the angle `φ` between them.
fn off(direction: &Vector3<f64>, towards: &Vector3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
    /// Sine below which series are used.
    const SMALL: f64 = 1e-4;
    /// Least sine: opposite directions are any way apart.
    const LEAST: f64 = 1e-9;
    let [first, second] = Feature::tangents(towards);
    let [a, b] = [first.dot(direction), second.dot(direction)];
    let (sine, cosine) = (a.hypot(b), towards.dot(direction));
    let angle = sine.atan2(cosine);
    // `k`, and its derivative by the cosine, `−dk/dφ / sin φ`.
    let (k, by_cosine) = if cosine > 0.0 && sine < SMALL {
        let square = sine * sine;
        (1.0 + square / 6.0, -(1.0 / 3.0 + 2.0 / 15.0 * square))
    } else {
        let sine = sine.max(LEAST);
        let k = angle / sine;
        (k, -(1.0 - k * cosine) / (sine * sine))
    };
    let value = Vector3::new(k * a, k * b, 0.0);
    let row = |tangent: &Vector3<f64>, along: f64| {
        (tangent * k + towards * (by_cosine * along)).transpose()
    };
    let by = Matrix3::from_rows(&[
        row(&first, a),
        row(&second, b),
        Vector3::zeros().transpose(),
    ]);
    (value, by)
}
