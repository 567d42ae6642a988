//! The state of a free rigid body and its tangent space.

use nalgebra::{SMatrix, SVector, UnitQuaternion, Vector3};

use crate::math::{Pose, so3};

/// Number of directions in which a [`State`] may change.
pub const DIMENSION: usize = 12;

/// Tangent of a [`State`]: position [m, world], orientation [rad, body, right], velocity
/// [m/s, world], angular velocity [rad/s, body], in this order.
pub type StateTangent = SVector<f64, DIMENSION>;

/// Derivatives of a state by a state.
pub type ByStates = SMatrix<f64, DIMENSION, DIMENSION>;

/// Where the parts of a [`StateTangent`] begin.
pub mod part {
    /// Position.
    pub const POSITION: usize = 0;
    /// Orientation.
    pub const ORIENTATION: usize = 3;
    /// Velocity.
    pub const VELOCITY: usize = 6;
    /// Angular velocity.
    pub const ANGULAR_VELOCITY: usize = 9;
}

/// Position and velocity of a rigid body at its centre of mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Centre of mass `x` [m, world].
    pub position_m: Vector3<f64>,
    /// `R`, world from body.
    pub orientation: UnitQuaternion<f64>,
    /// `v` [m/s, world].
    pub velocity_m_s: Vector3<f64>,
    /// `ω` [rad/s, body].
    pub angular_velocity_rad_s: Vector3<f64>,
}

impl State {
    /// At rest at the origin.
    pub fn at_rest() -> Self {
        Self {
            position_m: Vector3::zeros(),
            orientation: UnitQuaternion::identity(),
            velocity_m_s: Vector3::zeros(),
            angular_velocity_rad_s: Vector3::zeros(),
        }
    }

    /// `q ⊞ δ = (x + δx, R·Exp(δθ), v + δv, ω + δω)`.
    pub fn retract(&self, delta: &StateTangent) -> State {
        State {
            position_m: self.position_m + delta.fixed_rows::<3>(part::POSITION),
            orientation: renormalised(
                self.orientation * so3::exp(&delta.fixed_rows::<3>(part::ORIENTATION).into()),
            ),
            velocity_m_s: self.velocity_m_s + delta.fixed_rows::<3>(part::VELOCITY),
            angular_velocity_rad_s: self.angular_velocity_rad_s
                + delta.fixed_rows::<3>(part::ANGULAR_VELOCITY),
        }
    }

    /// `q ⊟ p` with `p = origin`: the tangent `δ` for which `p ⊞ δ = q`.
    pub fn minus(&self, origin: &State) -> StateTangent {
        let mut delta = StateTangent::zeros();
        delta
            .fixed_rows_mut::<3>(part::POSITION)
            .copy_from(&(self.position_m - origin.position_m));
        delta
            .fixed_rows_mut::<3>(part::ORIENTATION)
            .copy_from(&so3::log(
                &(origin.orientation.inverse() * self.orientation),
            ));
        delta
            .fixed_rows_mut::<3>(part::VELOCITY)
            .copy_from(&(self.velocity_m_s - origin.velocity_m_s));
        delta
            .fixed_rows_mut::<3>(part::ANGULAR_VELOCITY)
            .copy_from(&(self.angular_velocity_rad_s - origin.angular_velocity_rad_s));
        delta
    }

    /// The pose of the body's axes.
    pub fn world_from_body(&self) -> Pose {
        Pose::from_parts(self.position_m.into(), self.orientation)
    }

    /// Whether every number in it is finite.
    pub fn is_finite(&self) -> bool {
        self.position_m.iter().all(|x| x.is_finite())
            && self.orientation.coords.iter().all(|x| x.is_finite())
            && self.velocity_m_s.iter().all(|x| x.is_finite())
            && self.angular_velocity_rad_s.iter().all(|x| x.is_finite())
    }
}

/// One Newton step back to unit norm: enough after a product of unit quaternions, and it
/// leaves an exactly unit one as it is.
fn renormalised(q: UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    let q = q.into_inner();
    UnitQuaternion::new_unchecked(q * (1.5 - 0.5 * q.norm_squared()))
}
