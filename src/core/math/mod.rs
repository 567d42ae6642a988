//! Rotations, poses and angles for them, numbers with derivatives, spans of columns, pseudo-random numbers, and numeric
//! differentiation for tests.
//!
//! Conventions, chosen once: perturbation on the right, `R ⊞ θ = R·Exp(θ)`; quaternions are
//! Hamilton and unit, world from body; tangents in body axes.

pub mod euler;
pub mod jet;
pub mod lanes;
mod pose;
pub mod random;
pub mod so3;
pub mod span;

#[cfg(test)]
pub mod differentiate;

pub use pose::Pose;
