//! Constraints as rows `lower ≤ c ≤ upper` in the units of [`unit`](crate::estimate::problem::unit), one kind
//! per file: a [`collision`] (paper eq. 3, 8; `contact` and approach, §5.2, then `continuity`
//! through the impact), a `goal` (§3.1), any other `condition` that a goal is, a bound of an event's `time`, the `bound` of a parameter, a
//! `cone` of two (§6), the `order` of two events (eq. 7), a `clearance` of two solids, `sticking` where two bodies become one.
//!
//! [`Constraint`] is the interface of all kinds; rows are stored in a [`crate::optimise::block`].

pub(in crate::estimate) mod bound;
mod change;
mod clearance;
pub mod collision;
mod condition;
pub(in crate::estimate) mod cone;
mod contact;
mod continuity;
mod general;
mod goal;
mod kind;
pub(in crate::estimate) mod least;
mod order;
pub(in crate::estimate) mod quantity;
mod reached;
mod rows;
mod sample_order;
mod sticking;
mod support;
mod time;
pub(in crate::estimate) mod touched;
pub(in crate::estimate) mod within;

pub use self::kind::{At, Constraint, Filled};
