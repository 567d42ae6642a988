//! Where two solids touch: the features that may meet ([`Feature`]), and for a pair of them the
//! gap, the normal and the points that touch, with their derivatives ([`Contact`]).

mod derivative;
mod error;
mod feature;
mod pair;
mod touch;

pub use derivative::TouchDerivative;
pub use error::{ContactError, Degenerate};
pub use feature::Feature;
pub use pair::Contact;
pub use touch::{Frame, Touch};

#[cfg(test)]
mod tests;
