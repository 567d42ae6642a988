//! How measured orientations pull at a flight: the turn's residual and derivatives.
//!
//! `½|Log(R_iᵀ R(s))|²`: its gradient by a right perturbation of `R(s)` is the logarithm
//! itself; the identity stands for its Hessian, between Gauss–Newton's `1 + θ²/12` and the
//! exact `1 − θ²/12` across the residual, and of the three the cheapest. Seen from the frame of
//! `R(0)` a turn of `R(s)` is `δθ + s K δω` ([`Spin::turn_and_derivative`]).

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::flow::Spin;
use crate::math::so3;

/// Sums over measured orientations, by orientation `δθ` and angular velocity `δω` at the epoch.
#[derive(Clone, Copy, Debug, Default)]
pub struct TurnTerms {
    /// Half the weighted sum of squared angles.
    pub cost: f64,
    /// Gradient by `δθ`.
    pub gradient_orientation: Vector3<f64>,
    /// Gradient by `δω`.
    pub gradient_spin: Vector3<f64>,
    /// Hessian by `δθ` twice is this times the identity.
    pub count: f64,
    /// Hessian by `δθ` (rows) and `δω` (columns).
    pub cross: Matrix3<f64>,
    /// Hessian by `δω` twice.
    pub square: Matrix3<f64>,
}

impl TurnTerms {
    /// Adds one measured orientation, `s` seconds from the epoch; returns `K` and the residual
    /// \[rad\], both seen from the epoch's frame.
    #[inline]
    pub fn add(
        &mut self,
        spin: &mut Spin,
        orientation: &UnitQuaternion<f64>,
        measured: &UnitQuaternion<f64>,
        s: f64,
        weight: f64,
    ) -> (Matrix3<f64>, Vector3<f64>) {
        let (turn, k) = spin.turn_and_derivative(s);
        // C Log(E) = Log(C E C⁻¹) carries the residual from the body to the epoch's frame.
        let error = so3::log(&(turn * (measured.inverse() * orientation)));
        self.cost += 0.5 * weight * error.norm_squared();
        let scaled = k * (s * weight);
        self.gradient_orientation += error * weight;
        self.gradient_spin += scaled.tr_mul(&error);
        self.count += weight;
        self.cross += scaled;
        self.square += scaled.tr_mul(&k) * s;
        (k, error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::differentiate;
    use crate::physics::Body;

    #[test]
    fn gradient_is_exact_and_the_hessian_is_for_small_residuals() {
        let body = Body::new(1.0, Vector3::new(2.0, 2.0, 0.3)).unwrap();
        let orientation = UnitQuaternion::from_euler_angles(0.3, -0.2, 1.0);
        let omega = Vector3::new(4.0, -3.0, 9.0);
        let measured = |offset: f64, s: f64| {
            orientation
                * Spin::new(&body, &omega).turn_and_derivative(s).0
                * so3::exp(&(Vector3::new(0.4, -1.0, 0.7) * offset * (1.0 + s)))
        };
        for offset in [0.0, 0.9] {
            let cost = |d: &[f64]| {
                let mut spin = Spin::new(&body, &(omega + Vector3::new(d[3], d[4], d[5])));
                let turned = orientation * so3::exp(&Vector3::new(d[0], d[1], d[2]));
                let mut terms = TurnTerms::default();
                for s in [-0.2, 0.0, 0.3] {
                    terms.add(&mut spin, &turned, &measured(offset, s), s, 2.5);
                }
                terms
            };
            let at = cost(&[0.0; 6]);
            let numeric = differentiate::jacobian(1, 6, |d| vec![cost(d).cost]);
            let gradient = |t: &TurnTerms| {
                let (a, b) = (t.gradient_orientation, t.gradient_spin);
                vec![a.x, a.y, a.z, b.x, b.y, b.z]
            };
            for (n, exact) in numeric[0].iter().zip(gradient(&at)) {
                assert!((n - exact).abs() < 1e-8, "{offset}");
            }
            if offset == 0.0 {
                let hessian = differentiate::jacobian(6, 6, |d| gradient(&cost(d)));
                for i in 0..3 {
                    for j in 0..3 {
                        let unit = if i == j { at.count } else { 0.0 };
                        assert!((hessian[i][j] - unit).abs() < 1e-7);
                        assert!((hessian[i][3 + j] - at.cross[(i, j)]).abs() < 1e-7);
                        assert!((hessian[3 + i][3 + j] - at.square[(i, j)]).abs() < 1e-7);
                    }
                }
            }
        }
    }
}
