//! The interface of all kinds of constraints.

use std::ops::Range;

use crate::estimate::covariance::timing;
use crate::estimate::problem::Problem;
use crate::estimate::unknowns::layout::Layout;
use crate::estimate::unknowns::point::Point;
use crate::motion::Gap;
use crate::optimise::block::{Block, BlockPattern};
use crate::physics::impact::ImpactDerivative;

/// The point at which constraints are evaluated, with its problem.
pub struct At<'a> {
    /// The problem.
    pub problem: &'a Problem,
    /// Values of the unknowns.
    pub point: &'a Point,
    /// Epochs of the arcs \[s\].
    pub epochs_s: &'a [f64],
    /// Upper bound of the normal speed before each event [m/s]; empty: zero, contacts do not
    /// recede.
    pub approach_limits_m_s: &'a [f64],
    /// Memory for the derivatives of one impact.
    pub impact: ImpactDerivative,
}

impl<'a> At<'a> {
    /// A point without guidance.
    #[inline]
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

impl At<'_> {
    /// Physical time of an event \[s\]; a start that is given is the zero of time.
    pub(super) fn event_time_s(&self, event: usize) -> f64 {
        let problem = self.problem;
        let is_given = problem.times_are_unknown() && !problem.event_is_free[event];
        if is_given && timing::is_zero(problem, event) {
            self.point.node_times_s.first().copied().unwrap_or(0.0)
        } else {
            self.point.event_times_s[event]
        }
    }
}

/// Rows to fill, with the unknowns that they depend on.
pub type Filled<'a> = (&'a BlockPattern, &'a mut Block);

/// A kind of constraint, with two blocks: hard rows, and rows whose squares are priced instead.
pub trait Constraint {
    /// The unknowns that the rows of both blocks depend on.
    fn patterns(&self, problem: &Problem, layout: &Layout) -> [BlockPattern; 2];

    /// Sets all values, bounds and derivatives of both blocks. Undefined values are NaN.
    fn fill(&self, at: &mut At, rows: [Filled; 2]);

    /// Event at which it holds; `None` for constraints on parameters.
    fn event(&self) -> Option<usize> {
        None
    }

    /// The gap that the rows of both blocks leave, in SI units.
    fn gap(&self, _problem: &Problem, _rows: [&Block; 2]) -> Gap {
        Gap::default()
    }

    /// Weight of the squared violations of its priced rows, per squared unit, at most `most` where it is
    /// not the price of velocity gaps.
    fn price(&self, problem: &Problem, _most: f64) -> f64 {
        problem.velocity_gap_weight.unwrap_or(0.0)
    }

    /// Whether its priced rows are a goal that has a weight.
    fn is_soft_goal(&self) -> bool {
        false
    }

    /// Hard rows that depend on poses only, not on velocities.
    fn places(&self, rows: &Block) -> Vec<Range<usize>> {
        std::iter::once(0..rows.values.len()).collect()
    }

    /// Whether its rows have a curvature that is not given by [`Block::curvature`].
    fn is_curved(&self) -> bool {
        false
    }

    /// Violation of a bound of a time \[s\].
    fn time_gap_s(&self, _rows: &Block) -> f64 {
        0.0
    }

    /// The parameter that its only row bounds, by itself.
    fn bounds_parameter(&self) -> Option<usize> {
        None
    }

    /// For bounds of parameters and times: half the width of the allowed range, in units.
    fn half_width(&self, _rows: &Block) -> Option<f64> {
        None
    }
}

impl Problem {
    /// All constraints, in the order of their blocks.
    pub fn constraints(&self) -> impl Iterator<Item = &dyn Constraint> {
        let collisions = self.collisions.iter().map(|of| of as &dyn Constraint);
        let goals = self.goals.iter().map(|of| of as &dyn Constraint);
        let conditions = self.conditions.iter().map(|of| of as &dyn Constraint);
        let bounded = self.bounded.iter().map(|of| of as &dyn Constraint);
        let ordered = self.ordered.iter().map(|of| of as &dyn Constraint);
        let cones = self.cones.iter().map(|of| of as &dyn Constraint);
        let samples = self.sample_orders.iter().map(|of| of as &dyn Constraint);
        let times = self.time_bounds.iter().map(|of| of as &dyn Constraint);
        let clearances = self.clearances.iter().map(|of| of as &dyn Constraint);
        let changes = self.changes.iter().map(|of| of as &dyn Constraint);
        let stickings = self.stickings.iter().map(|of| of as &dyn Constraint);
        let supports = self.supports.iter().map(|of| of as &dyn Constraint);
        collisions
            .chain(changes)
            .chain(stickings)
            .chain(supports)
            .chain(goals)
            .chain(conditions)
            .chain(times)
            .chain(bounded)
            .chain(cones)
            .chain(ordered)
            .chain(samples)
            .chain(clearances)
    }
}
