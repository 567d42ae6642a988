//! Units of free quantities in the file.

use super::error::{Fault, fault};
use super::raw::{Number, RawFree};
use crate::motion::Quantity;

/// A unit as keys have it.
#[derive(Debug, PartialEq)]
pub(super) struct Unit {
    /// The SI unit of its quantities, as in [`Quantity::unit`].
    of: &'static str,
    /// Suffix of the keys.
    pub(super) suffix: &'static str,
    /// Value of the unit in SI units.
    pub(super) si: f64,
}

/// One unit for each of [`Quantity::unit`].
pub(super) const UNITS: [Unit; 8] = [
    unit("", "", 1.0),
    unit("m/s²", "_m_s2", 1.0),
    unit("rad", "_deg", std::f64::consts::PI / 180.0),
    unit("m", "_mm", 1e-3),
    unit("s", "_ms", 1e-3),
    unit("s/s", "_percent", 1e-2),
    unit("1/s", "_per_s", 1.0),
    unit("1/m", "_per_m", 1.0),
];

const fn unit(of: &'static str, suffix: &'static str, si: f64) -> Unit {
    Unit { of, suffix, si }
}

impl Unit {
    /// The unit in which the file has a quantity.
    pub(super) fn of(quantity: Quantity) -> &'static Unit {
        let of = quantity.unit();
        let found = UNITS.iter().find(|unit| unit.of == of);
        found.expect("a unit for every quantity's")
    }

    /// The number at a key in this unit; refuses the key in another.
    pub(super) fn number<'a>(
        &self,
        free: &'a RawFree,
        key: &str,
    ) -> Result<Option<&'a Number>, Fault> {
        for other in UNITS.iter().filter(|other| *other != self) {
            if let Some(number) = free.number(&format!("{key}{}", other.suffix)) {
                return fault(
                    number.span(),
                    format!(
                        "{key}{} does not apply to {}, expected {key}{}",
                        other.suffix,
                        free.quantity.get_ref(),
                        self.suffix
                    ),
                );
            }
        }
        Ok(free.number(&format!("{key}{}", self.suffix)))
    }
}
