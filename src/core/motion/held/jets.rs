//! Curves between two knots of a [`Curve`](super::Curve).
//!
//! With the share `s = (t − t₀)/h` of the interval, a coordinate `p` is the polynomial of fifth degree
//! that has the value, slope and second derivative of both knots. Rotations are `R₀ Exp(θ(t))` with
//! three such polynomials `θ`, and
//!
//! ```text
//! ω = J_r(θ) θ̇,   ω̇ = J_r(θ) θ̈ + J̇_r θ̇
//! J_r = 1 − b [θ]× + c [θ]×²,   J̇_r θ̇ = −ḃ θ × θ̇ + ċ θ × (θ × θ̇) + c θ̇ × (θ × θ̇)
//! ```

use nalgebra::{UnitQuaternion, Vector3};

use super::knot::{Driven, Knot};
use crate::math::so3;
use crate::physics::State;

/// Value, first and second derivative of a vector.
type Jet = [Vector3<f64>; 3];

/// The state between two knots.
pub(super) fn between(from: &Knot, to: &Knot, time_s: f64) -> Driven {
    let lasting_s = to.time_s - from.time_s;
    let share = (time_s - from.time_s) / lasting_s;
    let places = [from, to].map(|knot| {
        let Driven {
            state,
            acceleration_m_s2,
            ..
        } = knot.driven;
        [state.position_m, state.velocity_m_s, acceleration_m_s2]
    });
    let [start, end] = [from, to].map(|knot| knot.driven.state.orientation);
    let turn = so3::log(&(start.inverse() * end));
    let turns = [
        tangent(&Vector3::zeros(), &from.driven),
        tangent(&turn, &to.driven),
    ];
    let [position_m, velocity_m_s, acceleration_m_s2] = quintic(&places, share, lasting_s);
    let (orientation, spin, spin_rate) = turned(&start, &quintic(&turns, share, lasting_s));
    Driven {
        state: State {
            position_m,
            orientation,
            velocity_m_s,
            angular_velocity_rad_s: spin,
        },
        acceleration_m_s2,
        angular_acceleration_rad_s2: spin_rate,
    }
}

/// The state before the first knot or after the last: with the accelerations there.
pub(super) fn beyond(knot: &Knot, time_s: f64) -> Driven {
    let s = time_s - knot.time_s;
    let Driven {
        state,
        acceleration_m_s2,
        angular_acceleration_rad_s2,
    } = knot.driven;
    let spin = state.angular_velocity_rad_s;
    let turn = [
        spin * s + angular_acceleration_rad_s2 * (0.5 * s * s),
        spin + angular_acceleration_rad_s2 * s,
        angular_acceleration_rad_s2,
    ];
    let (orientation, spin, spin_rate) = turned(&state.orientation, &turn);
    Driven {
        state: State {
            position_m: state.position_m
                + state.velocity_m_s * s
                + acceleration_m_s2 * (0.5 * s * s),
            orientation,
            velocity_m_s: state.velocity_m_s + acceleration_m_s2 * s,
            angular_velocity_rad_s: spin,
        },
        acceleration_m_s2,
        angular_acceleration_rad_s2: spin_rate,
    }
}

/// The polynomial with these jets at both ends, at a share of the interval.
fn quintic([from, to]: &[Jet; 2], s: f64, lasting_s: f64) -> Jet {
    let h = lasting_s;
    let jump = to[0] - from[0] - from[1] * h - from[2] * (0.5 * h * h);
    let slope = (to[1] - from[1] - from[2] * h) * h;
    let bend = (to[2] - from[2]) * (h * h);
    let cubic = jump * 10.0 - slope * 4.0 + bend * 0.5;
    let quartic = -jump * 15.0 + slope * 7.0 - bend;
    let fifth = jump * 6.0 - slope * 3.0 + bend * 0.5;
    [
        from[0]
            + from[1] * (h * s)
            + from[2] * (0.5 * h * h * s * s)
            + (cubic + (quartic + fifth * s) * s) * (s * s * s),
        from[1]
            + from[2] * (h * s)
            + (cubic * 3.0 + (quartic * 4.0 + fifth * (5.0 * s)) * s) * (s * s / h),
        from[2] + (cubic * 6.0 + (quartic * 12.0 + fifth * (20.0 * s)) * s) * (s / (h * h)),
    ]
}

/// `θ`, `θ̇`, `θ̈` of a rotation by `θ` with the angular velocity and acceleration of a knot.
fn tangent(theta: &Vector3<f64>, driven: &Driven) -> Jet {
    let inverse = so3::right_jacobian_inverse(theta);
    let rate = inverse * driven.state.angular_velocity_rad_s;
    let bend = driven.angular_acceleration_rad_s2 - jacobian_rate(theta, &rate);
    [*theta, rate, inverse * bend]
}

/// `R₀ Exp(θ)`, `ω`, `ω̇`.
fn turned(
    start: &UnitQuaternion<f64>,
    [theta, rate, bend]: &Jet,
) -> (UnitQuaternion<f64>, Vector3<f64>, Vector3<f64>) {
    let (turn, right) = so3::exp_and_right_jacobian(theta);
    let spin_rate = right * bend + jacobian_rate(theta, rate);
    (start * turn, right * rate, spin_rate)
}

/// `J̇_r θ̇`.
fn jacobian_rate(theta: &Vector3<f64>, rate: &Vector3<f64>) -> Vector3<f64> {
    let square = theta.norm_squared();
    // c, and the derivatives of b and c by θ over θ.
    let (c, b_slope, c_slope) = if square < so3::SERIES_BELOW {
        (
            1.0 / 6.0 - square / 120.0 + square * square / 5040.0,
            -1.0 / 12.0 + square / 180.0 - square * square / 6720.0,
            -1.0 / 60.0 + square / 1260.0 - square * square / 60480.0,
        )
    } else {
        let angle = square.sqrt();
        let (sin, cos) = angle.sin_cos();
        (
            (angle - sin) / (square * angle),
            (angle * sin - 2.0 * (1.0 - cos)) / (square * square),
            (3.0 * sin - angle * (2.0 + cos)) / (square * square * angle),
        )
    };
    let along = theta.dot(rate);
    let across = theta.cross(rate);
    -across * (b_slope * along) + theta.cross(&across) * (c_slope * along) + rate.cross(&across) * c
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::differentiate::jacobian;

    fn knot(time_s: f64, size: f64) -> Knot {
        let vector = |x: f64, y: f64, z: f64| Vector3::new(x, y, z) * size;
        Knot {
            time_s,
            driven: Driven {
                state: State {
                    position_m: vector(0.1, -0.2, 0.3),
                    orientation: so3::exp(&vector(0.5, 0.2, -0.4)),
                    velocity_m_s: vector(1.0, 3.0, -2.0),
                    angular_velocity_rad_s: vector(4.0, -7.0, 2.0),
                },
                acceleration_m_s2: vector(20.0, 10.0, -30.0),
                angular_acceleration_rad_s2: vector(-50.0, 30.0, 20.0),
            },
        }
    }

    fn near(a: &Driven, b: &Driven) -> f64 {
        let accelerations = (a.acceleration_m_s2 - b.acceleration_m_s2).norm()
            + (a.angular_acceleration_rad_s2 - b.angular_acceleration_rad_s2).norm();
        a.state.minus(&b.state).norm() + accelerations
    }

    #[test]
    fn a_curve_has_what_its_knots_have() {
        let (from, to) = (knot(0.2, 1.0), knot(0.31, -0.7));
        for (time_s, driven) in [(0.2, from.driven), (0.31, to.driven)] {
            let off = near(&between(&from, &to, time_s), &driven);
            assert!(off < 1e-11, "{time_s}: {off}");
            assert!(near(&beyond(&from, 0.2), &from.driven) < 1e-14);
        }
    }

    /// Velocities are the derivatives of poses, accelerations those of velocities.
    #[test]
    fn rates_are_derivatives_by_time() {
        let (from, to) = (knot(0.0, 1.0), knot(1.0, -0.7));
        let one = |time_s: f64| between(&from, &to, time_s);
        let far = |time_s: f64| beyond(&to, time_s);
        let check = |at: &dyn Fn(f64) -> Driven, time_s: f64| {
            let here = at(time_s);
            let numeric = jacobian(12, 1, |by| {
                let there = at(time_s + by[0]).state;
                there.minus(&here.state).as_slice().to_vec()
            });
            let exact = [
                here.state.velocity_m_s,
                here.state.angular_velocity_rad_s,
                here.acceleration_m_s2,
                here.angular_acceleration_rad_s2,
            ];
            for (row, numeric) in numeric.iter().enumerate() {
                let off = numeric[0] - exact[row / 3][row % 3];
                assert!(off.abs() < 1e-6, "{time_s} {row}: {off}");
            }
        };
        for time_s in [0.03, 0.4, 0.5, 0.97] {
            check(&one, time_s);
        }
        for time_s in [1.02, 1.3] {
            check(&far, time_s);
        }
    }

    #[test]
    fn the_series_meets_the_closed_form() {
        let rate = Vector3::new(0.3, -2.0, 1.0);
        let direction = Vector3::new(1.0, 2.0, -2.0) / 3.0;
        let [below, above] = [1.0 - 1e-9, 1.0 + 1e-9]
            .map(|factor| jacobian_rate(&(direction * (so3::SERIES_BELOW.sqrt() * factor)), &rate));
        assert!((below - above).norm() < 1e-9, "{below} {above}");
    }
}
