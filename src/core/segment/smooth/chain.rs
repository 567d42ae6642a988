//! What is smoothed: a value, its rate and its acceleration, of which the jerk is white noise.
//!
//! Places are vectors. Orientations are elements of SO(3) with errors `η` on the right,
//! `R = R̂ Exp(η)`, and angular velocities in the tracker's axes, so that `η̇ = −ω × η + δω`.

use nalgebra::{Matrix3, SMatrix, SVector, UnitQuaternion, Vector3};

use crate::math::so3;

/// Errors of value, rate and acceleration.
pub(super) type Nine = SVector<f64, 9>;
/// Their covariance, or how they depend on each other.
pub(super) type Nines = SMatrix<f64, 9, 9>;

/// A value with its rate and acceleration.
pub(super) trait Chain: Clone {
    /// What a sample shows of it.
    type Reading: Clone;

    /// A chain at a reading, with the rate to the next one after some time \[s\].
    fn begin(first: &Self::Reading, next: &Self::Reading, after_s: f64) -> Self;

    /// After a time with constant acceleration \[s\], and how errors grow in it.
    fn advance(&self, duration_s: f64) -> (Self, Nines);

    /// With an error added.
    fn retract(&self, error: &Nine) -> Self;

    /// The error that leads from `origin` to it.
    fn minus(&self, origin: &Self) -> Nine;

    /// The error of the value that leads to a reading.
    fn miss(&self, reading: &Self::Reading) -> Vector3<f64>;

    /// Distance of two readings.
    fn apart(first: &Self::Reading, next: &Self::Reading) -> f64;
}

/// Place, velocity, acceleration.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlaceChain {
    pub(super) position_m: Vector3<f64>,
    pub(super) velocity_m_s: Vector3<f64>,
    pub(super) acceleration_m_s2: Vector3<f64>,
}

/// Orientation, angular velocity, angular acceleration.
#[derive(Clone, Copy, Debug)]
pub(super) struct TurnChain {
    pub(super) orientation: UnitQuaternion<f64>,
    pub(super) spin_rad_s: Vector3<f64>,
    pub(super) spin_rate_rad_s2: Vector3<f64>,
}

fn nine(value: &Vector3<f64>, rate: &Vector3<f64>, acceleration: &Vector3<f64>) -> Nine {
    let mut nine = Nine::zeros();
    nine.fixed_rows_mut::<3>(0).copy_from(value);
    nine.fixed_rows_mut::<3>(3).copy_from(rate);
    nine.fixed_rows_mut::<3>(6).copy_from(acceleration);
    nine
}

fn part(of: &Nine, at: usize) -> Vector3<f64> {
    of.fixed_rows::<3>(at).into()
}

/// `[1 h h²/2; 0 1 h; 0 0 1]`, with the given first row.
fn transition(first: [Matrix3<f64>; 3], duration_s: f64) -> Nines {
    let mut by = Nines::identity();
    for (column, block) in first.iter().enumerate() {
        by.fixed_view_mut::<3, 3>(0, 3 * column).copy_from(block);
    }
    by.fixed_view_mut::<3, 3>(3, 6).fill_diagonal(duration_s);
    by
}

impl Chain for PlaceChain {
    type Reading = Vector3<f64>;

    fn begin(first: &Vector3<f64>, next: &Vector3<f64>, after_s: f64) -> Self {
        Self {
            position_m: *first,
            velocity_m_s: (next - first) / after_s,
            acceleration_m_s2: Vector3::zeros(),
        }
    }

    fn advance(&self, h: f64) -> (Self, Nines) {
        let there = Self {
            position_m: self.position_m
                + self.velocity_m_s * h
                + self.acceleration_m_s2 * (0.5 * h * h),
            velocity_m_s: self.velocity_m_s + self.acceleration_m_s2 * h,
            ..*self
        };
        let first = [1.0, h, 0.5 * h * h].map(Matrix3::from_diagonal_element);
        (there, transition(first, h))
    }

    fn retract(&self, error: &Nine) -> Self {
        Self {
            position_m: self.position_m + part(error, 0),
            velocity_m_s: self.velocity_m_s + part(error, 3),
            acceleration_m_s2: self.acceleration_m_s2 + part(error, 6),
        }
    }

    fn minus(&self, origin: &Self) -> Nine {
        nine(
            &(self.position_m - origin.position_m),
            &(self.velocity_m_s - origin.velocity_m_s),
            &(self.acceleration_m_s2 - origin.acceleration_m_s2),
        )
    }

    fn miss(&self, reading: &Vector3<f64>) -> Vector3<f64> {
        reading - self.position_m
    }

    fn apart(first: &Vector3<f64>, next: &Vector3<f64>) -> f64 {
        (next - first).norm()
    }
}

impl Chain for TurnChain {
    type Reading = UnitQuaternion<f64>;

    fn begin(first: &UnitQuaternion<f64>, next: &UnitQuaternion<f64>, after_s: f64) -> Self {
        Self {
            orientation: *first,
            spin_rad_s: so3::log(&(first.inverse() * next)) / after_s,
            spin_rate_rad_s2: Vector3::zeros(),
        }
    }

    /// By Magnus' series: `θ = ω h + ω̇ h²/2 + (ω × ω̇) h³/12`.
    fn advance(&self, h: f64) -> (Self, Nines) {
        let (spin, rate) = (&self.spin_rad_s, &self.spin_rate_rad_s2);
        let theta = spin * h + rate * (0.5 * h * h) + spin.cross(rate) * (h * h * h / 12.0);
        let (turn, right) = so3::exp_and_right_jacobian(&theta);
        let there = Self {
            orientation: renormalised(&(self.orientation * turn)),
            spin_rad_s: spin + rate * h,
            ..*self
        };
        let back = so3::matrix(&turn).transpose();
        let bend = (Matrix3::identity() - so3::hat(&theta) / 3.0) * (0.5 * h * h);
        (there, transition([back, right * h, bend], h))
    }

    fn retract(&self, error: &Nine) -> Self {
        Self {
            orientation: renormalised(&(self.orientation * so3::exp(&part(error, 0)))),
            spin_rad_s: self.spin_rad_s + part(error, 3),
            spin_rate_rad_s2: self.spin_rate_rad_s2 + part(error, 6),
        }
    }

    fn minus(&self, origin: &Self) -> Nine {
        nine(
            &so3::log(&(origin.orientation.inverse() * self.orientation)),
            &(self.spin_rad_s - origin.spin_rad_s),
            &(self.spin_rate_rad_s2 - origin.spin_rate_rad_s2),
        )
    }

    fn miss(&self, reading: &UnitQuaternion<f64>) -> Vector3<f64> {
        so3::log(&(self.orientation.inverse() * reading))
    }

    fn apart(first: &UnitQuaternion<f64>, next: &UnitQuaternion<f64>) -> f64 {
        first.angle_to(next)
    }
}

fn renormalised(turn: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::new_normalize(turn.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::differentiate::jacobian;

    fn check<C: Chain>(chain: &C, exact_to: f64) {
        let h = 0.02;
        let (there, by) = chain.advance(h);
        let scale = [1.0, 10.0, 100.0];
        let numeric = jacobian(9, 9, |delta| {
            let delta = Nine::from_fn(|row, _| delta[row] * scale[row / 3]);
            let moved = chain.retract(&delta).advance(h).0;
            moved.minus(&there).as_slice().to_vec()
        });
        for (row, numeric) in numeric.iter().enumerate() {
            for (column, numeric) in numeric.iter().enumerate() {
                let exact = by[(row, column)] * scale[column / 3];
                let off = numeric - exact;
                assert!(off.abs() < exact_to, "{row} {column}: {off} of {exact}");
            }
        }
    }

    #[test]
    fn errors_grow_as_the_chains_do() {
        let vector = |x: f64, y: f64, z: f64| Vector3::new(x, y, z);
        check(
            &PlaceChain {
                position_m: vector(0.1, 0.2, -0.3),
                velocity_m_s: vector(3.0, -1.0, 2.0),
                acceleration_m_s2: vector(10.0, 30.0, -20.0),
            },
            1e-11,
        );
        // With an acceleration, to the order of the step only.
        for (spin_rate, exact_to) in [(0.0, 2e-4), (30.0, 4e-3)] {
            check(
                &TurnChain {
                    orientation: so3::exp(&vector(0.3, -0.9, 1.1)),
                    spin_rad_s: vector(5.0, -8.0, 3.0),
                    spin_rate_rad_s2: vector(1.0, 0.5, -1.0) * spin_rate,
                },
                exact_to,
            );
        }
    }
}
