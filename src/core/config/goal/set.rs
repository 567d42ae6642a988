//! The sets of vectors, and weights.

use nalgebra::Vector3;

use super::Table;
use super::vector::{VectorKeys, sd};
use crate::config::error::{Fault, fault};
use crate::config::number::{direction, positive, vector};
use crate::config::raw::Corners;
use crate::math::Pose;
use crate::motion::GoalSet;

impl Table<'_> {
    /// The set of a vector, with its weight; `None` where the goal is not about it.
    pub(super) fn set(
        &mut self,
        keys: &VectorKeys,
    ) -> Result<Option<(GoalSet, Option<f64>)>, Fault> {
        let (exact, within) = (keys.exact.1.as_ref(), keys.within.1.as_ref());
        let set = match (exact, within) {
            (None, None) => return Ok(None),
            (Some(_), Some(within)) => {
                return fault(
                    within.span(),
                    format!("expected one of {}, {}", keys.exact.0, keys.within.0),
                );
            }
            (None, Some(within)) => corners(keys.within.0, within, keys.unit)?,
            (Some(exact), None) => {
                self.used.add(&[keys.radius.0, "normal"]);
                let at = vector(keys.exact.0, exact)? * keys.unit;
                match (keys.radius.1, &self.raw.normal) {
                    (None, None) => GoalSet::point(at),
                    (Some(radius), None) => GoalSet::Ball {
                        centre: at,
                        radius: positive(keys.radius.0, radius)? * keys.unit,
                    },
                    (None, Some(triple)) => {
                        let normal = direction("normal", triple)?;
                        GoalSet::HalfSpace {
                            normal,
                            least: normal.dot(&at),
                        }
                    }
                    (Some(_), Some(normal)) => {
                        return fault(
                            normal.span(),
                            format!("expected one of {}, normal", keys.radius.0),
                        );
                    }
                }
            }
        };
        self.used.add(&[keys.exact.0, keys.within.0, keys.sd.0]);
        Ok(Some((set, sd(keys.sd.0, keys.sd.1, keys.unit)?)))
    }

    /// A normal is of one vector.
    pub(super) fn one_half_space(&self) -> Result<(), Fault> {
        let raw = self.raw;
        let exact = [&raw.position_mm, &raw.velocity_m_s, &raw.spin_rad_s];
        let count = exact.into_iter().flatten().count();
        match &raw.normal {
            Some(normal) if count > 1 => fault(
                normal.span(),
                format!("normal is of {count} vectors, expected a goal for each"),
            ),
            _ => Ok(()),
        }
    }
}

/// A set as it is in other axes. A box that is turned is the half-spaces of its sides: the distance from it is
/// that from all of them together. Fails, in words, of a turned box with a side that is an equality.
pub(super) fn in_axes(set: GoalSet, axes_from_given: &Pose) -> Result<Vec<GoalSet>, &'static str> {
    let (turn, shift) = (axes_from_given.rotation, axes_from_given.translation.vector);
    if *axes_from_given == Pose::identity() {
        return Ok(vec![set]);
    }
    let moved = |at: Vector3<f64>| turn * at + shift;
    Ok(match set {
        GoalSet::Ball { centre, radius } => vec![GoalSet::Ball {
            centre: moved(centre),
            radius,
        }],
        GoalSet::HalfSpace { normal, least } => {
            let normal = turn * normal;
            vec![GoalSet::HalfSpace {
                normal,
                least: least + normal.dot(&shift),
            }]
        }
        GoalSet::Box { lower, upper } if lower == upper => vec![GoalSet::point(moved(lower))],
        GoalSet::Box { lower, upper } if turn.angle() < 1e-12 => vec![GoalSet::Box {
            lower: lower + shift,
            upper: upper + shift,
        }],
        GoalSet::Box { lower, upper } => {
            if (0..3).any(|axis| lower[axis] == upper[axis]) {
                return Err(
                    "the body's axes are not its principal ones, and a box there has no side without a width: \
                     expected a width, or a position exactly or within a ball",
                );
            }
            let mut sides = Vec::new();
            for axis in 0..3 {
                for (sign, bound) in [(1.0, lower[axis]), (-1.0, upper[axis])] {
                    if bound.is_finite() {
                        let normal = turn * Vector3::ith(axis, sign);
                        sides.push(GoalSet::HalfSpace {
                            normal,
                            least: sign * bound + normal.dot(&shift),
                        });
                    }
                }
            }
            sides
        }
    })
}

/// A box between two corners.
fn corners(key: &str, given: &Corners, unit: f64) -> Result<GoalSet, Fault> {
    let [lower, upper] = given.get_ref();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let (low, high) = (lower[axis], upper[axis]);
        // `low <= high` is false for NaN too.
        let some_room = low <= high && low < f64::INFINITY && high > f64::NEG_INFINITY;
        if !some_room {
            return fault(
                given.span(),
                format!(
                    "{key} allows {name} from {low} to {high}, expected a lower bound and one not below it"
                ),
            );
        }
    }
    if lower.iter().chain(upper).all(|bound| bound.is_infinite()) {
        return fault(
            given.span(),
            format!("{key} bounds nothing, expected at least one finite bound"),
        );
    }
    Ok(GoalSet::Box {
        lower: Vector3::from(*lower) * unit,
        upper: Vector3::from(*upper) * unit,
    })
}
