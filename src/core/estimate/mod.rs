//! Stage 4: the estimation (paper eq. 1, 3, 6 to 8): a constrained least-squares problem over
//! states of arcs, event times, sample times and parameters.
//!
//! Its rooms, each using those before it alone:
//!
//! - [`problem`]: arcs, events, goals, and the roles of parameters beside gravity and laws ([`problem::influence`]).
//! - [`unknowns`]: their places in a step and their values.
//! - [`terms`]: the objective. `reach`: states at events with derivatives.
//! - [`wander`]: the errors of a hand as a process in time. [`covariance`]: how certain unknowns are.
//! - [`constraint`]: one file for each kind of hard condition. `curvature`: second derivatives of rows and residuals.
//! - `posing`: the problem of a scene and a sketch. Waypoints are moments of flights: one unknown each, and no cut. Bodies in
//!   the hand have no flights, but a state at each of their collisions.
//! - [`schedule`]: the way to the solution. [`outcome`]: the solution as an estimate.
//! - [`adequacy`]: whether it explains the performance.
//! - [`solve`]: the stage as the pipeline calls it; [`solve::bound`] gives lower bounds to the search over collision sequences.
//! - [`SharedMotion`]: what a motion says of quantities that several takes share.
//! - [`tree`]: the same of bodies joined in trees.

pub mod adequacy;
pub mod constraint;
pub mod covariance;
mod curvature;
pub mod outcome;
mod posing;
pub mod problem;
mod reach;
pub mod schedule;
mod sharing;
pub mod solve;
pub mod terms;
#[cfg(test)]
mod tests;
pub mod tree;
pub mod unknowns;
pub mod wander;

pub use covariance::whitened::Whitened;
pub use schedule::recipe::Recipe;
pub use sharing::SharedMotion;
pub use solve::bound::{Bound, Part};
pub use solve::last::LastState;
pub use solve::sharing::HeldBodies;
pub use solve::together::VariedTogether;
pub use solve::{Deviations, Solved, cost, estimate};
