//! Stage 4: the estimation (paper §4, DESIGN's eq. 1, 3, 6 to 8): a constrained least-squares
//! problem over states of arcs, event times, sample times and parameters.
//!
//! What is solved: [`problem`], with [`layout`] saying where each unknown sits, `nodes` at which
//! sample times are unknowns and [`point`] holding a value of all. Its terms: [`samples`], [`tempo`],
//! [`mark`], [`constraint`] and [`collision`], whose
//! rows are in [`block`]s, summed into a [`system`]. How it is solved: [`merit`] prices the constraints,
//! [`descend`] and [`finish`] (by the steps of [`kkt`], with [`active`] and [`qp`] to say which bounds act) move the point,
//! [`events`] lets it begin, [`recipe`] is the loop.
//! What is said of it: [`outcome`], [`covariance`], `timing`, `deviation`. [`solve`] is the stage as the pipeline sees it,
//! [`bound`] what its search over collision sequences rests on.

pub mod active;
mod arc_end;
pub mod block;
pub mod bound;
pub mod collision;
pub mod constraint;
pub mod covariance;
mod curvature;
pub mod descend;
mod deviation;
pub mod events;
pub mod finish;
pub mod kkt;
pub mod layout;
pub mod mark;
pub mod merit;
mod nodes;
pub mod outcome;
pub mod point;
pub mod problem;
pub mod qp;
pub mod recipe;
pub mod samples;
pub mod solve;
pub mod system;
pub mod tempo;
#[cfg(test)]
mod tests;
mod timing;

pub use bound::{Bound, Part};
pub use recipe::Recipe;
pub use solve::{Solved, cost, estimate};
