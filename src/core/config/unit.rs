//! Units of free quantities in the file.

use crate::motion::Quantity;

/// A unit as files have it.
#[derive(Debug, PartialEq)]
pub struct Unit {
    /// The SI unit of its quantities, as in [`Quantity::unit`].
    of: &'static str,
    /// As messages name it, after a number.
    pub name: &'static str,
    /// Value of the unit in SI units.
    pub si: f64,
}

/// One unit for each of [`Quantity::unit`].
const UNITS: [Unit; 8] = [
    unit("", "", 1.0),
    unit("m/s²", " m/s²", 1.0),
    unit("rad", "°", std::f64::consts::PI / 180.0),
    unit("m", " mm", 1e-3),
    unit("s", " ms", 1e-3),
    unit("s/s", " %", 1e-2),
    unit("1/s", " 1/s", 1.0),
    unit("1/m", " 1/m", 1.0),
];

const fn unit(of: &'static str, name: &'static str, si: f64) -> Unit {
    Unit { of, name, si }
}

impl Unit {
    /// The unit in which the file has a quantity.
    pub fn of(quantity: Quantity) -> &'static Unit {
        let of = quantity.unit();
        let found = UNITS.iter().find(|unit| unit.of == of);
        found.expect("a unit for every quantity's")
    }
}
