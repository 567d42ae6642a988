//! What every kind of constraint answers.

use std::ops::Range;

use crate::estimate::layout::Layout;
use crate::estimate::point::Point;
use crate::estimate::problem::Problem;
use crate::motion::Gap;
use crate::optimise::block::{Block, BlockPattern};
use crate::physics::impact::ImpactDerivative;

/// Where constraints are asked for.
pub struct At<'a> {
    /// What they are of.
    pub problem: &'a Problem,
    /// The unknowns.
    pub point: &'a Point,
    /// Epochs of the arcs \[s\].
    pub epochs_s: &'a [f64],
    /// Greatest normal speed on arrival at each event [m/s]; empty: contacts must not recede.
    pub approach_limits_m_s: &'a [f64],
    /// Room for the derivatives of one impact.
    pub impact: ImpactDerivative,
}

impl<'a> At<'a> {
    /// At a point, with nothing that leads the way.
    pub fn new(problem: &'a Problem, point: &'a Point, epochs_s: &'a [f64]) -> Self {
        Self {
            problem,
            point,
            epochs_s,
            approach_limits_m_s: &[],
            impact: ImpactDerivative::zeros(),
        }
    }
}

/// Rows to fill, with what they touch.
pub type Filled<'a> = (&'a BlockPattern, &'a mut Block);

/// A condition: rows that hold, and rows that are priced instead where the problem says so.
pub trait Constraint {
    /// What both touch.
    fn patterns(&self, problem: &Problem, layout: &Layout) -> [BlockPattern; 2];

    /// Sets all of both: values, bounds and derivatives. Where there are none they are NaN.
    fn fill(&self, at: &mut At, rows: [Filled; 2]);

    /// Event at which it holds; `None` of one that holds for parameters.
    fn event(&self) -> Option<usize> {
        None
    }

    /// What both leave, in SI units.
    fn gap(&self, _problem: &Problem, _rows: [&Block; 2]) -> Gap {
        Gap::default()
    }

    /// Rows that say where bodies are at its event, and not how they move.
    fn places(&self, rows: &Block) -> Vec<Range<usize>> {
        std::iter::once(0..rows.values.len()).collect()
    }

    /// Whether its rows are curved and do not say how ([`Block::curvature`]).
    fn is_curved(&self) -> bool {
        false
    }

    /// Of one that only keeps a parameter in its place: half the width of what it leaves, in units.
    fn half_width(&self, _rows: &Block) -> Option<f64> {
        None
    }
}

impl Problem {
    /// Everything that must hold, in the order of its blocks.
    pub fn constraints(&self) -> impl Iterator<Item = &dyn Constraint> {
        let collisions = self.collisions.iter().map(|of| of as &dyn Constraint);
        let goals = self.goals.iter().map(|of| of as &dyn Constraint);
        let bounded = self.bounded.iter().map(|of| of as &dyn Constraint);
        let cones = self.cones.iter().map(|of| of as &dyn Constraint);
        collisions.chain(goals).chain(bounded).chain(cones)
    }
}
