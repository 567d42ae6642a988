//! Stage 4: the estimation (paper §4, DESIGN's eq. 1, 3, 6 to 8): a constrained least-squares
//! problem over states of arcs, event times, sample times and parameters.
//!
//! What is solved: [`problem`], with [`layout`] saying where each unknown sits, `nodes` at which
//! sample times are unknowns and [`point`] holding a value of all. Its terms: [`samples`], [`tempo`],
//! [`mark`], summed into an `objective`; what must hold is a [`constraint`]. `evaluate` puts them
//! together for the [optimiser](crate::optimise), with a [`context`] that stays fixed and the constraints'
//! `curvature`; [`events`] lets it begin, [`recipe`] says how it goes.
//! What is said of it: [`outcome`], [`covariance`], `timing`, `deviation`. [`solve`] is the stage as the pipeline sees it,
//! [`bound`] what its search over collision sequences rests on.

mod arc_end;
pub mod bound;
pub mod constraint;
pub mod context;
pub mod covariance;
mod curvature;
mod deviation;
mod evaluate;
pub mod events;
pub mod layout;
pub mod mark;
mod nodes;
mod objective;
pub mod outcome;
pub mod point;
pub mod problem;
pub mod recipe;
pub mod samples;
pub mod solve;
pub mod tempo;
#[cfg(test)]
mod tests;
mod timing;

pub use bound::{Bound, Part};
pub use recipe::Recipe;
pub use solve::{Solved, cost, estimate};
