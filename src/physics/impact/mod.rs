//! How bodies bounce: off the static world or off each other, at one contact with Coulomb
//! friction or at up to three at once without ([`Meeting`]); with exact derivatives.
//!
//! The law at one contact is Chatterjee and Ruina's algebraic one ([`Law`]). [`bounce`] is its
//! special case of a point on a fixed plane without friction.

mod bounce;
mod coulomb;
mod derivative;
mod encounter;
mod error;
mod meeting;
mod newton;
mod plane;
mod rows;
mod solution;

pub use bounce::{BounceDerivative, Contact, bounce, bounce_derivative};
pub use derivative::ImpactDerivative;
pub use error::{ImpactError, MeetingError};
pub use meeting::{Impact, Law, Meeting, Side, Velocities};

#[cfg(test)]
mod tests;
