//! Stage 4b: checks an estimated motion by other means than those of the estimation.
//!
//! `overlap` searches for solids inside one another along the arcs, `touch` for another part of
//! a body that would have touched before the expected one, both by parry's distances; `pull` for
//! contacts that would have to pull; `carried` for what no surface does to what is on it, and `tumble` for what no contacts do. `shot`
//! simulates the whole motion from the first states alone: flights by the Taylor series of
//! Euler's equations (`series`), collisions by distance. `balance` checks energy and momentum.
//! [`verify`](verify()) runs all of these. [`credible`] checks in addition whether the motion can
//! be what was acted; [`joined`] checks what is checked of joined bodies.

mod apart;
mod balance;
mod bound;
mod carried;
pub mod credible;
mod expected;
mod gap;
pub mod joined;
mod law;
mod link;
mod meeting;
mod moving;
mod overlap;
mod pull;
mod rest;
mod series;
mod shot;
#[cfg(test)]
mod tests;
mod tied;
mod touch;
mod tumble;
mod whole;

pub use rest::{is_met, lies, up_name};
pub use whole::{deepest_between, overlaps, overlaps_begin_s, touches, verify, verify_until};
