//! The estimation of bodies joined in trees, and of bodies by themselves beside them, from a sketch with physical
//! times.
//!
//! All that moves is one [forest](crate::physics::tree::Forest). The unknowns are its states at a few
//! [nodes](problem) along its motion: at the start alone (single shooting), or at the ends of shooting intervals where errors grow too much
//! from one end to the other (multiple shooting), with the flow's end at each node as a hard condition, and times of
//! impacts and waypoints on the way. At an impact a gap is zero and the rates jump. Samples and goals are quantities
//! of links' states, which follow from that of all ([`program`]). [`solve`](mod@solve) grows the part of the sketch that counts from
//! the start, brings the goals in by a sweep and finishes by sequential quadratic programming.

mod adequacy;
mod apart;
pub mod before;
mod bounds;
pub mod clearance;
mod continuation;
mod curvature;
mod evaluation;
pub mod event;
mod freed;
pub mod goal;
mod hands;
mod interval;
pub mod law;
mod modes;
mod motions;
mod nearness;
mod observability;
pub mod on_nodes;
mod optimum;
pub mod outcome;
mod overlapping;
pub mod part;
pub mod point;
pub mod problem;
pub mod program;
pub mod rival;
mod rows;
pub mod sample;
mod segments;
mod sharing;
mod slopes;
pub mod solve;
pub mod tempo;
mod time_line;
mod timed;
mod trajectory;
mod walk;
mod wandering;
mod whitened;

#[cfg(test)]
mod tests;

pub use before::Before;
pub use optimum::Solved;
pub use outcome::{Detail, estimate, evidence};
pub use point::TreePoint;
pub use problem::TreeProblem;
pub use rival::{RivalOutcome, rival};
pub use sharing::HeldTrees;
pub use solve::solve;
pub use walk::{EXACTLY, ROUGHLY};
