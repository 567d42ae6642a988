//! The state of a tree and its tangent space.

use nalgebra::{DMatrix, Quaternion, UnitQuaternion, Vector3};

use super::model::{Motor, Tree};
use crate::math::so3;
use crate::physics::state::State;

/// Coordinates and rates of a tree, laid out as [`Tree`] says.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeState {
    /// Coordinates `q`.
    pub coordinates: Vec<f64>,
    /// Rates `u`.
    pub rates: Vec<f64>,
    /// When it is so \[s\]. What hangs from the world or flies does not heed it, what hangs from a [hand](super::Hand)
    /// does.
    pub time_s: f64,
}

impl TreeState {
    /// That of a tree of one free link, of the state of its body.
    pub fn of_body(state: &State) -> Self {
        let turn = state.orientation.coords;
        Self {
            coordinates: state.position_m.iter().chain(&turn).copied().collect(),
            rates: state
                .velocity_m_s
                .iter()
                .chain(&state.angular_velocity_rad_s)
                .copied()
                .collect(),
            time_s: 0.0,
        }
    }
}

/// The quaternion `(i, j, k, w)` at the beginning of a slice, as it is.
#[inline(always)]
pub(super) fn quaternion(numbers: &[f64]) -> Quaternion<f64> {
    Quaternion::new(numbers[3], numbers[0], numbers[1], numbers[2])
}

fn unit(numbers: &[f64]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(quaternion(numbers))
}

fn vector(numbers: &[f64]) -> Vector3<f64> {
    Vector3::new(numbers[0], numbers[1], numbers[2])
}

impl Tree {
    /// At rest with all coordinates zero and all quaternions one; in a hand at a time that is still to be given,
    /// no number.
    pub fn at_rest(&self) -> TreeState {
        let mut coordinates = vec![0.0; self.coordinate_count()];
        for node in self.nodes.iter().filter(|node| node.motor == Motor::Ball) {
            coordinates[self.shift() + node.coordinate + 3] = 1.0;
        }
        TreeState {
            coordinates,
            rates: vec![0.0; self.freedoms()],
            time_s: match self.hand {
                Some(_) => f64::NAN,
                None => 0.0,
            },
        }
    }

    /// `q ⊞ δ`: quaternions change on the right, all else adds. Quaternions come out unit.
    pub fn retract(&self, state: &TreeState, delta: &[f64]) -> TreeState {
        let (shift, freedoms) = (self.shift(), self.freedoms());
        let mut moved = state.clone();
        for i in 0..shift {
            moved.coordinates[i] += delta[i];
        }
        for node in &self.nodes {
            let (at, from) = (shift + node.coordinate, shift + node.column);
            match node.motor {
                Motor::Pin | Motor::Slide => moved.coordinates[at] += delta[from],
                Motor::Ball => {
                    let turned = unit(&state.coordinates[at..]) * so3::exp(&vector(&delta[from..]));
                    let turned = turned.into_inner();
                    let turned = turned * (1.5 - 0.5 * turned.norm_squared());
                    moved.coordinates[at..at + 4].copy_from_slice(turned.coords.as_slice());
                }
            }
        }
        for (rate, change) in moved.rates.iter_mut().zip(&delta[freedoms..]) {
            *rate += change;
        }
        moved
    }

    /// `q ⊟ p` with `p = origin`: the tangent `δ` for which `p ⊞ δ = q`. Angles are not wrapped.
    pub fn minus(&self, state: &TreeState, origin: &TreeState) -> Vec<f64> {
        let (shift, freedoms) = (self.shift(), self.freedoms());
        let mut delta = vec![0.0; 2 * freedoms];
        for i in 0..shift {
            delta[i] = state.coordinates[i] - origin.coordinates[i];
        }
        for node in &self.nodes {
            let (at, to) = (shift + node.coordinate, shift + node.column);
            match node.motor {
                Motor::Pin | Motor::Slide => {
                    delta[to] = state.coordinates[at] - origin.coordinates[at];
                }
                Motor::Ball => {
                    let turn =
                        unit(&origin.coordinates[at..]).inverse() * unit(&state.coordinates[at..]);
                    delta[to..to + 3].copy_from_slice(so3::log(&turn).as_slice());
                }
            }
        }
        for i in 0..freedoms {
            delta[freedoms + i] = state.rates[i] - origin.rates[i];
        }
        delta
    }

    /// Derivatives of `q ⊟ p` by the tangents of `q` and of `p`: `J_r⁻¹(δ)` and `−J_l⁻¹(δ)` of a
    /// quaternion, one and minus one of all else.
    pub fn minus_jacobians(&self, state: &TreeState, origin: &TreeState) -> [DMatrix<f64>; 2] {
        let (shift, size) = (self.shift(), 2 * self.freedoms());
        let delta = self.minus(state, origin);
        let mut by = [1.0, -1.0].map(|sign| DMatrix::from_diagonal_element(size, size, sign));
        for node in self.nodes.iter().filter(|node| node.motor == Motor::Ball) {
            let at = shift + node.column;
            let turn = vector(&delta[at..]);
            let right = so3::right_jacobian_inverse(&turn);
            let left = -so3::right_jacobian_inverse(&-turn);
            by[0].fixed_view_mut::<3, 3>(at, at).copy_from(&right);
            by[1].fixed_view_mut::<3, 3>(at, at).copy_from(&left);
        }
        by
    }

    /// By how much each angle is beyond its limits \[rad\], negative within them, with its place among the
    /// coordinates.
    pub fn beyond_limits_rad(&self, state: &TreeState) -> impl Iterator<Item = (usize, f64)> {
        let pins = self.nodes.iter().filter(|node| node.motor == Motor::Pin);
        pins.map(|node| {
            let at = self.shift() + node.coordinate;
            let ([least, greatest], angle) = (node.limits_rad, state.coordinates[at]);
            (at, (least - angle).max(angle - greatest))
        })
    }

    /// The first coordinate that is beyond its limits: its place among the coordinates.
    pub fn beyond_limits(&self, state: &TreeState) -> Option<usize> {
        let mut all = self.beyond_limits_rad(state);
        all.find(|(_, off_rad)| !(*off_rad <= 0.0))
            .map(|(at, _)| at)
    }
}
