//! A state with its rates, of a body that something drives.

use nalgebra::Vector3;

use super::state::State;

/// A state with its rates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Driven {
    /// The state.
    pub state: State,
    /// Its acceleration [m/s², world].
    pub acceleration_m_s2: Vector3<f64>,
    /// Its angular acceleration [rad/s², body].
    pub angular_acceleration_rad_s2: Vector3<f64>,
}

impl Driven {
    /// The same motion where time passes `rate` times as fast.
    pub fn at_rate(&self, rate: f64) -> Self {
        Self {
            state: State {
                velocity_m_s: self.state.velocity_m_s * rate,
                angular_velocity_rad_s: self.state.angular_velocity_rad_s * rate,
                ..self.state
            },
            acceleration_m_s2: self.acceleration_m_s2 * (rate * rate),
            angular_acceleration_rad_s2: self.angular_acceleration_rad_s2 * (rate * rate),
        }
    }
}
