//! Impacts, `Impact` in the paper's eq. 3 and 8: velocities of one or two bodies after a collision
//! from their states before it, with exact derivatives. Bodies meet the static world or each other,
//! at one contact with Coulomb friction, at up to three simultaneous ones without, or flat on a face with friction
//! ([`ContactSet`]).
//!
//! Derivatives by the states and by the law are in [`ImpactDerivative`], those by masses, moments and
//! the places of features in [`ImpactByModel`].
//!
//! A contact may last for a while ([`Pressed`]).
//!
//! The law at one contact is the algebraic one of Chatterjee and Ruina ([`Law`]); that of a flat landing is in
//! `landing`.

mod bounce;
mod contact_set;
mod contact_state;
mod coulomb;
mod derivative;
mod error;
mod inertia;
mod knock;
mod landing;
mod law;
mod model;
mod newton;
mod plane;
mod pressed;
mod rows;
mod solution;

pub use contact_set::ContactSet;
pub use derivative::ImpactDerivative;
pub use error::{ContactSetError, ImpactError};
pub use knock::Knock;
pub use law::{Impact, Law, Side, Velocities};
pub use model::ImpactByModel;
pub use pressed::{Pressed, PressedOn};

pub(crate) use contact_state::tilted;
pub(crate) use coulomb::{Coulomb, CoulombChange};
pub(crate) use newton::Newton;

#[cfg(test)]
mod tests;
