//! The flow `Φ` of a free rigid body: the map (state, duration) → state, with its derivatives.
//!
//! ```text
//! x(s) = x + v s + ½ p s²,   v(s) = v + p s      without drag, p = g + f
//! I ω̇ = (I ω) × ω,   Ṙ = R [ω]×                    Euler's equations, ω in body axes
//! ```
//!
//! With drag and lift the centre of mass is integrated (`fall`, whose steps are in `glide`).
//!
//! How the rotation is integrated depends on the principal moments:
//!
//! - three or two equal: a closed form (`axial`);
//! - three different: Taylor series of Euler's equations, step by step (`asymmetric`, whose
//!   series are in `series`).
//!
//! What is supported by a plane slides, rolls or rests on it, and what is tied to a place turns about that (`supported`).
//!
//! Both rotations are exact to rounding for durations of either sign, and agree where moments become equal.
//! Derivatives are by right perturbations. Those of any rotation by the moments are series too
//! ([`SpinByMoments`]).

mod asymmetric;
mod axial;
mod fall;
mod flight;
mod flown;
mod free;
mod glide;
#[cfg(test)]
#[path = "../../../../tools/src/reference.rs"]
mod reference;
mod series;
mod supported;
#[cfg(test)]
mod tests;
mod turn;
mod turned;

pub use asymmetric::moments::{SpinByMoments, TurnByMoments, turn_by_moments};
pub use asymmetric::{ANGLE_MAX_RAD, Steps};
pub(super) use axial::Precession;
pub use fall::{Fall, Fallen, FallenBySpinning};
pub use flight::{advance, position, rate, velocity};
pub use flown::Flown;
pub use free::{FreeFlown, WantedDerivatives};
pub use supported::{Carried, LEAST_TURNING_M_S, Supported};
pub use turn::{Spin, Turns, turn};
pub use turned::Turn;
