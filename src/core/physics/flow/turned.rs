//! The result of a free rotation.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Orientation and angular velocity after a free rotation, with their derivatives. Changes of
/// orientations are right perturbations.
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
    /// Change of `ω(s)` per change of `ω(0)`.
    pub angular_velocity_by_angular_velocity: Matrix3<f64>,
}
