//! Hard conditions as rows `lower ≤ v ≤ upper` in the units of [`unit`](super::problem::unit), a kind to
//! a file: what happens at a [`collision`] (`contact` and approach, then `continuity` through the
//! impact), a `goal` (paper §3.1), the `bound` of a parameter, a `cone` of two.
//!
//! What every kind answers is the trait [`Constraint`]; what a row is, is said in [`crate::optimise::block`].

mod bound;
pub mod collision;
mod cone;
mod contact;
mod continuity;
mod goal;
mod kind;
mod rows;

pub use self::kind::{At, Constraint, Filled};
