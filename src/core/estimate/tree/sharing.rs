//! The motion of trees with parameters that are given from outside.

use nalgebra::DVector;

use super::optimum::{Solved, finished};
use super::part::Part;
use super::point::TreePoint;
use super::problem::TreeProblem;
use super::program::TreeProgram;
use super::sample::Residual;
use crate::estimate::sharing::{Holdable, SharedMotion, leave, put, rms};
use crate::motion::{FreeParameter, GoalUnit, Observer};
use crate::optimise::reduced::Reduced;
use crate::optimise::{Program, Schedule, Solution, System, Work};

/// A motion with its problem.
#[derive(Clone, Debug)]
pub struct HeldTrees {
    problem: TreeProblem,
    solution: Solution<TreePoint>,
}

impl Solved {
    /// The motion with parameters of the scene, by their indices, to be given from outside; `None` where there is none.
    pub fn sharing(&self, parameters: &[usize]) -> Option<SharedMotion<HeldTrees>> {
        if !self.solution.finished.converged {
            return None;
        }
        let mut problem = self.problem.clone();
        leave(&mut problem.parameters, &mut problem.cones, parameters);
        let solution = self.solution.clone();
        Some(SharedMotion::new(
            HeldTrees { problem, solution },
            parameters,
        ))
    }
}

impl HeldTrees {
    /// What nothing determines stays where the motion is.
    fn program(&self) -> TreeProgram<'_> {
        TreeProgram::new(&self.problem, self.solution.point.clone())
    }
}

impl Holdable for HeldTrees {
    fn parameters(&self) -> &[FreeParameter] {
        &self.problem.parameters
    }

    fn parameters_mut(&mut self) -> &mut [FreeParameter] {
        &mut self.problem.parameters
    }

    fn values(&self) -> &[f64] {
        &self.solution.point.parameters
    }

    fn solved(
        self,
        step: Option<&DVector<f64>>,
        held: &[usize],
        observer: &mut dyn Observer,
    ) -> Option<Self> {
        let mut start = self.solution.point.clone();
        if let Some(step) = step {
            self.solution.point.retract(&self.problem, step, &mut start);
        }
        put(&mut start.parameters, self.parameters(), held);
        let schedules = [
            Schedule::default().from_the_last(),
            Schedule::default().without_sweep(),
        ];
        let mut work = Work::default();
        let mut found = schedules
            .iter()
            .map(|schedule| finished(&self.problem, &start, schedule, &mut work, observer));
        let found = found.find(|found| found.solution.finished.converged)?;
        let Solved { problem, solution } = found;
        Some(Self { problem, solution })
    }

    fn reduced(&mut self, held: &[usize]) -> Option<Reduced> {
        let mut solution = self.solution.clone();
        let program = self.program();
        let blocks = &program.structure().blocks;
        let before = &blocks[..self.problem.bound_block()];
        let first: usize = before.iter().map(|block| block.row_count()).sum();
        let rows: Vec<usize> = held.iter().map(|parameter| first + parameter).collect();
        let reduced = Reduced::of(&program, &Part::whole(), &mut solution, &rows)?;
        self.solution = solution;
        Some(reduced)
    }

    fn cost(&self) -> f64 {
        self.solution.system.cost
    }

    fn residual(&self) -> ([f64; 2], [usize; 2]) {
        let (mut squares, mut samples) = ([0.0; 2], [0; 2]);
        let mut each = |_: usize, residual: &Residual| {
            let residual = residual.in_units();
            let kind = usize::from(residual.sample.quantity.unit() != GoalUnit::Metre);
            samples[kind] += 1;
            squares[kind] += (residual.value * residual.sample.unit).norm_squared();
        };
        let program = self.program();
        let mut system = System::new(program.structure());
        let (whole, point) = (Part::whole(), &self.solution.point);
        program.evaluate_each(&whole, point, false, &mut system, &mut each);
        (rms(squares, samples), samples)
    }
}
