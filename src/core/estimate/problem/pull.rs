//! Pulls: quadratic terms that hold the state of a flight, for a while as all else is solved for, or to
//! rest where it is not seen (`calm`).

use nalgebra::{DMatrix, DVector};

use crate::math::so3;
use crate::physics::State;
use crate::physics::state::{self, StateTangent, part};

/// A pull on the state `q` of a flight towards `p`: `½ w |U⁻¹ (q ⊟ p) + b|²`, with units `U` of
/// a state's parts.
#[derive(Clone, Debug)]
pub struct Pull {
    /// Index into [`Problem::arcs`](super::Problem::arcs).
    pub arc: usize,
    /// `p`.
    pub towards: State,
    /// `w`.
    pub weight: f64,
    /// `U`: of position, orientation, velocity and angular velocity; infinite where it does not pull.
    pub units: [f64; 4],
    /// `b`: what was left so far, by which it pulls the harder.
    pub left: DVector<f64>,
}

impl Pull {
    /// A pull that has left nothing yet.
    pub fn new(arc: usize, towards: State, weight: f64, units: [f64; 4]) -> Self {
        Self {
            arc,
            towards,
            weight,
            units,
            left: DVector::zeros(state::DIMENSION),
        }
    }

    /// `U⁻¹ (q ⊟ p)`.
    pub fn miss(&self, state: &State) -> DVector<f64> {
        let delta: StateTangent = state.minus(&self.towards);
        DVector::from_fn(state::DIMENSION, |row, _| delta[row] / self.units[row / 3])
    }

    /// Residuals and their derivatives by the state's tangent.
    pub fn term(&self, state: &State) -> (DVector<f64>, DMatrix<f64>) {
        let root = self.weight.sqrt();
        let turn = so3::log(&(self.towards.orientation.inverse() * state.orientation));
        let mut by_state = DMatrix::identity(state::DIMENSION, state::DIMENSION);
        by_state
            .fixed_view_mut::<3, 3>(part::ORIENTATION, part::ORIENTATION)
            .copy_from(&so3::right_jacobian_inverse(&turn));
        for (row, mut of_row) in by_state.row_iter_mut().enumerate() {
            of_row *= root / self.units[row / 3];
        }
        ((self.miss(state) + &self.left) * root, by_state)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};

    use super::*;
    use crate::math::differentiate::jacobian;

    #[test]
    fn derivatives_are_those_of_the_residuals() {
        let state = |shift: f64| State {
            position_m: Vector3::new(0.1, -0.2, 0.3) * shift,
            orientation: UnitQuaternion::from_scaled_axis(Vector3::new(0.4, 0.9, -1.1) * shift),
            velocity_m_s: Vector3::new(1.0, 2.0, -3.0) * shift,
            angular_velocity_rad_s: Vector3::new(-4.0, 5.0, 6.0) * shift,
        };
        for last in [2.0, f64::INFINITY] {
            let pull = Pull {
                left: DVector::from_fn(state::DIMENSION, |row, _| row as f64),
                ..Pull::new(0, state(1.0), 7.0, [0.01, 0.1, 0.2, last])
            };
            let at = state(-0.7);
            let (_, by_state) = pull.term(&at);
            let expected = jacobian(state::DIMENSION, state::DIMENSION, |delta| {
                let there = at.retract(&StateTangent::from_column_slice(delta));
                pull.term(&there).0.as_slice().to_vec()
            });
            for (row, expected) in expected.iter().enumerate() {
                for (column, expected) in expected.iter().enumerate() {
                    let off = by_state[(row, column)] - expected;
                    assert!(off.abs() < 1e-8, "{row} {column}: {off}");
                }
            }
        }
    }
}
