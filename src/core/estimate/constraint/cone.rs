//! Two parameters, the tilts of a normal, within a circle (paper §6): `(p₀² + p₁²)/limit² ≤ 1`.

use super::kind::{At, Constraint, Filled};
use crate::estimate::problem::Problem;
use crate::estimate::unknowns::layout::Layout;
use crate::motion::Cone;
use crate::optimise::block::{Block, BlockPattern};

impl Constraint for Cone {
    fn patterns(&self, _: &Problem, layout: &Layout) -> [BlockPattern; 2] {
        let columns = self.parameters.map(|p| layout.parameters[p]);
        let pattern = BlockPattern::dense(1, columns.to_vec());
        [pattern, BlockPattern::default()]
    }

    fn fill(&self, at: &mut At, [(pattern, block), _]: [Filled; 2]) {
        fill(self, &at.point.parameters, (pattern, block));
        block.curvature = 2.0 / (self.limit * self.limit);
    }

    /// The row is quadratic in the distance from the middle.
    fn half_width(&self, rows: &Block) -> Option<f64> {
        Some(2.0 * rows.bounds[0].1)
    }
}

/// Fills the row of a cone with the values of all parameters, but for its curvature.
pub(in crate::estimate) fn fill(cone: &Cone, parameters: &[f64], (pattern, block): Filled) {
    let values = cone.parameters.map(|of| parameters[of]);
    let scale = 1.0 / (cone.limit * cone.limit);
    block.reset(pattern);
    block.values[0] = (values[0] * values[0] + values[1] * values[1]) * scale;
    block.bounds[0] = (f64::NEG_INFINITY, 1.0);
    for (entry, value) in block.derivatives_mut(pattern, 0).iter_mut().zip(values) {
        *entry = 2.0 * value * scale;
    }
}
