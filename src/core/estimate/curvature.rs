//! The part of the Lagrangian's Hessian that a Gauss–Newton step omits: the curvature of the
//! constraints and of the residuals,
//!
//! ```text
//! Σ_k ν_k ∇²c_k + Σ_i r_i ∇²r_i
//! ```
//!
//! Where multipliers or residuals are large, or where only a constraint determines an unknown (the
//! time of an apex), steps without it converge slowly or not at all. Both sums belong together: at
//! an apex the times of samples bend the objective as the time of a goal bends its constraint. What
//! is not in closed form is computed by differences of exact derivatives. It only shapes steps,
//! while the equations that are solved have exact derivatives, so that its error of some 10⁻⁸ costs
//! no digit of the result.

mod constraints;
mod general;
mod nudged;
mod residuals;

use self::nudged::Nudged;
use crate::estimate::terms::context::SolveContext;
use crate::estimate::unknowns::point::Point;
use crate::optimise::System;
use crate::optimise::envelope::Envelope;

/// Adds the curvature at a point with `multipliers` of the constraints, row by row.
pub(super) fn add(
    context: &SolveContext,
    system: &System,
    point: &Point,
    multipliers: &[f64],
    matrix: &mut Envelope,
) {
    let mut nudged = Nudged::new(context, point);
    constraints::add(&mut nudged, system, multipliers, matrix);
    residuals::add(context, system, point, multipliers, matrix);
    general::add(&mut nudged, matrix);
}
