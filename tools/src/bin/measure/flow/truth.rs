//! What a turn really is.

use enact_tools::reference::{self, Pair};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::method::Start;
use super::taylor::Taylor;

/// The turn to thirty digits.
pub struct Truth {
    pub rotation: Matrix3<f64>,
    /// Right perturbation by `ω(0)`.
    pub by_spin: Matrix3<f64>,
    /// What half a rounding of the first angular velocity makes of both: \[rad\], relative.
    pub condition: [f64; 2],
    /// From the second method: rotation \[rad\], derivative, relative.
    pub differs: [f64; 2],
}

impl Truth {
    /// By extrapolation, its derivative by central differences with a step of 1e-12; and both by
    /// Taylor series of order 40 in the same numbers.
    pub fn of(start: &Start, duration_s: f64) -> Self {
        let speed = Vector3::from(start.omega).norm();
        let run =
            |omega: [Pair; 3]| reference::turn(start.moments, &reference::epoch(omega), duration_s);
        let centre = run(start.omega.map(Pair::from));
        let quaternion = |q: &[f64]| nalgebra::Quaternion::new(q[0], q[1], q[2], q[3]);
        let rotation = UnitQuaternion::new_normalize(quaternion(&centre.map(|pair| pair.0)));
        let mut by_spin = Matrix3::zeros();
        let step = 1e-12;
        for column in 0..3 {
            let moved = |sign: f64| {
                let mut moved = start.omega.map(Pair::from);
                moved[column] = moved[column] + Pair(sign * step, 0.0);
                run(moved)
            };
            let (ahead, back) = (moved(1.0), moved(-1.0));
            let change: Vec<f64> = (0..4)
                .map(|i| (ahead[i] - back[i]).0 / (2.0 * step))
                .collect();
            let turn = (rotation.quaternion().conjugate() * quaternion(&change)).imag() * 2.0;
            by_spin.set_column(column, &turn);
        }
        let series = |omega: [f64; 3]| {
            let mut taylor = Taylor::<Pair, 41>::new(start.moments, omega, 1e-34);
            let node = taylor.node(duration_s).expect("steps that end");
            let by_spin = Matrix3::from_fn(|row, column| node.eta[column][row].0);
            (node, by_spin)
        };
        let (node, second) = series(start.omega);
        // Away from its direction, which matters more than its size.
        let [a, b, c] = start.omega;
        let half = f64::EPSILON / 2.0;
        let (_, rounded) = series([a * (1.0 + half), b * (1.0 - half), c * (1.0 + half)]);
        // Half a rounding more may be none: 1 + ε/2 is 1.
        let (_, beyond) = series([
            a * (1.0 + 2.0 * half),
            b * (1.0 - half),
            c * (1.0 + 2.0 * half),
        ]);
        let apart = (0..4).map(|i| (node.turn[i] - centre[i]).0.powi(2));
        let changed = (rounded - second)
            .norm()
            .max((beyond - second).norm() / 2.0);
        Self {
            rotation: rotation.to_rotation_matrix().into_inner(),
            by_spin: second,
            condition: [second.norm() * speed * half, changed / second.norm()],
            differs: [
                2.0 * apart.sum::<f64>().sqrt(),
                (second - by_spin).norm() / second.norm(),
            ],
        }
    }
}
