//! How a free body flies: the map (state, duration) → state, with its derivatives.
//!
//! The centre of mass is quadratic in time. How the body turns hangs on its moments:
//!
//! - three or two equal: a closed form (`axial`);
//! - three different: Taylor series of Euler's equations, step by step (`asymmetric`, whose
//!   series are in `series`).
//!
//! Both are exact to rounding for durations of either sign, and where moments become equal one
//! becomes the other. Derivatives are in right perturbations.

mod asymmetric;
mod axial;
mod flight;
#[cfg(test)]
#[path = "../../../tools/src/reference.rs"]
mod reference;
mod series;
#[cfg(test)]
mod tests;
mod turn;
mod turned;

pub use asymmetric::ANGLE_MAX_RAD;
pub(super) use axial::Precession;
pub use flight::{advance, position, rate};
pub use turn::{Spin, turn};
pub use turned::Turn;
