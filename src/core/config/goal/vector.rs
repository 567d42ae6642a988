//! The keys of vectors, and weights.

use crate::config::error::{Fault, fault};
use crate::config::number::positive;
use crate::config::raw::{Corners, Number, Triple};

/// The keys of a vector.
pub(super) struct VectorKeys<'a> {
    pub(super) exact: (&'static str, &'a Option<Triple>),
    pub(super) within: (&'static str, &'a Option<Corners>),
    pub(super) radius: (&'static str, &'a Option<Number>),
    pub(super) sd: (&'static str, &'a Option<Number>),
    /// Their unit in SI units.
    pub(super) unit: f64,
}

/// Least standard deviation of a wish: a thousandth of its key's unit.
const SD_MIN: f64 = 1e-3;

/// A standard deviation, in SI units.
pub(super) fn sd(key: &str, number: &Option<Number>, unit: f64) -> Result<Option<f64>, Fault> {
    let Some(number) = number else {
        return Ok(None);
    };
    let sd = positive(key, number)?;
    if sd < SD_MIN {
        return fault(
            number.span(),
            format!("{key} is {sd}, expected {SD_MIN} or more: without it the goal is hard"),
        );
    }
    Ok(Some(sd * unit))
}
