//! The state of a held body from that of the tracker on it.
//!
//! With the tracker's state `(x, R, v, ω)` and its pose `(p, M)` on the body,
//!
//! ```text
//! R_b = R Mᵀ,   ω_b = M ω,   x_b = x − R_b p,   v_b = v − R_b (ω_b × p)
//! ```
//!
//! Velocities are per second of acted time throughout.

use nalgebra::{Matrix3, SMatrix, Vector3};

use super::knot::{Driven, StateCovariance};
use crate::math::{Pose, so3};
use crate::physics::State;
use crate::physics::state::{StateTangent, part};

/// A body's state with what it depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounted {
    /// The body's state and accelerations.
    pub driven: Driven,
    /// Where the tracker is on the body, `p` [m, body].
    position_m: Vector3<f64>,
    /// `M`.
    rotation: Matrix3<f64>,
}

impl Mounted {
    /// The body's state from its tracker's.
    pub fn new(tracker: &Driven, body_from_tracker: &Pose) -> Self {
        let turn = body_from_tracker.rotation;
        let position_m = body_from_tracker.translation.vector;
        let orientation = tracker.state.orientation * turn.inverse();
        let spin = turn * tracker.state.angular_velocity_rad_s;
        let spin_rate = turn * tracker.angular_acceleration_rad_s2;
        let swing = spin.cross(&position_m);
        let state = State {
            position_m: tracker.state.position_m - orientation * position_m,
            orientation,
            velocity_m_s: tracker.state.velocity_m_s - orientation * swing,
            angular_velocity_rad_s: spin,
        };
        let lever = spin_rate.cross(&position_m) + spin.cross(&swing);
        Self {
            driven: Driven {
                state,
                acceleration_m_s2: tracker.acceleration_m_s2 - orientation * lever,
                angular_acceleration_rad_s2: spin_rate,
            },
            position_m,
            rotation: so3::matrix(&turn),
        }
    }

    /// The state's derivative by acted time.
    pub fn rate(&self) -> StateTangent {
        let mut rate = StateTangent::zeros();
        let mut set = |at: usize, value: &Vector3<f64>| {
            rate.fixed_rows_mut::<3>(at).copy_from(value);
        };
        set(part::POSITION, &self.driven.state.velocity_m_s);
        set(part::ORIENTATION, &self.driven.state.angular_velocity_rad_s);
        set(part::VELOCITY, &self.driven.acceleration_m_s2);
        set(
            part::ANGULAR_VELOCITY,
            &self.driven.angular_acceleration_rad_s2,
        );
        rate
    }

    /// The state's derivative by the tracker's position on the body, a column per body axis.
    pub fn by_tracker_position(&self) -> SMatrix<f64, 12, 3> {
        let body = so3::matrix(&self.driven.state.orientation);
        let mut by = SMatrix::<f64, 12, 3>::zeros();
        by.fixed_view_mut::<3, 3>(part::POSITION, 0)
            .copy_from(&-body);
        let swing = so3::hat(&self.driven.state.angular_velocity_rad_s);
        by.fixed_view_mut::<3, 3>(part::VELOCITY, 0)
            .copy_from(&-(body * swing));
        by
    }

    /// The state's derivative by a turn `δ` of the tracker on the body, `M ⊞ δ` [rad, tracker].
    pub fn by_tracker_turn(&self) -> SMatrix<f64, 12, 3> {
        // The body turns by −M δ, and its spin by (M δ) × ω.
        let turn = -self.rotation;
        let spin = -so3::hat(&self.driven.state.angular_velocity_rad_s) * self.rotation;
        self.by_turn_and_spin(&turn, &spin)
    }

    /// Derivatives by the tracker's state.
    fn by_tracker(&self) -> SMatrix<f64, 12, 12> {
        let mut by = SMatrix::<f64, 12, 12>::zeros();
        for place in [part::POSITION, part::VELOCITY] {
            by.fixed_view_mut::<3, 3>(place, place).fill_with_identity();
        }
        let none = Matrix3::zeros();
        for (column, turn, spin) in [
            (part::ORIENTATION, &self.rotation, &none),
            (part::ANGULAR_VELOCITY, &none, &self.rotation),
        ] {
            by.fixed_view_mut::<12, 3>(0, column)
                .copy_from(&self.by_turn_and_spin(turn, spin));
        }
        by
    }

    /// Derivatives of the state by what changes orientation and angular velocity, the tracker's
    /// place and velocity fixed.
    fn by_turn_and_spin(&self, turn: &Matrix3<f64>, spin: &Matrix3<f64>) -> SMatrix<f64, 12, 3> {
        let state = &self.driven.state;
        let body = so3::matrix(&state.orientation);
        let arm = so3::hat(&self.position_m);
        let swing = so3::hat(&state.angular_velocity_rad_s.cross(&self.position_m));
        let mut by = SMatrix::<f64, 12, 3>::zeros();
        let mut set = |at: usize, block: &Matrix3<f64>| {
            by.fixed_view_mut::<3, 3>(at, 0).copy_from(block);
        };
        set(part::POSITION, &(body * arm * turn));
        set(part::ORIENTATION, turn);
        set(part::VELOCITY, &(body * (swing * turn + arm * spin)));
        set(part::ANGULAR_VELOCITY, spin);
        by
    }

    /// The covariance of the body's state, from its tracker's.
    pub fn covariance(&self, of_tracker: &StateCovariance) -> StateCovariance {
        let by = self.by_tracker();
        let covariance = by * of_tracker * by.transpose();
        0.5 * (covariance + covariance.transpose())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::differentiate::jacobian;

    fn tracker() -> Driven {
        Driven {
            state: State {
                position_m: Vector3::new(0.3, -0.1, 0.9),
                orientation: so3::exp(&Vector3::new(0.7, -1.1, 0.4)),
                velocity_m_s: Vector3::new(3.0, -1.0, 2.0),
                angular_velocity_rad_s: Vector3::new(-4.0, 6.0, 9.0),
            },
            acceleration_m_s2: Vector3::new(10.0, 20.0, -5.0),
            angular_acceleration_rad_s2: Vector3::new(30.0, -20.0, 8.0),
        }
    }

    fn mount(shift: &[f64], turn: &[f64]) -> Pose {
        let place = Vector3::new(0.03, -0.02, 0.25) + Vector3::from_column_slice(shift);
        let rotation = so3::exp(&Vector3::new(-0.2, 0.5, 0.9));
        let rotation = rotation * so3::exp(&Vector3::from_column_slice(turn));
        Pose::from_parts(place.into(), rotation)
    }

    fn compare<const C: usize>(
        what: &str,
        exact: &SMatrix<f64, 12, C>,
        there: impl Fn(&[f64]) -> Mounted,
    ) {
        let here = there(&[0.0; 12]).driven.state;
        let numeric = jacobian(12, C, |delta| {
            let delta: Vec<f64> = delta.iter().map(|d| 0.1 * d).collect();
            let to = there(&delta).driven.state;
            (to.minus(&here) * 10.0).as_slice().to_vec()
        });
        for (row, numeric) in numeric.iter().enumerate() {
            for (column, numeric) in numeric.iter().enumerate() {
                let off = numeric - exact[(row, column)];
                assert!(off.abs() < 1e-8, "{what} {row} {column}: {off}");
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_the_state() {
        let zero = [0.0; 3];
        let of = Mounted::new(&tracker(), &mount(&zero, &zero));
        compare("place", &of.by_tracker_position(), |d| {
            Mounted::new(&tracker(), &mount(&d[..3], &zero))
        });
        compare("turn", &of.by_tracker_turn(), |d| {
            Mounted::new(&tracker(), &mount(&zero, &d[..3]))
        });
        compare("tracker", &of.by_tracker(), |d| {
            let delta = StateTangent::from_column_slice(d);
            let moved = Driven {
                state: tracker().state.retract(&delta),
                ..tracker()
            };
            Mounted::new(&moved, &mount(&zero, &zero))
        });
        compare("time", &of.rate(), |d| {
            let s = d[0];
            let Driven {
                mut state,
                acceleration_m_s2,
                angular_acceleration_rad_s2,
            } = tracker();
            let spin = state.angular_velocity_rad_s;
            state.position_m += state.velocity_m_s * s + acceleration_m_s2 * (0.5 * s * s);
            state.velocity_m_s += acceleration_m_s2 * s;
            // To first order in s, which is all that counts at zero.
            state.orientation *= so3::exp(&(spin * s));
            state.angular_velocity_rad_s += angular_acceleration_rad_s2 * s;
            let moved = Driven {
                state,
                acceleration_m_s2,
                angular_acceleration_rad_s2,
            };
            Mounted::new(&moved, &mount(&zero, &zero))
        });
    }
}
