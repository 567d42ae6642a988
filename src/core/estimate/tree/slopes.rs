//! How a motion changes with what is freed of its scene: by differences of whole evaluations, central ones but beside the end
//! of what a quantity can be, as where a drag is nearly none.
//!
//! The flow takes as many steps on both sides, so that it is one smooth function of these quantities. A formula for each would be the
//! derivative of the articulated-body algorithm by each of its constants.

use super::evaluation::{Evaluation, MotionValues, Slope};
use super::part::Part;
use super::point::TreePoint;
use super::program::TreeProgram;
use crate::optimise::System;

/// Step of the differences, in typical changes of a quantity.
const STEP: f64 = 1e-3;
/// Differences of order four: steps, and the share of each value. Central ones,
const CENTRAL: &[(f64, f64)] = &[
    (-2.0, 1.0 / 12.0),
    (-1.0, -2.0 / 3.0),
    (1.0, 2.0 / 3.0),
    (2.0, -1.0 / 12.0),
];
/// and forward ones.
const FORWARD: &[(f64, f64)] = &[
    (0.0, -25.0 / 12.0),
    (1.0, 4.0),
    (2.0, -3.0),
    (3.0, 4.0 / 3.0),
    (4.0, -1.0 / 4.0),
];

impl TreeProgram<'_> {
    /// How the motion changes with all that is freed; `None` where it is none near by.
    pub(super) fn slopes(&self, part: &Part, point: &TreePoint) -> Option<Vec<Slope>> {
        if self.problem.freed.is_none() {
            return Some(Vec::new());
        }
        let each = self.problem.moving().map(|parameter| {
            let quantity = self.problem.parameters[parameter].quantity;
            let by = STEP * quantity.typical();
            let [least, _] = quantity.limits();
            let stencil = match point.parameters[parameter] + CENTRAL[0].0 * by < least {
                true => FORWARD,
                false => CENTRAL,
            };
            let mut of: Option<MotionValues> = None;
            for (steps, share) in stencil {
                let mut there = point.clone();
                there.parameters[parameter] += steps * by;
                let values = self.values(part, &there)?;
                let slope = of.get_or_insert_with(|| {
                    let mut none = values.clone();
                    none.add(&values, -1.0);
                    none
                });
                slope.add(&values, share / by);
            }
            Some(Slope { parameter, of: of? })
        });
        each.collect()
    }

    fn values(&self, part: &Part, point: &TreePoint) -> Option<MotionValues> {
        let there = self.problem.at(point)?;
        let of = Evaluation {
            problem: &there,
            part,
            point,
            has_derivatives: false,
        };
        let mut system = System::new(&self.structure);
        let mut values = MotionValues::default();
        for node in 0..there.nodes_s.len() {
            let sums = self.interval(&of, node, &mut system.blocks, &mut values);
            if !sums.cost.is_finite() {
                return None;
            }
        }
        let blocks = system.blocks.into_iter();
        values.blocks = blocks.map(|block| block.values).collect();
        Some(values)
    }
}
