//! Stage 4: the estimation (paper eq. 1, 3, 6 to 8): a constrained least-squares problem over
//! states of arcs, event times, sample times and parameters.
//!
//! - The problem: [`problem`], made of a scene and a sketch by `posing`, goals in general ([`arc_condition`]) by `conditions`, with the indices of the unknowns in [`layout`], the `nodes` at which
//!   sample times are unknowns, and their values in a [`point`].
//! - Its terms: [`samples`], `levered` (points, directions, covariances), [`tempo`] and [`mark`], summed into an `objective`; a [`constraint`]
//!   for each hard condition. `evaluate` joins them for the [optimiser](crate::optimise), with a
//!   [`context`] that is fixed during a solve and the `curvature` of constraints and residuals.
//! - The way to the solution: [`events`] gives the first event times, `hand_on` the first states of
//!   flights without samples, [`recipe`] the schedule.
//! - Waypoints are moments of flights (`waypoint`): one unknown each, and no cut.
//! - Bodies in the hand have no flights, but a state at each of their collisions ([`held`]).
//! - Parameters beside gravity and laws have roles ([`influence`]); where one acts, residuals
//!   (`observed`) and arrivals (`arrival`) take their general form.
//! - Its result: [`outcome`], [`covariance`], `timing`, `deviation`; whether it explains the
//!   performance: [`adequacy`].
//!
//! [`solve`] is the stage as the pipeline calls it; [`bound`] gives lower bounds to the search over
//! collision sequences.

pub mod adequacy;
pub mod arc_condition;
mod arc_end;
mod arrival;
pub mod bound;
mod calm;
mod conditions;
pub mod constraint;
pub mod context;
pub mod covariance;
mod curvature;
mod deviation;
mod evaluate;
pub mod events;
mod hand_on;
pub mod held;
mod held_motion;
pub mod influence;
pub mod layout;
mod lever_rows;
mod levered;
pub mod mark;
mod modelled;
mod nodes;
mod objective;
mod observed;
pub mod outcome;
pub mod point;
mod posing;
pub mod problem;
mod pull;
pub mod recipe;
mod sample_order;
pub mod samples;
mod seen;
mod short;
mod simulate;
pub mod solve;
pub mod tempo;
#[cfg(test)]
mod tests;
mod timing;
pub mod tree;
mod waypoint;
mod whitened;

pub use bound::{Bound, Part};
pub use recipe::Recipe;
pub use solve::last::LastState;
pub use solve::{Solved, cost, estimate};
pub use whitened::Whitened;
