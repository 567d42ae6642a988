//! A body as a contact feels it: velocity of the point, answer to an impulse, and how both
//! change as the body turns and the point wanders over it.

use nalgebra::{Matrix3, Vector3};

use super::meeting::{Side, Velocities};
use crate::math::so3;

/// A body and its point of contact. The static world is a body of infinite mass at rest.
#[derive(Clone, Copy)]
pub(super) struct Arm {
    /// World from body.
    pub(super) rotation: Matrix3<f64>,
    inverse_mass: f64,
    inverse_moments: Vector3<f64>,
    /// Point of contact `p` [m, body].
    point: Vector3<f64>,
}

/// How the pose of a body and its point of contact vary.
#[derive(Clone, Copy)]
pub(super) struct ArmVariation {
    /// Turn `φ` [rad, world].
    pub(super) turn: Vector3<f64>,
    /// Change of the point [m, body].
    pub(super) point: Vector3<f64>,
}

impl Arm {
    pub(super) fn new(side: Option<&Side>, point: &Vector3<f64>) -> Self {
        Self {
            rotation: side.map_or_else(Matrix3::identity, |s| so3::matrix(&s.state.orientation)),
            inverse_mass: side.map_or(0.0, |s| 1.0 / s.body.mass_kg()),
            inverse_moments: side
                .map_or_else(Vector3::zeros, |s| s.body.moments_kg_m2().map(|i| 1.0 / i)),
            point: *point,
        }
    }

    /// `v + R (ω × p)`: the point's velocity when the body moves so [m/s, world].
    pub(super) fn point_velocity(&self, motion: &Velocities) -> Vector3<f64> {
        motion.velocity_m_s + self.rotation * motion.angular_velocity_rad_s.cross(&self.point)
    }

    /// Change of [`Self::point_velocity`] at fixed `v` and `ω`.
    pub(super) fn point_velocity_change(
        &self,
        motion: &Velocities,
        by: &ArmVariation,
    ) -> Vector3<f64> {
        let omega = &motion.angular_velocity_rad_s;
        by.turn.cross(&(self.rotation * omega.cross(&self.point)))
            + self.rotation * omega.cross(&by.point)
    }

    /// `P/m` and `I⁻¹ (p × RᵀP)`: what an impulse `P` [N s, world] at the point adds.
    pub(super) fn kick(&self, impulse: &Vector3<f64>) -> Velocities {
        let torque = self.point.cross(&self.rotation.tr_mul(impulse));
        Velocities {
            velocity_m_s: impulse * self.inverse_mass,
            angular_velocity_rad_s: self.inverse_moments.component_mul(&torque),
        }
    }

    /// Change of [`Self::kick`] as the impulse changes too.
    pub(super) fn kick_change(
        &self,
        impulse: &Vector3<f64>,
        impulse_change: &Vector3<f64>,
        by: &ArmVariation,
    ) -> Velocities {
        let in_body = self.rotation.tr_mul(impulse);
        let changed = self
            .rotation
            .tr_mul(&(impulse_change - by.turn.cross(impulse)));
        let torque = by.point.cross(&in_body) + self.point.cross(&changed);
        Velocities {
            velocity_m_s: impulse_change * self.inverse_mass,
            angular_velocity_rad_s: self.inverse_moments.component_mul(&torque),
        }
    }

    /// Velocity of the point per impulse at it [1/kg, world]: symmetric, positive definite for
    /// a body, zero for the world.
    pub(super) fn mobility(&self) -> Matrix3<f64> {
        let of = |axis| self.point_velocity(&self.kick(&Vector3::ith(axis, 1.0)));
        Matrix3::from_columns(&[of(0), of(1), of(2)])
    }

    /// Change of the mobility, times `impulse`.
    pub(super) fn mobility_change(
        &self,
        impulse: &Vector3<f64>,
        by: &ArmVariation,
    ) -> Vector3<f64> {
        self.point_velocity_change(&self.kick(impulse), by)
            + self.point_velocity(&self.kick_change(impulse, &Vector3::zeros(), by))
    }
}
