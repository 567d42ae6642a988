//! Implicit methods of collocation. At Gauss's points: symmetric, of order twice the stages, and quadratic
//! invariants such as the length of a quaternion are kept (Hairer, Lubich and Wanner, "Geometric Numerical
//! Integration", 2006, II.1 and IV.2). At Radau's: of order 5, for what is stiff. Stages are found by
//! simple iteration, begun where the polynomial of the last step leads.

use nalgebra::{DMatrix, DVector};

use super::system::System;

/// Iterations of a step at most.
const MOST: usize = 100;

/// A method of some stages.
pub struct Collocation {
    a: DMatrix<f64>,
    b: DVector<f64>,
    /// Slopes of the next step's stages from this one's.
    ahead: DMatrix<f64>,
}

impl Collocation {
    /// At Gauss's points, of so many stages.
    pub fn gauss(stages: usize) -> Self {
        Self::at(&roots(stages))
    }

    /// At Radau's points with the end of the step, of three stages.
    pub fn radau() -> Self {
        let root = 6.0_f64.sqrt();
        Self::at(&[(4.0 - root) / 10.0, (4.0 + root) / 10.0, 1.0])
    }

    fn at(nodes: &[f64]) -> Self {
        let stages = nodes.len();
        let power = |x: f64, k: usize| x.powi(k as i32);
        let values =
            |at: &dyn Fn(usize) -> f64| DMatrix::from_fn(stages, stages, |i, k| power(at(i), k));
        // Polynomials through the slopes: their coefficients are `V⁻¹ k`.
        let inverse = values(&|i| nodes[i])
            .try_inverse()
            .expect("the nodes are distinct");
        let integral = |x: f64, k: usize| power(x, k + 1) / (k + 1) as f64;
        let a = DMatrix::from_fn(stages, stages, |i, k| integral(nodes[i], k)) * &inverse;
        let b = DMatrix::from_fn(1, stages, |_, k| integral(1.0, k)) * &inverse;
        Self {
            a,
            b: b.transpose().column(0).into_owned(),
            ahead: values(&|i| 1.0 + nodes[i]) * &inverse,
        }
    }

    /// Moves a list on for a time, in equal steps; whether all iterations ended.
    pub fn advance(
        &self,
        system: &mut System,
        y: &mut [f64],
        duration_s: f64,
        steps: usize,
    ) -> bool {
        let (stages, size) = (self.b.len(), y.len());
        let step_s = duration_s / steps as f64;
        let mut first = vec![0.0; size];
        system.slope(y, &mut first);
        // A column per stage.
        let mut slopes = DMatrix::from_fn(size, stages, |row, _| first[row]);
        let mut stage_y = vec![0.0; size];
        for step in 0..steps {
            if step > 0 {
                slopes = &slopes * self.ahead.transpose();
            }
            let mut last = f64::INFINITY;
            let mut is_found = false;
            for _ in 0..MOST {
                let moves = &slopes * self.a.transpose() * step_s;
                let mut change = 0.0_f64;
                for stage in 0..stages {
                    for row in 0..size {
                        stage_y[row] = y[row] + moves[(row, stage)];
                    }
                    system.slope(&stage_y, &mut first);
                    for row in 0..size {
                        let off = (first[row] - slopes[(row, stage)]) * step_s;
                        change = if off.is_nan() {
                            f64::INFINITY
                        } else {
                            change.max(off.abs())
                        };
                        slopes[(row, stage)] = first[row];
                    }
                }
                // Down to rounding: nothing moves, or it no longer gets less.
                if change < 1e-15 || change < 1e-9 && change >= last {
                    is_found = true;
                    break;
                }
                last = change;
            }
            if !is_found {
                return false;
            }
            let moved = &slopes * &self.b * step_s;
            for (to, by) in y.iter_mut().zip(moved.iter()) {
                *to += by;
            }
        }
        system.layout.normalise(y);
        true
    }
}

/// Roots of Legendre's polynomial on `[0, 1]`, by Newton's method.
fn roots(stages: usize) -> Vec<f64> {
    let n = stages as f64;
    let root = |index: usize| {
        let mut x = -(std::f64::consts::PI * (index as f64 + 0.75) / (n + 0.5)).cos();
        for _ in 0..50 {
            let (mut before, mut value) = (1.0, x);
            for k in 2..=stages {
                let k = k as f64;
                (before, value) = (
                    value,
                    ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k,
                );
            }
            x -= value * (x * x - 1.0) / (n * (x * value - before));
        }
        0.5 * (1.0 + x)
    };
    (0..stages).map(root).collect()
}
