//! Stage 4b: is the estimated motion what it says? Checked by other means than it was found by.
//!
//! `overlap` looks for solids inside one another along the arcs, `touch` for another part of
//! a body that would have touched before the expected one, both by parry's distances. `shot`
//! simulates the whole motion from the first states alone: flights by the Taylor series of
//! Euler's equations (`series`), collisions by distance. `balance` sums up energy and
//! momentum. [`verify`](verify()) is that as the pipeline sees it. [`credible`] asks besides whether
//! such a motion could be what was acted.

mod balance;
pub mod credible;
mod expected;
mod gap;
mod law;
mod meeting;
mod moving;
mod overlap;
mod series;
mod shot;
#[cfg(test)]
mod tests;
mod touch;
mod whole;

pub use overlap::TOLERANCE_M;
pub use whole::{touches, verify};
