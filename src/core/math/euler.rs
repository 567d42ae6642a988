//! Three angles for a rotation, for formats that know no quaternions.
//!
//! Turned about x, then about the new y, then about the newest z, `R = R_x(α) R_y(β) R_z(γ)`. Another
//! triple, `(α + π, π − β, γ + π)`, says the same; at `cos β = 0` only `α ± γ` is determined, and
//! `α` and `γ` turn without bound as a motion passes near.

use std::f64::consts::{PI, TAU};

use nalgebra::{UnitQuaternion, Vector3};

use super::so3;

/// Below this cosine of the middle angle the outer two are one.
const SINGULAR_BELOW: f64 = 1e-9;

/// The angle that differs from another by whole turns and is nearest to `before` \[rad\].
pub fn nearest(angle_rad: f64, before_rad: f64) -> f64 {
    angle_rad + TAU * ((before_rad - angle_rad) / TAU).round()
}

/// Angles `(α, β, γ)` of a rotation \[rad\]: of all triples the nearest to `before`. The rotation comes
/// back to rounding wherever it is; where only `α ± γ` is determined, `α` stays.
pub fn xyz_near(turn: &UnitQuaternion<f64>, before: &[f64; 3]) -> [f64; 3] {
    let matrix = so3::matrix(turn);
    let cosine = matrix[(0, 0)].hypot(matrix[(0, 1)]);
    let middle = matrix[(0, 2)].atan2(cosine);
    let first = match cosine < SINGULAR_BELOW {
        true => before[0],
        false => (-matrix[(1, 2)]).atan2(matrix[(2, 2)]),
    };
    let last = |first: f64| {
        // The second row of R_y(β) R_z(γ) is (sin γ, cos γ, 0), whatever β is.
        let (sin, cos) = first.sin_cos();
        let row = [0, 1].map(|column| cos * matrix[(1, column)] + sin * matrix[(2, column)]);
        row[0].atan2(row[1])
    };
    let triples = [(first, middle), (first + PI, PI - middle)].map(|(first, middle)| {
        let found = [first, middle, last(first)];
        [0, 1, 2].map(|of| nearest(found[of], before[of]))
    });
    let far = |of: &[f64; 3]| -> f64 { (0..3).map(|k| (of[k] - before[k]).powi(2)).sum() };
    match far(&triples[1]) < far(&triples[0]) {
        true => triples[1],
        false => triples[0],
    }
}

/// Rates of `(α, β, γ)` [rad/s] of what turns at `angular_velocity` [rad/s], in the axes of what is turned.
/// Where only `α ± γ` is determined, the least that the velocity allows.
pub fn xyz_rates([_, middle, last]: &[f64; 3], angular_velocity: &Vector3<f64>) -> [f64; 3] {
    let (sin, cos) = last.sin_cos();
    let (tilt, cosine) = middle.sin_cos();
    let along = angular_velocity.x * cos - angular_velocity.y * sin;
    let across = angular_velocity.x * sin + angular_velocity.y * cos;
    if cosine.abs() < SINGULAR_BELOW {
        let half = 0.5 * angular_velocity.z;
        return [half * tilt.signum(), across, half];
    }
    let first = along / cosine;
    [first, across, angular_velocity.z - tilt * first]
}

/// Roll, pitch and yaw \[rad\]: about fixed x, then fixed y, then fixed z, `R = R_z(yaw) R_y(pitch) R_x(roll)`;
/// of all triples the nearest to zero.
pub fn roll_pitch_yaw(turn: &UnitQuaternion<f64>) -> [f64; 3] {
    // The inverse turns by the negative angles in the other order; no negative zeros.
    xyz_near(&turn.inverse(), &[0.0; 3]).map(|angle| 0.0 - angle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::differentiate::jacobian;

    fn turned([first, middle, last]: [f64; 3]) -> UnitQuaternion<f64> {
        let about = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
        about(Vector3::x_axis(), first)
            * about(Vector3::y_axis(), middle)
            * about(Vector3::z_axis(), last)
    }

    /// Ordinary, beyond the pole, at both poles and next to them, many turns on.
    const TRIPLES: [[f64; 3]; 7] = [
        [0.3, -0.4, 2.0],
        [-2.0, 2.5, 0.1],
        [0.4, 0.5 * PI, -1.0],
        [0.4, -0.5 * PI, -1.0],
        [1.0, 0.5 * PI - 1e-8, 0.2],
        [1.0, 0.5 * PI + 1e-5, 0.2],
        [20.0, 0.1, -40.0],
    ];

    #[test]
    fn the_nearest_triple_makes_the_rotation_and_a_path_comes_back() {
        for triple in TRIPLES {
            let turn = turned(triple);
            for before in [[0.0; 3], [3.0, -7.0, 1.0], triple] {
                let found = xyz_near(&turn, &before);
                assert!(turned(found).angle_to(&turn) < 1e-14, "{triple:?}");
            }
            let near = triple.map(|angle| angle + 0.01);
            let found = xyz_near(&turn, &near);
            if (triple[1].abs() - 0.5 * PI).abs() > 1e-3 {
                for k in 0..3 {
                    assert!((found[k] - triple[k]).abs() < 1e-12, "{triple:?} {found:?}");
                }
            }
        }
    }

    #[test]
    fn rates_are_those_of_the_angles() {
        let velocity = Vector3::new(0.7, -1.3, 2.1);
        for triple in TRIPLES {
            let rates = xyz_rates(&triple, &velocity);
            if triple[1].cos().abs() > 1e-3 {
                let turn = turned(triple);
                let by_time = jacobian(3, 1, |t| {
                    xyz_near(&(turn * so3::exp(&(velocity * t[0]))), &triple).to_vec()
                });
                for k in 0..3 {
                    assert!((rates[k] - by_time[k][0]).abs() < 1e-8, "{triple:?} {k}");
                }
                continue;
            }
            // What the rates turn at is the velocity, but for what no rates make at a pole.
            let most = rates
                .iter()
                .fold(1.0, |most: f64, rate| most.max(rate.abs()));
            let made = jacobian(3, 1, |t| {
                let on = [0, 1, 2].map(|k| triple[k] + rates[k] * t[0] / most);
                let turn = so3::log(&(turned(triple).inverse() * turned(on)));
                (turn * most).as_slice().to_vec()
            });
            let off = Vector3::from_fn(|k, _| made[k][0]) - velocity;
            let (sin, cos) = triple[2].sin_cos();
            let lost = Vector3::new(cos, -sin, 0.0);
            let off = match triple[1].cos().abs() < SINGULAR_BELOW {
                true => off - lost * off.dot(&lost),
                false => off,
            };
            assert!(off.norm() < 1e-4, "{triple:?} {off}");
        }
    }

    #[test]
    fn roll_pitch_and_yaw_are_about_fixed_axes() {
        for [roll, pitch, yaw] in TRIPLES {
            let about = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
            let turn = about(Vector3::z_axis(), yaw)
                * about(Vector3::y_axis(), pitch)
                * about(Vector3::x_axis(), roll);
            let found = roll_pitch_yaw(&turn);
            let again = about(Vector3::z_axis(), found[2])
                * about(Vector3::y_axis(), found[1])
                * about(Vector3::x_axis(), found[0]);
            assert!(again.angle_to(&turn) < 1e-14, "{roll} {pitch} {yaw}");
        }
    }
}
