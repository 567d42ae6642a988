//! How bodies bounce: off the static world or off each other, at one contact with Coulomb
//! friction or at up to three at once without ([`ContactSet`]); with exact derivatives.
//!
//! The law at one contact is Chatterjee and Ruina's algebraic one ([`Law`]).

mod bounce;
mod contact_set;
mod contact_state;
mod coulomb;
mod derivative;
mod error;
mod law;
mod newton;
mod plane;
mod rows;
mod solution;

pub use contact_set::ContactSet;
pub use derivative::ImpactDerivative;
pub use error::{ContactSetError, ImpactError};
pub use law::{Impact, Law, Side, Velocities};

#[cfg(test)]
mod tests;
