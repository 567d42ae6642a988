//! The rotation group SO(3): exponential, logarithm and their Jacobians.
//!
//! With `θ = |θ|` and `[θ]×` the cross-product matrix,
//!
//! ```text
//! Exp(θ) = (cos θ/2, sin(θ/2) θ/|θ|)                                  a unit quaternion
//! J_r(θ) = 1 − (1 − cos θ)/θ² [θ]× + (θ − sin θ)/θ³ [θ]×²,   J_l(θ) = J_r(θ)ᵀ
//! J_r⁻¹(θ) = 1 + ½ [θ]× + (1/θ² − (1 + cos θ)/(2 θ sin θ)) [θ]×²
//! ```
//!
//! as in Solà, Deray and Atchuthan, "A micro Lie theory for state estimation in robotics". Near
//! zero, Taylor series replace the quotients.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// Below this squared angle the series are used. Their first dropped term is below rounding
/// there: θ⁶/5040 at θ² = 1e-4 is 2e-16 relative.
pub const SERIES_BELOW: f64 = 1e-4;

/// `Exp(θ)`: rotation by `|θ|` about `θ` \[rad\].
pub fn exp(theta: &Vector3<f64>) -> UnitQuaternion<f64> {
    let square = theta.norm_squared();
    let (scale, w) = if square < SERIES_BELOW {
        (
            0.5 - square / 48.0 + square * square / 3840.0,
            1.0 - square / 8.0 + square * square / 384.0,
        )
    } else {
        let angle = square.sqrt();
        let (sin, cos) = (0.5 * angle).sin_cos();
        (sin / angle, cos)
    };
    UnitQuaternion::new_unchecked(Quaternion::from_parts(w, theta * scale))
}

/// `Log(R)`: the rotation vector of angle at most π \[rad\].
pub fn log(rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
    let q = rotation.quaternion();
    // q and −q are one rotation; take the one of smaller angle.
    let (w, v) = if q.w < 0.0 {
        (-q.w, -q.imag())
    } else {
        (q.w, q.imag())
    };
    let square = v.norm_squared();
    if square < 0.25 * SERIES_BELOW {
        // 2 atan(s/w)/s with s = |v|, as a series; an arc cosine of w near one would lose digits.
        let x = square / (w * w);
        return v * (2.0 / w * (1.0 - x / 3.0 + x * x / 5.0 - x * x * x / 7.0));
    }
    let sine = square.sqrt();
    v * (2.0 * sine.atan2(w) / sine)
}

/// `Exp(θ)` and the right Jacobian `J_r(θ)`, which share their sine and cosine.
pub fn exp_and_right_jacobian(theta: &Vector3<f64>) -> (UnitQuaternion<f64>, Matrix3<f64>) {
    let (rotation, a, b, square) = exp_and_coefficients(theta);
    (rotation, jacobian_from(theta, -a, b, square))
}

/// `Exp(θ)` and the left Jacobian `J_l(θ) = J_r(θ)ᵀ`: `Exp(θ + δ) = Exp(J_l(θ) δ)·Exp(θ)`.
pub fn exp_and_left_jacobian(theta: &Vector3<f64>) -> (UnitQuaternion<f64>, Matrix3<f64>) {
    let (rotation, a, b, square) = exp_and_coefficients(theta);
    (rotation, jacobian_from(theta, a, b, square))
}

/// `Exp(θ)`, `(1 − cos θ)/θ²`, `(θ − sin θ)/θ³`, `θ²`.
fn exp_and_coefficients(theta: &Vector3<f64>) -> (UnitQuaternion<f64>, f64, f64, f64) {
    let square = theta.norm_squared();
    if square < SERIES_BELOW {
        let a = 0.5 - square / 24.0 + square * square / 720.0;
        let b = 1.0 / 6.0 - square / 120.0 + square * square / 5040.0;
        return (exp(theta), a, b, square);
    }
    let angle = square.sqrt();
    let (sin, cos) = (0.5 * angle).sin_cos();
    let rotation =
        UnitQuaternion::new_unchecked(Quaternion::from_parts(cos, theta * (sin / angle)));
    (
        rotation,
        2.0 * sin * sin / square,
        (angle - 2.0 * sin * cos) / (square * angle),
        square,
    )
}

/// The least rotation from one vector's direction to another's; of opposite ones, half a turn about
/// something across.
pub fn between(from: &Vector3<f64>, to: &Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(from, to).unwrap_or_else(|| {
        let across = from.cross(&Vector3::ith(from.iamin(), 1.0).cross(from));
        UnitQuaternion::from_scaled_axis(across.normalize() * std::f64::consts::PI)
    })
}

/// The rotation matrix of a unit quaternion.
pub fn matrix(rotation: &UnitQuaternion<f64>) -> Matrix3<f64> {
    rotation.to_rotation_matrix().into_inner()
}

/// `[θ]×`, so that `[θ]× a = θ × a`.
pub fn hat(theta: &Vector3<f64>) -> Matrix3<f64> {
    theta.cross_matrix()
}

/// Right Jacobian: `Exp(θ + δ) = Exp(θ)·Exp(J_r(θ) δ)` to first order in δ.
pub fn right_jacobian(theta: &Vector3<f64>) -> Matrix3<f64> {
    exp_and_right_jacobian(theta).1
}

/// Inverse of [`right_jacobian`]: `Log(Exp(θ)·Exp(δ)) = θ + J_r⁻¹(θ) δ` to first order in δ.
/// For angles up to and including π; it is singular at 2π.
pub fn right_jacobian_inverse(theta: &Vector3<f64>) -> Matrix3<f64> {
    let square = theta.norm_squared();
    // 1/θ² − (1 + cos θ)/(2 θ sin θ), written with the half angle so that π is no special case
    let b = if square < SERIES_BELOW {
        1.0 / 12.0 + square / 720.0 + square * square / 30240.0
    } else {
        let angle = square.sqrt();
        let (sin, cos) = (0.5 * angle).sin_cos();
        1.0 / square - cos / (2.0 * angle * sin)
    };
    jacobian_from(theta, 0.5, b, square)
}

/// `1 + a [θ]× + b [θ]×²`, with `[θ]×² = θθᵀ − θ² 1`.
fn jacobian_from(theta: &Vector3<f64>, a: f64, b: f64, square: f64) -> Matrix3<f64> {
    let (x, y, z) = (theta.x, theta.y, theta.z);
    let d = 1.0 - b * square;
    Matrix3::new(
        d + b * x * x,
        b * x * y - a * z,
        b * x * z + a * y,
        b * x * y + a * z,
        d + b * y * y,
        b * y * z - a * x,
        b * x * z - a * y,
        b * y * z + a * x,
        d + b * z * z,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::differentiate;

    #[test]
    fn the_rotation_between_two_vectors_turns_one_to_the_other() {
        for from in cases().into_iter().filter(|from| from.norm() > 0.0) {
            let opposite = -2.0 * from;
            for to in cases().into_iter().chain([opposite]) {
                if to.norm() > 0.0 {
                    let off = between(&from, &to) * from.normalize() - to.normalize();
                    assert!(off.norm() < 1e-7, "{from} {to}: {off}");
                }
            }
        }
        // The first axis that is across the most.
        let half = between(&Vector3::z(), &-Vector3::z());
        assert!((half * Vector3::x() - Vector3::x()).norm() < 1e-12);
    }

    #[test]
    fn both_quaternions_of_a_rotation_have_one_logarithm() {
        for theta in cases() {
            let rotation = exp(&theta);
            let other = UnitQuaternion::new_unchecked(-rotation.into_inner());
            let [one, same] = [rotation, other].map(|q| log(&q));
            assert!(same.norm() <= std::f64::consts::PI + 1e-12, "{same}");
            // At half a turn both directions are one rotation.
            let is_half = std::f64::consts::PI - theta.norm() < 1e-6;
            let off = (one - same).norm();
            assert!(
                off < 1e-12 || is_half && (one + same).norm() < 1e-5,
                "{theta}"
            );
        }
    }

    /// Directions and angles on both sides of every switch, and near π.
    fn cases() -> Vec<Vector3<f64>> {
        let axes = [
            Vector3::new(1.0, 0.0, 0.0),
            Vector3::new(0.3, -0.9, 0.2).normalize(),
            Vector3::new(-0.6, 0.1, 0.7).normalize(),
        ];
        let angles = [
            0.0,
            1e-12,
            1e-8,
            1e-4,
            0.009_999,
            0.010_001,
            0.3,
            1.5,
            3.0,
            std::f64::consts::PI - 3e-6,
        ];
        axes.iter()
            .flat_map(|a| angles.iter().map(move |t| a * *t))
            .collect()
    }

    #[test]
    fn log_inverts_exp_to_rounding() {
        for theta in cases() {
            let back = log(&exp(&theta));
            assert!(
                (back - theta).norm()
                    <= 4e-16 + 4e-16 * theta.norm() / (1.0 - theta.norm() / 3.2).max(0.02),
                "{theta} {back}"
            );
        }
    }

    #[test]
    fn exp_is_unit_and_agrees_with_nalgebra() {
        for theta in cases() {
            let q = exp(&theta);
            assert!((q.quaternion().norm() - 1.0).abs() < 4e-16);
            assert!(q.angle_to(&UnitQuaternion::from_scaled_axis(theta)) < 1e-7);
            assert!(
                (q.to_rotation_matrix().matrix()
                    - UnitQuaternion::from_scaled_axis(theta)
                        .to_rotation_matrix()
                        .matrix())
                .norm()
                    < 2e-15
            );
        }
    }

    #[test]
    fn right_jacobian_is_the_derivative_of_exp() {
        for theta in cases() {
            let base = exp(&theta).inverse();
            let numeric = differentiate::jacobian(3, 3, |d| {
                let moved = base * exp(&(theta + Vector3::new(d[0], d[1], d[2])));
                log(&moved).as_slice().to_vec()
            });
            let exact = right_jacobian(&theta);
            for i in 0..3 {
                for j in 0..3 {
                    assert!(
                        (numeric[i][j] - exact[(i, j)]).abs() < 1e-9,
                        "{theta} {i} {j}"
                    );
                }
            }
        }
    }

    #[test]
    fn left_jacobian_is_the_transpose_and_exp_agrees() {
        for theta in cases() {
            let (rotation, jacobian) = exp_and_left_jacobian(&theta);
            assert_eq!(rotation, exp(&theta));
            assert_eq!(jacobian.transpose(), right_jacobian(&theta));
        }
    }

    #[test]
    fn inverse_right_jacobian_inverts_it() {
        for theta in cases() {
            let product = right_jacobian(&theta) * right_jacobian_inverse(&theta);
            assert!((product - Matrix3::identity()).norm() < 1e-12, "{theta}");
        }
    }

    #[test]
    fn series_and_formula_meet_at_the_switch() {
        let axis = Vector3::new(0.3, -0.9, 0.2).normalize();
        let (below, above) = (axis * (0.01 - 1e-13), axis * (0.01 + 1e-13));
        assert!((right_jacobian(&below) - right_jacobian(&above)).norm() < 3e-12);
        assert!((right_jacobian_inverse(&below) - right_jacobian_inverse(&above)).norm() < 3e-11);
    }
}
