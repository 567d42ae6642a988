//! Residuals of measured orientations against a free rotation, with derivatives: the rotational
//! part of the sum of squares (paper eq. 1).
//!
//! The cost of one orientation `R_i` is `½|e|²`, `e = Log(R_iᵀ R(s))`. Its gradient by a right
//! perturbation of `R(s)` is `e` itself. Its Hessian is replaced by the identity: across the
//! residual of angle `θ` that lies between Gauss–Newton's `1 + θ²/12` and the exact `1 − θ²/12`,
//! and it is the cheapest of the three. In the frame of `R(0)`, a perturbation of the initial state
//! turns `R(s)` by `δθ + s K δω` ([`Spin::turn_and_derivative`]), hence
//!
//! ```text
//! gradient   Σ e, Σ s Kᵀe        Hessian   Σ 1, Σ s K; ·, Σ s² KᵀK
//! ```

pub mod lanes;

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::flow::Spin;
use crate::math::so3;

/// Sums over measured orientations, with derivatives by orientation `δθ` and angular velocity `δω`
/// of the state, at its epoch.
#[derive(Clone, Copy, Debug, Default)]
pub struct TurnTerms {
    /// Half the weighted sum of squared angles \[rad²\].
    pub cost: f64,
    /// Gradient by `δθ`.
    pub gradient_orientation: Vector3<f64>,
    /// Gradient by `δω`.
    pub gradient_spin: Vector3<f64>,
    /// The Hessian by `δθ` twice is this times the identity.
    pub count: f64,
    /// Hessian by `δθ` (rows) and `δω` (columns).
    pub cross: Matrix3<f64>,
    /// Hessian by `δω` twice.
    pub square: Matrix3<f64>,
}

impl TurnTerms {
    /// Terms of measured orientations, each with its time from the epoch \[s\], at which the body
    /// has `orientation` and the spin begins; all with weight one.
    pub fn of<'m>(
        spin: &mut Spin,
        orientation: &UnitQuaternion<f64>,
        readings: impl Iterator<Item = (f64, &'m UnitQuaternion<f64>)>,
    ) -> Self {
        if let Some(precession) = spin.precession() {
            return lanes::terms(precession, orientation, readings);
        }
        let mut terms = Self::default();
        for (s, measured) in readings {
            terms.add(spin, orientation, measured, s, 1.0);
        }
        terms
    }

    /// The terms multiplied by a weight.
    pub fn weighed(self, weight: f64) -> Self {
        Self {
            cost: self.cost * weight,
            gradient_orientation: self.gradient_orientation * weight,
            gradient_spin: self.gradient_spin * weight,
            count: self.count * weight,
            cross: self.cross * weight,
            square: self.square * weight,
        }
    }

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

    /// Pencils along every axis, a ball; still, turning about the axis, across it, fast.
    #[test]
    fn four_at_a_time_are_as_one_by_one() {
        let moments = [[2.0, 2.0, 0.3], [2.0, 0.1, 2.0], [0.5, 2.0, 2.0], [1.5; 3]];
        let spins = [
            [0.0, 0.0, 0.0],
            [0.0, 0.0, 12.0],
            [0.0, -7.0, 0.0],
            [4.0, -3.0, 9.0],
            [-80.0, 2.0, 60.0],
            [1e-9, 0.0, 2e-9],
        ];
        let orientation = UnitQuaternion::from_euler_angles(0.3, -0.2, 1.0);
        for (moments, spin) in moments.iter().flat_map(|m| spins.map(|spin| (m, spin))) {
            let body = Body::new(1.0, Vector3::from(*moments)).unwrap();
            let omega = Vector3::from(spin);
            for count in [0, 1, 3, 4, 9] {
                let readings: Vec<_> = (0..count)
                    .map(|index| {
                        let s = 0.05 * f64::from(index) - 0.15;
                        let off = Vector3::new(0.4, -1.0, 0.7) * (0.3 * f64::from(index) - 0.3);
                        (
                            s,
                            orientation * Spin::new(&body, &omega).turn(s) * so3::exp(&off),
                        )
                    })
                    .collect();
                let mut one_by_one = TurnTerms::default();
                for (s, measured) in &readings {
                    let mut spin = Spin::new(&body, &omega);
                    one_by_one.add(&mut spin, &orientation, measured, *s, 1.0);
                }
                let pairs = readings.iter().map(|(s, measured)| (*s, measured));
                let mut spin = Spin::new(&body, &omega);
                let at_once = TurnTerms::of(&mut spin, &orientation, pairs);
                let numbers = |terms: &TurnTerms| {
                    let mut all = vec![terms.cost, terms.count];
                    all.extend(terms.gradient_orientation.iter());
                    all.extend(terms.gradient_spin.iter());
                    all.extend(terms.cross.iter().chain(terms.square.iter()));
                    all
                };
                for (a, b) in numbers(&at_once).iter().zip(numbers(&one_by_one)) {
                    assert!(
                        (a - b).abs() < 1e-13 * (1.0 + b.abs()),
                        "{moments:?} {spin:?} {count}: {a} {b}"
                    );
                }
            }
        }
    }

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
