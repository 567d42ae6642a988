//! The unknowns: where each is in a step ([`layout`]), and their values ([`point`]).

pub mod kept;
pub mod layout;
pub mod point;
