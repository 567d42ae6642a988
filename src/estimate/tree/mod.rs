//! The estimation of bodies joined in a tree, from a sketch with physical times.
//!
//! The unknowns are states of the tree at a few [nodes](problem) along its motion: at the start alone
//! (single shooting), or at more where errors grow too much from one end to the other (multiple shooting),
//! with the flow's end at each node as a hard condition. Samples and goals are quantities of one link's
//! state, which follows from the tree's ([`program`]). [`solve`] grows the part of the sketch that counts from
//! the start, brings the goals in by a sweep and finishes by sequential quadratic programming.

mod leg;
pub mod outcome;
pub mod problem;
pub mod program;
pub mod solve;
mod weak;

#[cfg(test)]
mod tests;

pub use outcome::estimate;
pub use problem::TreeProblem;
