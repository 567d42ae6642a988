//! A library's explicit methods of high order, their steps chosen by tolerance: turn, `ω` and
//! their derivatives as one system of 25 equations.

use differential_equations::prelude::*;
use nalgebra::{Matrix3, Quaternion};

use super::method::{Start, Turned};

/// Which of its methods.
#[derive(Clone, Copy)]
pub enum Scheme {
    /// Hairer, Nørsett and Wanner's, order 8.
    DormandPrince853,
    /// Verner's efficient pair, order 9.
    Verner9,
}

/// Quaternion `w, x, y, z`; `ω`; `W` and `η`, column by column.
type Whole = [f64; 25];

struct Euler {
    couplings: [f64; 3],
}

impl ODE<f64, Whole> for Euler {
    fn diff(&self, _: f64, y: &Whole, rate: &mut Whole) {
        let [w, x, y1, z, a, b, c] = [y[0], y[1], y[2], y[3], y[4], y[5], y[6]];
        rate[0] = -0.5 * (x * a + y1 * b + z * c);
        rate[1] = 0.5 * (w * a + y1 * c - z * b);
        rate[2] = 0.5 * (w * b + z * a - x * c);
        rate[3] = 0.5 * (w * c + x * b - y1 * a);
        let omega = [a, b, c];
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            rate[4 + i] = self.couplings[i] * omega[j] * omega[k];
            for column in 0..3 {
                let (spin, eta) = (7 + 3 * column, 16 + 3 * column);
                rate[spin + i] =
                    self.couplings[i] * (omega[j] * y[spin + k] + omega[k] * y[spin + j]);
                rate[eta + i] = y[spin + i] + omega[k] * y[eta + j] - omega[j] * y[eta + k];
            }
        }
    }
}

/// Turns at increasing times, the last of them the end of the integration; none where the library
/// gives up.
pub fn turns(
    start: &Start,
    times_s: &[f64],
    scheme: Scheme,
    tolerance: f64,
    turns: &mut Vec<Turned>,
) {
    let moments = start.moments;
    let couplings = [0, 1, 2].map(|i| (moments[(i + 1) % 3] - moments[(i + 2) % 3]) / moments[i]);
    let system = Euler { couplings };
    let mut first = [0.0; 25];
    first[0] = 1.0;
    first[4..7].copy_from_slice(&start.omega);
    for axis in 0..3 {
        first[7 + 4 * axis] = 1.0;
    }
    let Some(end_s) = times_s.last() else { return };
    let solution = match scheme {
        Scheme::DormandPrince853 => IVP::ode(&system, 0.0, *end_s, first)
            .method(
                ExplicitRungeKutta::dop853()
                    .rtol(tolerance)
                    .atol(tolerance)
                    .max_steps(1_000_000),
            )
            .t_eval(times_s)
            .solve(),
        Scheme::Verner9 => IVP::ode(&system, 0.0, *end_s, first)
            .method(
                ExplicitRungeKutta::rkv989e()
                    .rtol(tolerance)
                    .atol(tolerance)
                    .max_steps(1_000_000),
            )
            .t_eval(times_s)
            .solve(),
    };
    let Ok(solution) = solution else { return };
    for whole in &solution.y {
        let by_spin = Matrix3::from_fn(|row, column| whole[16 + 3 * column + row]);
        let rotation = Quaternion::new(whole[0], whole[1], whole[2], whole[3]);
        turns.push(Turned::of(rotation, by_spin));
    }
}
