//! Calm: a pull towards rest, which chooses among motions that are seen alike.
//!
//! Of a body whose centre of mass alone is seen, nothing tells how it turns, but as far as impacts and goals
//! do. Of all motions that are seen alike the least is meant: the state `q = (x, R, v, ω)` of a flight of
//! which no track sees both places and orientations is pulled to rest,
//!
//! ```text
//! ½ |U⁻¹ (q ⊟ rest)|²
//! ```
//!
//! with units `U` so large that nothing that is seen gives way. What only a pull holds counts as
//! undetermined ([`covariance`](super::covariance)).

use nalgebra::{DMatrix, DVector};

use super::problem::{Arc, Calm, Shows};
use crate::math::so3;
use crate::physics::State;
use crate::physics::state::{self, part};

/// How far from rest a motion may stray where nothing is seen of it: a standard deviation of position
/// \[m\], orientation \[rad\], velocity [m/s] and angular velocity [rad/s].
const STRAY: [f64; 4] = [30.0, 10.0, 30.0, 100.0];

/// A unit of a track that is so many of the scene's weighs its samples to nothing.
const NOTHING: f64 = 1e3;

impl Calm {
    /// The pulls on arcs of which places or orientations are not seen; `units` are the scene's of
    /// residuals.
    pub(super) fn on(arcs: &[Arc], units: [f64; 2]) -> Vec<Self> {
        let pulls = arcs.iter().enumerate().filter_map(|(arc, of)| {
            let [place, turn] = [0, 1].map(|kind| is_seen(of, (kind, units[kind])));
            let unit = |part: usize| {
                let is_seen = [place, turn][part % 2];
                if is_seen { f64::INFINITY } else { STRAY[part] }
            };
            let is_open = of.sample_count() > 0 && !(place && turn);
            is_open.then(|| Self {
                arc,
                units: std::array::from_fn(unit),
            })
        });
        pulls.collect()
    }

    /// Residuals and their derivatives by the state's tangent.
    pub fn term(&self, state: &State) -> (DVector<f64>, DMatrix<f64>) {
        let delta = state.minus(&State::at_rest());
        let residuals =
            DVector::from_fn(state::DIMENSION, |row, _| delta[row] / self.units[row / 3]);
        let mut by_state = DMatrix::identity(state::DIMENSION, state::DIMENSION);
        by_state
            .fixed_view_mut::<3, 3>(part::ORIENTATION, part::ORIENTATION)
            .copy_from(&so3::right_jacobian_inverse(&so3::log(&state.orientation)));
        for (row, mut of_row) in by_state.row_iter_mut().enumerate() {
            of_row /= self.units[row / 3];
        }
        (residuals, by_state)
    }
}

/// Whether samples show the places (0) or the orientations (1) of a flight, with a weight that is not
/// nothing beside the scene's.
fn is_seen(arc: &Arc, (kind, unit): (usize, f64)) -> bool {
    let mut whole = arc.views.iter().filter(|view| match view.shows {
        Shows::Pose => true,
        Shows::Point => kind == 0 && view.is_plain,
        Shows::Orientation => kind == 1,
        Shows::Direction(_) => false,
    });
    whole.any(|view| !view.samples.is_empty() && view.units[kind] < NOTHING * unit)
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};

    use super::*;
    use crate::math::differentiate::jacobian;
    use crate::physics::state::StateTangent;

    #[test]
    fn derivatives_are_those_of_the_residuals() {
        let at = State {
            position_m: Vector3::new(0.1, -0.2, 0.3),
            orientation: UnitQuaternion::from_scaled_axis(Vector3::new(0.4, 0.9, -1.1)),
            velocity_m_s: Vector3::new(1.0, 2.0, -3.0),
            angular_velocity_rad_s: Vector3::new(-4.0, 5.0, 6.0),
        };
        let pull = Calm {
            arc: 0,
            units: [0.01, 0.1, 0.2, f64::INFINITY],
        };
        let (_, by_state) = pull.term(&at);
        let expected = jacobian(state::DIMENSION, state::DIMENSION, |delta| {
            let there = at.retract(&StateTangent::from_column_slice(delta));
            pull.term(&there).0.as_slice().to_vec()
        });
        for (row, expected) in expected.iter().enumerate() {
            for (column, expected) in expected.iter().enumerate() {
                let off = by_state[(row, column)] - expected;
                assert!(off.abs() < 1e-7, "{row} {column}: {off}");
            }
        }
    }
}
