//! Bounds of one parameter, `lower ≤ u ≤ upper` (paper §6).

use super::kind::{At, Constraint, Filled};
use crate::estimate::layout::Layout;
use crate::estimate::problem::{Bounded, Problem};
use crate::optimise::block::{Block, BlockPattern};

impl Constraint for Bounded {
    fn patterns(&self, _: &Problem, layout: &Layout) -> [BlockPattern; 2] {
        let columns = vec![layout.parameters[self.parameter]];
        [BlockPattern::dense(1, columns), BlockPattern::default()]
    }

    fn fill(&self, at: &mut At, [(pattern, block), _]: [Filled; 2]) {
        let free = &at.problem.parameters[self.parameter];
        let unit = free.length();
        block.reset(pattern);
        block.values[0] = at.point.parameters[self.parameter] / unit;
        block.bounds[0] = (free.lower / unit, free.upper / unit);
        block.derivatives_mut(pattern, 0)[0] = 1.0 / unit;
    }

    fn half_width(&self, rows: &Block) -> Option<f64> {
        let (lower, upper) = rows.bounds[0];
        Some(0.5 * (upper - lower))
    }
}
