//! What of the laws of impacts is unknown: restitution, friction and tilts, each between its bounds, tilts within a cone.

use super::event::TreeEvent;
use super::point::TreePoint;
use super::problem::TreeProblem;
use crate::motion::{AtBound, TreeTouch};
use crate::optimise::block::{Block, BlockPattern};

/// How near a bound a value is at it, in lengths of the parameter.
const NEAR: f64 = 1e-6;

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
        let first = self.event_block(self.events.len());
        let rooms = patterns[first..].iter().zip(&mut blocks[first..]);
        let (of_parameters, of_cones) = (self.parameters.iter(), self.cones.iter());
        let mut rooms = rooms.map(|(pattern, block)| {
            block.reset(pattern);
            (pattern, block)
        });
        for ((free, value), (pattern, block)) in
            of_parameters.zip(&point.parameters).zip(&mut rooms)
        {
            let unit = free.length();
            block.values[0] = value / unit;
            block.bounds[0] = (free.lower / unit, free.upper / unit);
            block.derivatives_mut(pattern, 0)[0] = 1.0 / unit;
        }
        for (cone, (pattern, block)) in of_cones.zip(rooms) {
            let values = cone.parameters.map(|of| point.parameters[of]);
            let scale = 1.0 / (cone.limit * cone.limit);
            block.values[0] = values.iter().map(|value| value * value).sum::<f64>() * scale;
            block.bounds[0] = (f64::NEG_INFINITY, 1.0);
            // Their curvature is told with that of all else (`curvature`).
            for (entry, value) in block.derivatives_mut(pattern, 0).iter_mut().zip(values) {
                *entry = 2.0 * value * scale;
            }
        }
    }

    /// The bound at which a parameter is, or that of its cone.
    pub(super) fn at_bound(&self, point: &TreePoint, parameter: usize) -> Option<AtBound> {
        let free = &self.parameters[parameter];
        let value = point.parameters[parameter];
        let is_at = |bound: f64| (value - bound).abs() <= NEAR * free.length();
        let mut cones = self.cones.iter();
        let is_at_cone = cones.any(|cone| {
            let [a, b] = cone.parameters.map(|of| point.parameters[of]);
            cone.parameters.contains(&parameter) && a.hypot(b) >= cone.limit * (1.0 - NEAR)
        });
        match () {
            () if is_at_cone => Some(AtBound::Cone),
            () if is_at(free.lower) => Some(AtBound::Lower),
            () if is_at(free.upper) => Some(AtBound::Upper),
            () => None,
        }
    }
}
