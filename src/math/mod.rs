//! Rotations, linear algebra for chains of blocks, and numeric differentiation for tests.
//!
//! Conventions, chosen once: perturbation on the right, `R ⊞ θ = R·Exp(θ)`; quaternions are
//! Hamilton and unit, world from body; tangents in body axes.

pub mod envelope;
mod pose;
pub mod so3;

#[cfg(test)]
pub mod differentiate;

pub use pose::Pose;
