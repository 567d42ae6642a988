//! How a free body flies: the map (state, duration) → state, with its derivatives.
//!
//! The centre of mass is quadratic in time. A body with two equal moments `I_t` and a third
//! `I_a` about its axis `a` turns as
//!
//! ```text
//! R(s) = R·Exp(α s)·Exp(β s a),   ω(s) = Exp(−β s a) ω,
//! α = I_t⁻¹ I ω,   β = (1 − I_a/I_t) ω_a
//! ```
//!
//! exact for any duration of either sign; three equal moments are the case `I_a = I_t`. The
//! derivatives are those of these formulas, in right perturbations.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::body::{Body, Symmetry};
use super::state::{State, StateTangent, part};
use crate::math::so3;

/// State after `duration_s` of free flight (negative: before).
pub fn advance(body: &Body, gravity_m_s2: &Vector3<f64>, state: &State, duration_s: f64) -> State {
    let turn = turn(
        body,
        &state.orientation,
        &state.angular_velocity_rad_s,
        duration_s,
    );
    State {
        position_m: position(gravity_m_s2, state, duration_s),
        orientation: turn.orientation,
        velocity_m_s: state.velocity_m_s + gravity_m_s2 * duration_s,
        angular_velocity_rad_s: turn.angular_velocity_rad_s,
    }
}

/// Centre of mass after `duration_s` [m, world].
pub fn position(gravity_m_s2: &Vector3<f64>, state: &State, duration_s: f64) -> Vector3<f64> {
    state.position_m + (state.velocity_m_s + gravity_m_s2 * (0.5 * duration_s)) * duration_s
}

/// Time derivative of the state under free flight, in its own tangent space.
pub fn rate(body: &Body, gravity_m_s2: &Vector3<f64>, state: &State) -> StateTangent {
    let omega = &state.angular_velocity_rad_s;
    let mut rate = StateTangent::zeros();
    rate.fixed_rows_mut::<3>(part::POSITION)
        .copy_from(&state.velocity_m_s);
    rate.fixed_rows_mut::<3>(part::ORIENTATION).copy_from(omega);
    rate.fixed_rows_mut::<3>(part::VELOCITY)
        .copy_from(gravity_m_s2);
    let turning = Turning::of(body);
    rate.fixed_rows_mut::<3>(part::ANGULAR_VELOCITY)
        .copy_from(&(-turning.precession(omega) * turning.axis.cross(omega)));
    rate
}

/// The free turn of one angular velocity, for many durations.
#[derive(Clone, Debug)]
pub struct Spin {
    turning: Turning,
    alpha: Vector3<f64>,
    beta: f64,
}

impl Spin {
    /// The turn that begins with `ω` [rad/s, body].
    pub fn new(body: &Body, angular_velocity_rad_s: &Vector3<f64>) -> Self {
        let turning = Turning::of(body);
        Self {
            alpha: turning.scale.component_mul(angular_velocity_rad_s),
            beta: turning.precession(angular_velocity_rad_s),
            turning,
        }
    }

    /// `R(0)⁻¹R(s)`, and the `K` by which a change of `ω` turns `R(s)` by `s K δω`, seen from
    /// the frame of `R(0)`. Since `ω` turns with the body, `K ω` is `ω(s)` in that frame.
    #[inline]
    pub fn turn_and_derivative(&self, duration_s: f64) -> (UnitQuaternion<f64>, Matrix3<f64>) {
        let (first, mut k) = so3::exp_and_left_jacobian(&(self.alpha * duration_s));
        if self.turning.excess == 0.0 {
            return (first, k);
        }
        let axis = &self.turning.axis;
        for column in 0..3 {
            k.column_mut(column).scale_mut(self.turning.scale[column]);
        }
        k += (first * axis) * (axis * self.turning.excess).transpose();
        (first * so3::exp(&(axis * (self.beta * duration_s))), k)
    }
}

/// Orientation and angular velocity after a free turn, with their derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    /// `R(s)`.
    pub orientation: UnitQuaternion<f64>,
    /// `ω(s)` [rad/s, body].
    pub angular_velocity_rad_s: Vector3<f64>,
    /// Change of `R(s)` \[rad\] per change of `R(0)` \[rad\].
    pub orientation_by_orientation: Matrix3<f64>,
    /// Change of `R(s)` \[rad\] per change of `ω(0)` [rad/s].
    pub orientation_by_angular_velocity: Matrix3<f64>,
}

/// `I = I_t·diag(…)`, as the flow needs it.
#[derive(Clone, Debug)]
struct Turning {
    axis: Vector3<f64>,
    /// `I_t⁻¹ I`, diagonal.
    scale: Vector3<f64>,
    /// `1 − I_a/I_t`.
    excess: f64,
}

impl Turning {
    fn of(body: &Body) -> Self {
        match body.symmetry() {
            Symmetry::Spherical => Self {
                axis: Vector3::z(),
                scale: Vector3::repeat(1.0),
                excess: 0.0,
            },
            Symmetry::Axial { axis } => {
                let moments = body.moments_kg_m2();
                let transverse = moments[(axis + 1) % 3];
                Self {
                    axis: Vector3::ith(axis, 1.0),
                    scale: moments / transverse,
                    excess: (transverse - moments[axis]) / transverse,
                }
            }
        }
    }

    /// `β` [rad/s].
    fn precession(&self, omega: &Vector3<f64>) -> f64 {
        self.excess * self.axis.dot(omega)
    }
}

/// Free turn for `duration_s`, with derivatives.
pub fn turn(
    body: &Body,
    orientation: &UnitQuaternion<f64>,
    angular_velocity_rad_s: &Vector3<f64>,
    duration_s: f64,
) -> Turn {
    let turning = Turning::of(body);
    let alpha = turning.scale.component_mul(angular_velocity_rad_s) * duration_s;
    let (first, first_jacobian) = so3::exp_and_right_jacobian(&alpha);
    let mut by_angular_velocity = first_jacobian;
    for column in 0..3 {
        by_angular_velocity
            .column_mut(column)
            .scale_mut(duration_s * turning.scale[column]);
    }
    if turning.excess == 0.0 {
        return Turn {
            orientation: orientation * first,
            angular_velocity_rad_s: *angular_velocity_rad_s,
            orientation_by_orientation: so3::matrix(&first).transpose(),
            orientation_by_angular_velocity: by_angular_velocity,
        };
    }
    let beta = turning.precession(angular_velocity_rad_s) * duration_s;
    let second = so3::exp(&(turning.axis * beta));
    let second_transposed = so3::matrix(&second).transpose();
    let mut by_angular_velocity = second_transposed * by_angular_velocity;
    by_angular_velocity += turning.axis * turning.axis.transpose() * (turning.excess * duration_s);
    Turn {
        orientation: orientation * first * second,
        angular_velocity_rad_s: second_transposed * angular_velocity_rad_s,
        orientation_by_orientation: second_transposed * so3::matrix(&first).transpose(),
        orientation_by_angular_velocity: by_angular_velocity,
    }
}

/// Change of `ω(s)` per change of `ω(0)`, given the turned `ω(s)` [rad/s, body].
pub fn angular_velocity_by_angular_velocity(
    body: &Body,
    angular_velocity_rad_s: &Vector3<f64>,
    duration_s: f64,
) -> Matrix3<f64> {
    let turning = Turning::of(body);
    if turning.excess == 0.0 {
        return Matrix3::identity();
    }
    let beta = turning.precession(angular_velocity_rad_s) * duration_s;
    let back = so3::matrix(&so3::exp(&(turning.axis * -beta)));
    let turned = back * angular_velocity_rad_s;
    back - turning.axis.cross(&turned) * turning.axis.transpose() * (turning.excess * duration_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::differentiate;

    fn bodies() -> Vec<Body> {
        [
            Vector3::new(2e-4, 2e-4, 2e-4),
            Vector3::new(1.8e-5, 1.8e-5, 4e-8),
            Vector3::new(3e-3, 5e-3, 3e-3),
            Vector3::new(1.0, 0.6, 0.6),
        ]
        .iter()
        .map(|moments| Body::new(0.01, *moments).unwrap())
        .collect()
    }

    fn state() -> State {
        State {
            position_m: Vector3::new(0.1, -0.2, 0.9),
            orientation: UnitQuaternion::from_euler_angles(0.4, -1.1, 2.0),
            velocity_m_s: Vector3::new(0.5, 1.5, -2.0),
            angular_velocity_rad_s: Vector3::new(3.0, -7.0, 5.0),
        }
    }

    const GRAVITY: Vector3<f64> = Vector3::new(0.1, 0.2, -9.81);

    /// Euler's equations and the quaternion's kinematics by classic Runge–Kutta: shares no
    /// formula with the closed form.
    fn integrate(body: &Body, state: &State, duration_s: f64) -> State {
        let moments = body.moments_kg_m2();
        let slope = |q: &nalgebra::Quaternion<f64>, w: &Vector3<f64>| {
            let torque_free = -w.cross(&moments.component_mul(w)).component_div(&moments);
            (q * nalgebra::Quaternion::from_imag(w * 0.5), torque_free)
        };
        let steps = 4000;
        let h = duration_s / f64::from(steps);
        let (mut q, mut w) = (state.orientation.into_inner(), state.angular_velocity_rad_s);
        for _ in 0..steps {
            let (q1, w1) = slope(&q, &w);
            let (q2, w2) = slope(&(q + q1 * (h / 2.0)), &(w + w1 * (h / 2.0)));
            let (q3, w3) = slope(&(q + q2 * (h / 2.0)), &(w + w2 * (h / 2.0)));
            let (q4, w4) = slope(&(q + q3 * h), &(w + w3 * h));
            q += (q1 + q2 * 2.0 + q3 * 2.0 + q4) * (h / 6.0);
            w += (w1 + w2 * 2.0 + w3 * 2.0 + w4) * (h / 6.0);
        }
        State {
            position_m: state.position_m
                + state.velocity_m_s * duration_s
                + GRAVITY * (duration_s * duration_s / 2.0),
            orientation: UnitQuaternion::new_normalize(q),
            velocity_m_s: state.velocity_m_s + GRAVITY * duration_s,
            angular_velocity_rad_s: w,
        }
    }

    #[test]
    fn closed_form_agrees_with_numerical_integration() {
        for body in bodies() {
            for duration_s in [0.5, -0.3, 0.0] {
                let exact = advance(&body, &GRAVITY, &state(), duration_s);
                let numeric = integrate(&body, &state(), duration_s);
                assert!(
                    exact.minus(&numeric).norm() < 1e-10,
                    "{body:?} {duration_s}"
                );
            }
        }
    }

    #[test]
    fn flow_composes_and_inverts_to_rounding() {
        for body in bodies() {
            let there = advance(&body, &GRAVITY, &state(), 0.4);
            let at_once = advance(&body, &GRAVITY, &state(), 1.1);
            assert!(advance(&body, &GRAVITY, &there, 0.7).minus(&at_once).norm() < 2e-14);
            assert!(
                advance(&body, &GRAVITY, &there, -0.4)
                    .minus(&state())
                    .norm()
                    < 1e-14
            );
        }
    }

    #[test]
    fn turn_derivatives_are_exact() {
        for body in bodies() {
            for duration_s in [0.31, -0.2, 0.0] {
                let base = advance(&body, &GRAVITY, &state(), duration_s);
                let numeric = differentiate::jacobian(12, 12, |d| {
                    let moved = state().retract(&StateTangent::from_column_slice(d));
                    advance(&body, &GRAVITY, &moved, duration_s)
                        .minus(&base)
                        .as_slice()
                        .to_vec()
                });
                let turn = turn(
                    &body,
                    &state().orientation,
                    &state().angular_velocity_rad_s,
                    duration_s,
                );
                let omega = angular_velocity_by_angular_velocity(
                    &body,
                    &state().angular_velocity_rad_s,
                    duration_s,
                );
                let mut exact = nalgebra::SMatrix::<f64, 12, 12>::identity();
                exact.fixed_view_mut::<3, 3>(0, 6).fill_diagonal(duration_s);
                exact
                    .fixed_view_mut::<3, 3>(3, 3)
                    .copy_from(&turn.orientation_by_orientation);
                exact
                    .fixed_view_mut::<3, 3>(3, 9)
                    .copy_from(&turn.orientation_by_angular_velocity);
                exact.fixed_view_mut::<3, 3>(9, 9).copy_from(&omega);
                for i in 0..12 {
                    for j in 0..12 {
                        assert!(
                            (numeric[i][j] - exact[(i, j)]).abs() < 2e-9,
                            "{body:?} {i} {j}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn spin_agrees_with_turn_seen_from_the_epoch() {
        for body in bodies() {
            let omega = state().angular_velocity_rad_s;
            let spin = Spin::new(&body, &omega);
            for duration_s in [0.31, -0.2, 0.0] {
                let turn = turn(&body, &state().orientation, &omega, duration_s);
                let (rotation, k) = spin.turn_and_derivative(duration_s);
                assert!((state().orientation * rotation).angle_to(&turn.orientation) < 1e-14);
                let carried = turn.orientation_by_orientation.transpose()
                    * turn.orientation_by_angular_velocity;
                assert!((carried - k * duration_s).norm() < 1e-14);
                let seen =
                    turn.orientation_by_orientation.transpose() * turn.angular_velocity_rad_s;
                assert!((seen - k * omega).norm() < 1e-13);
            }
        }
    }

    #[test]
    fn rate_is_the_time_derivative() {
        for body in bodies() {
            let there = advance(&body, &GRAVITY, &state(), 0.4);
            let numeric = differentiate::jacobian(12, 1, |d| {
                advance(&body, &GRAVITY, &state(), 0.4 + d[0])
                    .minus(&there)
                    .as_slice()
                    .to_vec()
            });
            let exact = rate(&body, &GRAVITY, &there);
            for i in 0..12 {
                assert!((numeric[i][0] - exact[i]).abs() < 1e-8, "{body:?} {i}");
            }
        }
    }
}
