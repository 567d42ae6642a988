//! What a motion follows of a change of a quantity that the scene keeps fixed.
//!
//! At a solution with Hessian `H` and constraints' derivative `C`, let `h` and `c_θ` be the mixed second derivative and the
//! constraints' derivative by a quantity `θ`. What the motion can follow of a change of `θ` is `z`:
//!
//! ```text
//! [H Cᵀ; C 0] [z; ·] = [h; c_θ],   d = (θ: 1, motion: −z)
//! ```
//!
//! No further solve is made.

use nalgebra::DVector;

use crate::estimate::terms::context::SolveContext;
use crate::optimise::kkt::Kkt;
use crate::optimise::{Program, System};

/// Greatest number of refinements of a direction; they end where one changes less than this share. What holds a motion whose
/// samples err in time pulls by much more than what a direction changes.
const REFINEMENTS: usize = 12;
const REFINED: f64 = 1e-11;

/// `d` of each parameter from the `first` on.
pub(super) fn directions(
    extended: &SolveContext,
    system: &System,
    base: &SolveContext,
    kkt: &Kkt,
    first: usize,
) -> Vec<DVector<f64>> {
    let of_each = extended.layout.parameters[first..].iter();
    of_each
        .map(|at| direction(extended, system, base, kkt, *at))
        .collect()
}

/// `d` of one parameter, over all unknowns of the extended problem, of which those of the base are the first.
fn direction(
    context: &SolveContext,
    system: &System,
    base: &SolveContext,
    kkt: &Kkt,
    at: usize,
) -> DVector<f64> {
    let size = base.layout.size();
    let pattern = &context.structure().pattern;
    let mut unit = DVector::zeros(context.layout.size());
    unit[at] = 1.0;
    let mut mixed = DVector::zeros(unit.len());
    system.hessian.multiply_add(pattern, &unit, &mut mixed);
    // Minus the derivative of the quadratic penalty's gradient along the direction so far.
    let mut direction = unit;
    for refinement in 0..REFINEMENTS {
        let mut pulled = DVector::zeros(direction.len());
        if refinement == 0 {
            pulled += &mixed;
        }
        kkt.add_pulled(context.structure(), system, &direction, &mut pulled);
        let mut step = pulled.rows(0, size).into_owned();
        kkt.solve(base.structure(), &mut step);
        let is_refined = step.amax() <= REFINED * direction.amax();
        let mut own = direction.rows_mut(0, size);
        own -= step;
        if is_refined {
            break;
        }
    }
    direction
}
