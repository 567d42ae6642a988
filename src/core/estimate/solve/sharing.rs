//! The motion of bodies by themselves with parameters that are given from outside.

use nalgebra::DVector;

use super::{Posed, Solved};
use crate::estimate::outcome;
use crate::estimate::problem::Bounded;
use crate::estimate::schedule::recipe::Solution;
use crate::estimate::sharing::{Holdable, SharedMotion, leave, put, rms};
use crate::estimate::terms::context::{Guidance, SolveContext};
use crate::motion::{FreeParameter, Observer};
use crate::optimise::Program;
use crate::optimise::reduced::Reduced;

/// A motion with its problem.
#[derive(Clone, Debug)]
pub struct HeldBodies {
    posed: Posed,
    epochs_s: Vec<f64>,
    solution: Solution,
}

impl Solved {
    /// The motion with parameters of the scene, by their indices, to be given from outside; `None` where there is no exact
    /// motion.
    pub fn sharing(&self, parameters: &[usize]) -> Option<SharedMotion<HeldBodies>> {
        let mut problem = self.posed.problem.clone();
        if !self.solution.finished.converged || problem.velocity_gap_weight.is_some() {
            return None;
        }
        leave(&mut problem.parameters, &mut problem.cones, parameters);
        for parameter in parameters.iter().copied() {
            if !problem.bounded.contains(&Bounded { parameter }) {
                problem.bounded.push(Bounded { parameter });
            }
        }
        let found = HeldBodies {
            posed: Posed::new(problem),
            epochs_s: self.epochs_s.clone(),
            solution: self.solution.clone(),
        };
        Some(SharedMotion::new(found, parameters))
    }
}

impl HeldBodies {
    fn context(&self) -> SolveContext<'_> {
        let point = &self.solution.point;
        self.posed.context(self.epochs_s.clone(), point)
    }

    /// The rows that hold parameters.
    fn rows(&self, held: &[usize]) -> Vec<usize> {
        let Posed { problem, layout } = &self.posed;
        let mut first = 0;
        let mut rows = vec![0; held.len()];
        for (constraint, pattern) in problem.constraints().zip(&layout.structure.blocks) {
            let mut held = held.iter();
            if let Some(of) = held.position(|of| constraint.bounds_parameter() == Some(*of)) {
                rows[of] = first;
            }
            first += pattern.row_count();
        }
        rows
    }
}

impl Holdable for HeldBodies {
    fn parameters(&self) -> &[FreeParameter] {
        &self.posed.problem.parameters
    }

    fn parameters_mut(&mut self) -> &mut [FreeParameter] {
        &mut self.posed.problem.parameters
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
            let context = self.context();
            context.retract(&self.solution.point, step, &mut start);
        }
        put(&mut start.parameters, self.parameters(), held);
        let solution = self.posed.solved_near(&start, &self.epochs_s, observer)?;
        Some(Self { solution, ..self })
    }

    fn reduced(&mut self, held: &[usize]) -> Option<Reduced> {
        let rows = self.rows(held);
        let mut solution = self.solution.clone();
        let reduced = Reduced::of(&self.context(), &Guidance::none(), &mut solution, &rows)?;
        self.solution = solution;
        Some(reduced)
    }

    fn cost(&self) -> f64 {
        self.solution.system.cost
    }

    fn residual(&self) -> ([f64; 2], [usize; 2]) {
        let (problem, point) = (&self.posed.problem, &self.solution.point);
        let errors = outcome::errors(problem, &self.context(), point);
        let (mut squares, mut samples) = ([0.0; 2], [0; 2]);
        for (of, (_, view)) in errors.iter().zip(problem.views()) {
            for kind in (0..2).filter(|kind| of.kinds[*kind]) {
                samples[kind] += of.each.len();
                let axes = of.each.iter().flat_map(|six| &six[3 * kind..3 * kind + 3]);
                squares[kind] += axes.map(|x| (x * view.units[kind]).powi(2)).sum::<f64>();
            }
        }
        (rms(squares, samples), samples)
    }
}
