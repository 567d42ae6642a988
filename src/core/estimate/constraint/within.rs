//! Rows of a vector that must be in a set. A row's violation is the distance from the set, or for a box
//! its component: half the sum of their squares is half the squared distance.
//!
//! A box has a row for every number that it bounds, a half-space one for the way along its normal.
//! A ball of radius `r` has one for the distance `ρ` from its centre, which has no derivative there;
//! within half the radius it is flattened to a parabola that joins on smoothly:
//!
//! ```text
//! ρ ≤ r, from r/2 on;    ρ²/r + r/4 ≤ r, within
//! ```

use nalgebra::{Matrix3, Vector3};

use crate::estimate::problem::arc_condition::Rows;
use crate::motion::GoalSet;

/// A row: its value, bounds, and derivatives by the vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::estimate) struct WithinRow {
    pub(in crate::estimate) value: f64,
    pub(in crate::estimate) bounds: (f64, f64),
    pub(in crate::estimate) by: Vector3<f64>,
    /// Second derivatives.
    pub(in crate::estimate) second: Matrix3<f64>,
}

impl Rows {
    /// For a vector that must be in a set.
    pub(in crate::estimate) fn at(&self, set: &GoalSet, x: &Vector3<f64>) -> Vec<WithinRow> {
        match self {
            Self::Axes(axes) => axes.iter().map(|axis| along(set, x, *axis)).collect(),
            Self::OnFace(tangents) => tangents
                .iter()
                .map(|tangent| equal_along(set, x, tangent))
                .collect(),
            Self::Single => vec![single(set, x)],
        }
    }
}

/// The row of a box for one number.
fn along(set: &GoalSet, x: &Vector3<f64>, axis: usize) -> WithinRow {
    let GoalSet::Box { lower, upper } = set else {
        unreachable!("only boxes are bounded axis by axis");
    };
    WithinRow {
        value: x[axis],
        bounds: (lower[axis], upper[axis]),
        by: Vector3::ith(axis, 1.0),
        second: Matrix3::zeros(),
    }
}

/// The row of an equality to a point along a unit vector.
fn equal_along(set: &GoalSet, x: &Vector3<f64>, along: &Vector3<f64>) -> WithinRow {
    let GoalSet::Box { lower: to, .. } = set else {
        unreachable!("only a point is equal to something");
    };
    WithinRow {
        value: along.dot(&(x - to)),
        bounds: (0.0, 0.0),
        by: *along,
        second: Matrix3::zeros(),
    }
}

/// The one row of a ball or a half-space.
fn single(set: &GoalSet, x: &Vector3<f64>) -> WithinRow {
    match set {
        GoalSet::Ball { centre, radius } => {
            let offset = x - centre;
            let distance = offset.norm();
            let bounds = (f64::NEG_INFINITY, *radius);
            if distance >= 0.5 * radius {
                let by = offset / distance;
                WithinRow {
                    value: distance,
                    bounds,
                    by,
                    second: (Matrix3::identity() - by * by.transpose()) / distance,
                }
            } else {
                WithinRow {
                    value: distance * distance / radius + 0.25 * radius,
                    bounds,
                    by: offset * (2.0 / radius),
                    second: Matrix3::from_diagonal_element(2.0 / radius),
                }
            }
        }
        GoalSet::HalfSpace { normal, least } => WithinRow {
            value: normal.dot(x),
            bounds: (*least, f64::INFINITY),
            by: *normal,
            second: Matrix3::zeros(),
        },
        GoalSet::Box { .. } => unreachable!("a box has a row per number"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::differentiate;
    use crate::math::random::Random;

    const RADIUS: f64 = 0.3;

    fn sets() -> [GoalSet; 2] {
        [
            GoalSet::Ball {
                centre: Vector3::new(0.1, -0.2, 0.4),
                radius: RADIUS,
            },
            GoalSet::HalfSpace {
                normal: Vector3::new(0.6, 0.0, -0.8),
                least: 0.2,
            },
        ]
    }

    /// At the centre of a ball, where its row is flattened, beside it, inside, outside.
    fn places(set: &GoalSet) -> Vec<Vector3<f64>> {
        let GoalSet::Ball { centre, .. } = set else {
            return vec![Vector3::new(0.3, 0.1, -0.5)];
        };
        let away = Vector3::new(0.48, 0.6, -0.64);
        let shares = [0.0, 1e-9, 0.3, 0.499, 0.501, 0.9, 1.0, 1.7, 40.0];
        shares
            .map(|share| centre + away * (share * RADIUS))
            .to_vec()
    }

    #[test]
    fn derivatives_are_exact_also_where_a_distance_has_none() {
        for set in sets() {
            for place in places(&set) {
                let row = single(&set, &place);
                let step = 1e-3 * RADIUS;
                let at = |d: &[f64]| place + Vector3::from_column_slice(d) * step;
                let by = differentiate::jacobian(1, 3, |d| vec![single(&set, &at(d)).value]);
                let second =
                    differentiate::jacobian(3, 3, |d| single(&set, &at(d)).by.as_slice().to_vec());
                for i in 0..3 {
                    let error = (by[0][i] / step - row.by[i]).abs();
                    assert!(error < 1e-7, "{set:?} {place:?}: {error}");
                    for j in 0..3 {
                        let error = (second[i][j] / step - row.second[(i, j)]).abs();
                        assert!(error < 1e-5, "{set:?} {place:?}: {error}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_violation_is_the_distance_from_the_set() {
        let mut random = Random::default();
        for set in sets() {
            for _ in 0..100 {
                let x = Vector3::from_fn(|_, _| random.normal());
                let row = single(&set, &x);
                let beyond = row.value - row.value.clamp(row.bounds.0, row.bounds.1);
                let error = beyond.abs() - set.distance(&x).max(0.0);
                assert!(error.abs() < 1e-14, "{set:?}");
            }
        }
    }
}
