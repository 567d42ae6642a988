//! The free rotation of a body with two or three equal moments, in closed form.
//!
//! A body with two equal moments `I_t` and a third `I_a` about its axis `a` turns as
//!
//! ```text
//! R(s) = R·Exp(α s)·Exp(β s a),   ω(s) = Exp(−β s a) ω,
//! α = I_t⁻¹ I ω,   β = (1 − I_a/I_t) ω_a
//! ```
//!
//! exact for any duration of either sign; three equal moments are the case `I_a = I_t`. Derivatives
//! follow by differentiating these formulas, with `J_r` and `J_l` of [`so3`](crate::math::so3).

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::turned::Turn;
use crate::math::so3;
use crate::physics::body::{Body, Symmetry};

/// Symmetry axis and ratios of moments of a body with two or three equal moments.
#[derive(Clone, Debug)]
pub struct Turning {
    /// Symmetry axis `a`, in body axes.
    pub axis: Vector3<f64>,
    /// Diagonal of `I_t⁻¹ I`.
    scale: Vector3<f64>,
    /// `1 − I_a/I_t`.
    pub excess: f64,
}

impl Turning {
    /// The ratios of a body. Panics where its three moments differ.
    pub fn of(body: &Body) -> Self {
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
            Symmetry::Asymmetric => unreachable!("three different moments have no such form"),
        }
    }

    /// `β` [rad/s].
    fn precession(&self, omega: &Vector3<f64>) -> f64 {
        self.excess * self.axis.dot(omega)
    }

    /// `R(0)⁻¹R(s)` and `ω(s)` [rad/s, body].
    pub fn advance(
        &self,
        omega: &Vector3<f64>,
        duration_s: f64,
    ) -> (UnitQuaternion<f64>, Vector3<f64>) {
        let first = so3::exp(&(self.scale.component_mul(omega) * duration_s));
        if self.excess == 0.0 {
            return (first, *omega);
        }
        let second = so3::exp(&(self.axis * (self.precession(omega) * duration_s)));
        (first * second, second.inverse_transform_vector(omega))
    }

    /// Orientation and angular velocity after `duration_s`, with derivatives.
    pub fn turn(
        &self,
        orientation: &UnitQuaternion<f64>,
        omega: &Vector3<f64>,
        duration_s: f64,
    ) -> Turn {
        let alpha = self.scale.component_mul(omega) * duration_s;
        let (first, mut by_angular_velocity) = so3::exp_and_right_jacobian(&alpha);
        for column in 0..3 {
            by_angular_velocity
                .column_mut(column)
                .scale_mut(duration_s * self.scale[column]);
        }
        if self.excess == 0.0 {
            return Turn {
                orientation: orientation * first,
                angular_velocity_rad_s: *omega,
                orientation_by_orientation: so3::matrix(&first).transpose(),
                orientation_by_angular_velocity: by_angular_velocity,
                angular_velocity_by_angular_velocity: Matrix3::identity(),
            };
        }
        let second = so3::exp(&(self.axis * (self.precession(omega) * duration_s)));
        let back = so3::matrix(&second).transpose();
        let turned = back * omega;
        let along = self.axis.transpose() * (self.excess * duration_s);
        Turn {
            orientation: orientation * first * second,
            angular_velocity_rad_s: turned,
            orientation_by_orientation: back * so3::matrix(&first).transpose(),
            orientation_by_angular_velocity: back * by_angular_velocity + self.axis * along,
            angular_velocity_by_angular_velocity: back - self.axis.cross(&turned) * along,
        }
    }
}

/// The free rotation from one initial angular velocity.
#[derive(Clone, Debug)]
pub struct Precession {
    /// Axis and ratios of the body.
    pub turning: Turning,
    /// `α` [rad/s, body].
    pub alpha: Vector3<f64>,
    /// `β` [rad/s].
    pub beta: f64,
}

impl Precession {
    /// The rotation with the initial angular velocity `ω` [rad/s, body].
    pub fn new(body: &Body, angular_velocity_rad_s: &Vector3<f64>) -> Self {
        let turning = Turning::of(body);
        Self {
            alpha: turning.scale.component_mul(angular_velocity_rad_s),
            beta: turning.precession(angular_velocity_rad_s),
            turning,
        }
    }

    /// `R(0)⁻¹R(s)`, the same bits as by [`Turning::advance`].
    pub fn turn(&self, duration_s: f64) -> UnitQuaternion<f64> {
        let first = so3::exp(&(self.alpha * duration_s));
        if self.turning.excess == 0.0 {
            return first;
        }
        first * so3::exp(&(self.turning.axis * (self.beta * duration_s)))
    }

    /// See [`super::Spin::turn_and_derivative`]; here
    /// `K = J_l(αs) I_t⁻¹I + (1 − I_a/I_t) Exp(αs) a aᵀ`.
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
