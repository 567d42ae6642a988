//! Runge–Kutta methods on the group of the coordinates (Munthe-Kaas, "High order Runge–Kutta methods on
//! manifolds", Applied Numerical Mathematics 29, 1999): a stage of a quaternion is `Q Exp(θ)` with
//! `θ̇ = J_r⁻¹(θ) ω`, so that no quaternion leaves the unit sphere. Angles and rates are as in the plain method.

use enact::physics::tree::tableau::Tableau;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::system::{Part, System};

/// `J_r⁻¹(θ) ω = ω + θ × ω/2 + c θ × (θ × ω)`, `c = (1 − (|θ|/2) cot(|θ|/2))/|θ|²`.
fn pulled_back(theta: &Vector3<f64>, omega: &Vector3<f64>) -> Vector3<f64> {
    let square = theta.norm_squared();
    let factor = if square < 1e-2 {
        // The series to rounding at a tenth of a radian.
        let terms = [
            1.0 / 12.0,
            1.0 / 720.0,
            1.0 / 30_240.0,
            1.0 / 1_209_600.0,
            1.0 / 47_900_160.0,
        ];
        terms
            .iter()
            .rev()
            .fold(0.0, |sum, term| sum * square + term)
    } else {
        let half = 0.5 * square.sqrt();
        (1.0 - half / half.tan()) / square
    };
    let once = theta.cross(omega);
    omega + once * 0.5 + theta.cross(&once) * factor
}

fn turned(q: &[f64], theta: &Vector3<f64>) -> [f64; 4] {
    let turn = UnitQuaternion::from_scaled_axis(*theta).into_inner();
    let product = Quaternion::new(q[3], q[0], q[1], q[2]) * turn;
    product.coords.into()
}

/// Moves a list on for a time, in equal steps.
pub fn advance(
    system: &mut System,
    y: &mut [f64],
    duration_s: f64,
    steps: usize,
    tableau: &Tableau,
) {
    let (split, rates) = (system.layout.coordinates, system.layout.rates);
    let parts = system.layout.parts.clone();
    let stages = tableau.b.len();
    let step_s = duration_s / steps as f64;
    // Of the group and of the rates, per stage.
    let mut slopes = vec![0.0; stages * 2 * rates];
    let mut moved = vec![0.0; 2 * rates];
    let mut stage_y = y.to_vec();
    let sum = |weights: &[f64], slopes: &[f64], moved: &mut [f64]| {
        moved.fill(0.0);
        for (weight, slope) in weights.iter().zip(slopes.chunks_exact(2 * rates)) {
            for (to, from) in moved.iter_mut().zip(slope) {
                *to += step_s * weight * from;
            }
        }
    };
    let put = |moved: &[f64], from: &[f64], to: &mut [f64]| {
        for part in &parts {
            match part {
                Part::Angles(places, rate) => {
                    for (place, column) in places.clone().zip(*rate..) {
                        to[place] = from[place] + moved[column];
                    }
                }
                Part::Turn(at, rate) => {
                    let theta = Vector3::from_column_slice(&moved[*rate..rate + 3]);
                    to[*at..at + 4].copy_from_slice(&turned(&from[*at..at + 4], &theta));
                }
            }
        }
        for column in 0..rates {
            to[split + column] = from[split + column] + moved[rates + column];
        }
    };
    for _ in 0..steps {
        for stage in 0..stages {
            sum(tableau.a[stage], &slopes, &mut moved);
            put(&moved, y, &mut stage_y);
            let slope = &mut slopes[stage * 2 * rates..(stage + 1) * 2 * rates];
            slope[..rates].copy_from_slice(&stage_y[split..]);
            for part in &parts {
                if let Part::Turn(_, rate) = part {
                    let theta = Vector3::from_column_slice(&moved[*rate..rate + 3]);
                    let omega = Vector3::from_column_slice(&stage_y[split + rate..][..3]);
                    let pulled = pulled_back(&theta, &omega);
                    slope[*rate..rate + 3].copy_from_slice(pulled.as_slice());
                }
            }
            system.accelerate(&stage_y, &mut slope[rates..]);
        }
        sum(tableau.b, &slopes, &mut moved);
        put(&moved, y, &mut stage_y);
        y.copy_from_slice(&stage_y);
        // Products of unit quaternions drift by rounding only.
        system.layout.normalise(y);
    }
}
