//! Contact geometry of two solids (paper §5.2): the features that may touch ([`Feature`]), and for
//! a pair of them the signed gap `φ`, the normal and the points of contact, with derivatives by the
//! poses ([`Contact`]).

mod derivative;
mod error;
mod feature;
mod moved;
mod pair;
mod touch;

pub use derivative::TouchDerivative;
pub use error::{ContactError, Degenerate};
pub use feature::Feature;
pub use pair::Contact;
pub use touch::{Frame, Touch};

#[cfg(test)]
mod tests;
