//! The sets of vectors, and weights.

use nalgebra::Vector3;

use super::Table;
use super::vector::{VectorKeys, sd};
use crate::config::error::{Fault, fault};
use crate::config::number::{direction, positive, vector};
use crate::config::raw::Corners;
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
