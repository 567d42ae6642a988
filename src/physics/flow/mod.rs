//! The flow `Φ` of a free rigid body: the map (state, duration) → state, with its derivatives.
//!
//! ```text
//! x(s) = x + v s + ½ g s²,   v(s) = v + g s
//! I ω̇ = (I ω) × ω,   Ṙ = R [ω]×                    Euler's equations, ω in body axes
//! ```
//!
//! How the rotation is integrated depends on the principal moments:
//!
//! - three or two equal: a closed form (`axial`);
//! - three different: Taylor series of Euler's equations, step by step (`asymmetric`, whose
//!   series are in `series`).
//!
//! Both are exact to rounding for durations of either sign, and agree where moments become equal.
//! Derivatives are by right perturbations.

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
