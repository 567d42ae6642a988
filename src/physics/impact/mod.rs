//! How bodies bounce: off the static world or off each other, at one contact with Coulomb
//! friction or at up to three at once without ([`ContactSet`]); with exact derivatives.
//!
//! The law at one contact is Chatterjee and Ruina's algebraic one ([`Law`]).

mod contact_set;
mod contact_state;
mod coulomb;
mod derivative;
mod error;
mod newton;
mod plane;
mod rows;
mod solution;

pub use contact_set::{ContactSet, Impact, Law, Side, Velocities};
pub use derivative::ImpactDerivative;
pub use error::{ContactSetError, ImpactError};

#[cfg(test)]
mod tests;
