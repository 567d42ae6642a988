//! One answer from many takes: the arithmetic, without takes. What each says is a [`TakeShare`](crate::motion::TakeShare).
//!
//! With `f*_k(p)` the least half square of take `k` at values `p` of what all share, the joint optimum is that of
//!
//! ```text
//! F(p) = Σ_k f*_k(p) + priors(p),   lower ≤ p ≤ upper
//! ```
//!
//! which is that of all takes stacked in one problem, since nothing but `p` ties them. A round is one of Newton's steps with
//! the reduced gradients and Hessians of the takes ([`search`]); it costs what the takes cost, and a dense system as large
//! as `p`. Sums go in the order in which takes are given.
//!
//! A parameter may be *drawn*: each take has its own value, of a normal distribution over takes whose mean and spread are
//! estimated, the spread by restricted likelihood ([`spread`]). What a take says of its own value is marginalised
//! ([`part`]).
//!
//! [`weak`]: what the takes together do not determine. [`interval`]: intervals by how takes differ, not by their noise.
//! [`judge`]: takes that stand out, and what each of them does to the answer. All numbers inside are in
//! [lengths](crate::motion::FreeParameter::length) of the parameters.

mod begin;
pub mod interval;
pub mod judge;
pub mod parameter;
pub mod part;
pub mod search;
pub mod spread;
mod step;
#[cfg(test)]
mod tests;
pub mod weak;

pub use interval::{JointInterval, Spreads};
pub use judge::{Standout, TakeJudged};
pub use parameter::JointParameter;
pub use search::{JointSearch, SearchTurn};
pub use weak::WeakDirection;
