//! Bounds of one parameter, `lower ≤ u ≤ upper` (paper §6), and which of them a value is at.

use super::kind::{At, Constraint, Filled};
use crate::estimate::problem::{Bounded, Problem};
use crate::estimate::unknowns::layout::Layout;
use crate::motion::{AtBound, Cone, FreeParameter};
use crate::optimise::block::{Block, BlockPattern};

/// How near a bound a value is at it, in lengths of the parameter.
const NEAR: f64 = 1e-6;

impl Constraint for Bounded {
    fn patterns(&self, _: &Problem, layout: &Layout) -> [BlockPattern; 2] {
        let columns = vec![layout.parameters[self.parameter]];
        [BlockPattern::dense(1, columns), BlockPattern::default()]
    }

    fn fill(&self, at: &mut At, [room, _]: [Filled; 2]) {
        let free = &at.problem.parameters[self.parameter];
        fill(free, at.point.parameters[self.parameter], room);
    }

    fn bounds_parameter(&self) -> Option<usize> {
        Some(self.parameter)
    }

    fn half_width(&self, rows: &Block) -> Option<f64> {
        let (lower, upper) = rows.bounds[0];
        Some(0.5 * (upper - lower))
    }
}

/// Fills the row of a parameter, in lengths of it.
pub(in crate::estimate) fn fill(free: &FreeParameter, value: f64, (pattern, block): Filled) {
    let unit = free.length();
    block.reset(pattern);
    block.values[0] = value / unit;
    block.bounds[0] = (free.lower / unit, free.upper / unit);
    block.derivatives_mut(pattern, 0)[0] = 1.0 / unit;
}

/// The bound at which one of the parameters is, or that of the cone that it is in.
pub(in crate::estimate) fn at_bound(
    parameters: &[FreeParameter],
    cones: &[Cone],
    values: &[f64],
    index: usize,
) -> Option<AtBound> {
    let free = &parameters[index];
    let is_at = |bound: f64| (values[index] - bound).abs() <= NEAR * free.length();
    let is_at_cone = cones.iter().any(|cone| {
        let [a, b] = cone.parameters.map(|of| values[of]);
        cone.parameters.contains(&index) && a.hypot(b) >= cone.limit * (1.0 - NEAR)
    });
    match () {
        () if is_at_cone => Some(AtBound::Cone),
        () if is_at(free.lower) => Some(AtBound::Lower),
        () if is_at(free.upper) => Some(AtBound::Upper),
        () => None,
    }
}
