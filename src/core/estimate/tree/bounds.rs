//! What of the laws of impacts is unknown: restitutions, friction and tilts, each between its bounds, tilts within a cone.

use super::event::TreeEvent;
use super::point::TreePoint;
use super::problem::TreeProblem;
use crate::estimate::constraint::{bound, cone};
use crate::motion::TreeTouch;
use crate::optimise::block::{Block, BlockPattern};

impl TreeEvent {
    /// What touches at a point of the problem.
    pub(super) fn touch_at(&self, point: &TreePoint) -> Option<TreeTouch> {
        let mut touch = self.touch.clone()?;
        let value = |parameter: Option<usize>, given: &mut f64| {
            if let Some(parameter) = parameter {
                *given = point.parameters[parameter];
            }
        };
        value(self.free.restitution, &mut touch.law.restitution);
        value(self.free.friction, &mut touch.law.friction);
        value(
            self.free.tangential_restitution,
            &mut touch.law.tangential_restitution,
        );
        for tangent in 0..2 {
            value(self.free.tilt[tangent], &mut touch.law.tilt_rad[tangent]);
        }
        Some(touch)
    }
}

impl TreeProblem {
    /// Patterns of the rows that bound parameters, and of those of cones.
    pub(super) fn bound_patterns(&self) -> impl Iterator<Item = BlockPattern> + '_ {
        let bounds = (0..self.parameters.len()).map(|of| vec![self.unknown_of_parameter(of)]);
        let cones = self.cones.iter().map(|cone| {
            let both = cone.parameters.map(|of| self.unknown_of_parameter(of));
            both.to_vec()
        });
        bounds
            .chain(cones)
            .map(|columns| BlockPattern::dense(1, columns))
    }

    /// Fills the rows that bound parameters, `lower ≤ u ≤ upper`, and those of cones, `(p₀² + p₁²)/limit² ≤ 1`: the last
    /// blocks.
    pub(super) fn fill_bounds(
        &self,
        point: &TreePoint,
        patterns: &[BlockPattern],
        blocks: &mut [Block],
    ) {
        let first = self.bound_block();
        let mut rooms = patterns[first..].iter().zip(&mut blocks[first..]);
        let values = self.parameters.iter().zip(&point.parameters);
        for ((free, value), room) in values.zip(&mut rooms) {
            bound::fill(free, *value, room);
        }
        // Their curvature is told with that of all else (`curvature`).
        for (of, room) in self.cones.iter().zip(rooms) {
            cone::fill(of, &point.parameters, room);
        }
    }
}
