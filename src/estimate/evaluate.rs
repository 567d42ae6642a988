//! The estimation as a [`Program`]: objective and constraints at a point, and the motion of points.

use nalgebra::DVector;

use super::constraint::At;
use super::context::{Guidance, SolveContext};
use super::curvature;
use super::objective::Objective;
use super::point::Point;
use crate::optimise::envelope::Envelope;
use crate::optimise::{Program, Structure, System};

/// Typical step lengths `s` of the damping `10/s²` ([`Program::damping`]).
mod length {
    pub const POSITION_M: f64 = 0.05;
    pub const ORIENTATION_RAD: f64 = 1.0;
    pub const VELOCITY_M_S: f64 = 0.5;
    pub const ANGULAR_VELOCITY_RAD_S: f64 = 5.0;
    pub const TIME_S: f64 = 0.02;
}

impl Program for SolveContext<'_> {
    type Point = Point;
    type Guidance = Guidance;

    fn structure(&self) -> &Structure {
        &self.layout.structure
    }

    fn evaluate(&self, guidance: &Guidance, point: &Point, system: &mut System) {
        let mut objective = Objective::new(self, (guidance, point), system);
        objective.add_samples();
        objective.add_priors();
        self.fill_constraints(guidance, point, system);
        if let Some(weight) = self.problem.velocity_gap_weight {
            self.add_priced(weight, system);
        }
    }

    fn retract(&self, from: &Point, step: &DVector<f64>, to: &mut Point) {
        to.retract_from(from, self.problem, self.layout, step);
    }

    /// Parameters by the width of their bounds or their prior.
    fn damping(&self) -> DVector<f64> {
        let (problem, layout) = (self.problem, self.layout);
        let information = problem.least_information();
        let weight = |length: f64| 10.0 * information / (length * length);
        let mut scale = DVector::repeat(layout.size(), weight(length::TIME_S));
        for at in &layout.arcs {
            for (block, length) in [
                length::POSITION_M,
                length::ORIENTATION_RAD,
                length::VELOCITY_M_S,
                length::ANGULAR_VELOCITY_RAD_S,
            ]
            .into_iter()
            .enumerate()
            {
                scale.rows_mut(at + 3 * block, 3).fill(weight(length));
            }
        }
        for (at, free) in layout.parameters.iter().zip(&problem.parameters) {
            scale[*at] = weight(free.length());
        }
        scale
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
    fn fill_constraints(&self, guidance: &Guidance, point: &Point, system: &mut System) {
        let structure = &self.layout.structure;
        let mut at = At {
            approach_limits_m_s: &guidance.approach_limits_m_s,
            ..At::new(self.problem, point, &self.epochs_s)
        };
        let rows = structure.blocks.iter().zip(&mut system.blocks);
        let priced = structure.priced.iter().zip(&mut system.priced);
        for ((constraint, rows), priced) in self.problem.constraints().zip(rows).zip(priced) {
            constraint.fill(&mut at, [rows, priced]);
        }
    }

    /// Adds half the weighted squares of the velocity gaps to the cost.
    fn add_priced(&self, weight: f64, system: &mut System) {
        let structure = &self.layout.structure;
        for (block, pattern) in system.priced.iter().zip(&structure.priced) {
            let values = &block.values;
            system.cost += 0.5 * weight * values.iter().map(|v| v * v).sum::<f64>();
            block.add_pull(pattern, |row| weight * values[row], &mut system.gradient);
            let to = (&structure.pattern, &mut system.hessian);
            block.add_square(pattern, |_| weight, to);
        }
    }
}
