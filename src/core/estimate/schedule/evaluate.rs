//! The estimation as a [`Program`]: objective and constraints at a point, and the motion of points.

use nalgebra::DVector;

use crate::estimate::constraint::{At, Constraint};
use crate::estimate::curvature;
use crate::estimate::terms::context::{Guidance, SolveContext};
use crate::estimate::terms::objective::Objective;
use crate::estimate::unknowns::point::Point;
use crate::optimise::envelope::Envelope;
use crate::optimise::{IterationWork, Program, Structure, System};
use crate::physics::state;

/// Typical step lengths `s` of the damping `10/s²` ([`Program::damping`]).
mod length {
    pub const TIME_S: f64 = 0.02;

    /// Of the directions of a free body's state, three by three: position \[m\], orientation \[rad\],
    /// velocity [m/s], angular velocity [rad/s].
    const FREE: [f64; 4] = [0.05, 1.0, 0.5, 5.0];

    /// Of every direction in which the state of a free body may change.
    pub fn of_free() -> impl Iterator<Item = f64> {
        FREE.into_iter().flat_map(|length| [length; 3])
    }
}

impl Program for SolveContext<'_> {
    type Point = Point;
    type Guidance = Guidance;

    fn structure(&self) -> &Structure {
        &self.layout.structure
    }

    fn evaluate(&self, guidance: &Guidance, point: &Point, system: &mut System) {
        self.evaluate_with(guidance, point, system, |objective| objective.add_samples());
    }

    fn try_out(&self, guidance: &Guidance, point: &Point, system: &mut System) {
        match &self.problem.weave {
            Some(weave) => self.evaluate_with(guidance, point, system, |objective| {
                objective.add_woven_cost(weave);
            }),
            None => self.evaluate(guidance, point, system),
        }
    }

    fn differentiate(&self, guidance: &Guidance, point: &Point, system: &mut System) {
        if self.problem.weave.is_some() {
            self.evaluate(guidance, point, system);
        }
    }

    fn retract(&self, from: &Point, step: &DVector<f64>, to: &mut Point) {
        to.retract_from(from, self.problem, self.layout, step);
    }

    fn iteration_work(&self, point: &Point) -> IterationWork {
        self.looks(point)
    }

    /// Parameters by the width of their bounds or their prior.
    fn damping(&self) -> DVector<f64> {
        let (problem, layout) = (self.problem, self.layout);
        let information = problem.least_information();
        let weight = |length: f64| 10.0 * information / (length * length);
        let mut scale = DVector::repeat(layout.size(), weight(length::TIME_S));
        for arc in 0..problem.arcs.len() {
            let lengths = length::of_free();
            for (at, length) in layout.state(arc).zip(lengths) {
                scale[at] = weight(length);
            }
        }
        for at in &layout.held {
            for (entry, length) in length::of_free().enumerate() {
                scale[at + entry] = weight(length);
            }
        }
        for (at, free) in layout.parameters.iter().zip(&problem.parameters) {
            scale[*at] = weight(free.length());
        }
        scale
    }

    fn is_open(&self) -> bool {
        // Slow errors are cheap: nothing but these holds samples in their times.
        let moves_errors = self.problem.weave.is_some() && self.problem.times_are_unknown();
        moves_errors || !self.problem.regulariser.is_empty()
    }

    fn is_curved(&self) -> bool {
        let mut conditions = self.problem.conditions.iter();
        conditions.any(|of| of.is_curved() && !of.is_soft()) || !self.problem.clearances.is_empty()
    }

    fn information(&self) -> (f64, f64) {
        (self.problem.least_information(), self.problem.information())
    }

    fn add_curvature(
        &self,
        (point, system): (&Point, &System),
        multipliers: &[f64],
        hessian: &mut Envelope,
    ) {
        curvature::add(self, system, point, multipliers, hessian);
    }
}

impl SolveContext<'_> {
    /// Cost and constraints without the samples.
    pub(in crate::estimate) fn without_samples(&self, point: &Point) -> System {
        let mut system = System::new(self.structure());
        self.evaluate_with(&Guidance::none(), point, &mut system, |_| {});
        system
    }

    /// The samples' own part of the Hessian.
    pub(in crate::estimate) fn of_samples(&self, point: &Point) -> Envelope {
        let mut system = System::new(self.structure());
        Objective::new(self, &Guidance::none(), point, &mut system).add_samples();
        system.hessian
    }

    /// Evaluates with the samples' terms as they are added.
    fn evaluate_with(
        &self,
        guidance: &Guidance,
        point: &Point,
        system: &mut System,
        add_samples: impl FnOnce(&mut Objective),
    ) {
        let mut objective = Objective::new(self, guidance, point, system);
        add_samples(&mut objective);
        objective.add_priors();
        objective.add_pulls();
        objective.add_held();
        self.fill_constraints(guidance, point, system);
        self.add_priced(guidance.goal_weight_max, system);
    }

    /// Typical step lengths of an arc's state.
    pub(in crate::estimate) fn lengths_of_state(&self) -> DVector<f64> {
        DVector::from_iterator(state::DIMENSION, length::of_free())
    }

    fn fill_constraints(&self, guidance: &Guidance, point: &Point, system: &mut System) {
        let structure = &self.layout.structure;
        let mut at = At::new(self.problem, point, &self.epochs_s);
        at.approach_limits_m_s = &guidance.approach_limits_m_s;
        let rows = structure.blocks.iter().zip(&mut system.blocks);
        let priced = structure.priced.iter().zip(&mut system.priced);
        for ((constraint, rows), priced) in self.problem.constraints().zip(rows).zip(priced) {
            constraint.fill(&mut at, [rows, priced]);
        }
    }

    /// Adds half the weighted squares of the priced rows' violations to the cost: of velocity gaps, and
    /// of goals that have a weight. Of the curvature of rows, what is convex is part of the Hessian.
    fn add_priced(&self, goal_weight_max: f64, system: &mut System) {
        let structure = &self.layout.structure;
        let blocks = system.priced.iter().zip(&structure.priced);
        for (constraint, (block, pattern)) in self.problem.constraints().zip(blocks) {
            let weight = constraint.price(self.problem, goal_weight_max);
            let rows = 0..block.values.len();
            if weight == 0.0 || rows.is_empty() {
                continue;
            }
            let square = |row: usize| block.violation(row).powi(2);
            system.cost += 0.5 * weight * rows.map(square).sum::<f64>();
            let pull = |row: usize| weight * block.violation(row);
            block.add_pull(pattern, pull, &mut system.gradient);
            let acts = |row: usize| f64::from(block.acts(row)) * weight;
            block.add_square(pattern, acts, &structure.pattern, &mut system.hessian);
            for of in block.convex(pattern, pull) {
                system
                    .hessian
                    .add(&structure.pattern, of.row, of.column, of.value);
            }
        }
    }
}
