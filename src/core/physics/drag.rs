//! Resistance of the air to the motion of a body's centre of mass.

use nalgebra::{Matrix3, Vector3};

/// Drag per mass: it slows a body that moves with `v` down by `(k + c|v|) v`.
///
/// A ball of radius `r` and mass `m` in air of density `ρ` has `c = ρ C π r²/(2 m)` with a drag
/// coefficient `C` of about 0.47: 0.13/m for a table-tennis ball. The linear part is that of slow
/// or small bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drag {
    /// `k` \[1/s\], zero or more.
    pub linear_per_s: f64,
    /// `c` \[1/m\], zero or more.
    pub quadratic_per_m: f64,
}

impl Drag {
    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        self.linear_per_s == 0.0 && self.quadratic_per_m == 0.0
    }

    /// `k + c|v|` \[1/s\].
    pub fn rate_per_s(&self, velocity_m_s: &Vector3<f64>) -> f64 {
        self.linear_per_s + self.quadratic_per_m * velocity_m_s.norm()
    }

    /// `−(k + c|v|) v` [m/s²].
    pub fn acceleration_m_s2(&self, velocity_m_s: &Vector3<f64>) -> Vector3<f64> {
        -(velocity_m_s * self.rate_per_s(velocity_m_s))
    }

    /// Derivative of the acceleration by the velocity, `−(k + c|v|) 1 − c v vᵀ/|v|` \[1/s\].
    pub fn acceleration_by_velocity_per_s(&self, velocity_m_s: &Vector3<f64>) -> Matrix3<f64> {
        let speed_m_s = velocity_m_s.norm();
        let mut result = Matrix3::from_diagonal_element(-self.rate_per_s(velocity_m_s));
        if speed_m_s > 0.0 {
            let along = velocity_m_s * (-self.quadratic_per_m / speed_m_s);
            result += along * velocity_m_s.transpose();
        }
        result
    }
}
