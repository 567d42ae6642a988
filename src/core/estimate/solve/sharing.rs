//! A motion that is asked what it says of quantities which several takes share: at values from outside, all else of the take
//! at its own optimum.

use nalgebra::{DMatrix, DVector};

use super::{Posed, Solved};
use crate::estimate::outcome;
use crate::estimate::problem::{Bounded, Problem};
use crate::estimate::schedule::recipe::Solution;
use crate::estimate::terms::context::{Guidance, SolveContext};
use crate::motion::{Cone, Fits, Observer, TakeShare};
use crate::optimise::Program;
use crate::optimise::reduced::Reduced;

/// A motion with parameters that are given from outside. Flights, contacts, and the errors of samples are those with
/// which it was found.
#[derive(Clone, Debug)]
pub struct SharedMotion {
    posed: Posed,
    epochs_s: Vec<f64>,
    solution: Solution,
    /// The given parameters (indices into [`Problem::parameters`]).
    parameters: Vec<usize>,
    /// How all unknowns follow each of them, once that was told.
    responses: Vec<DVector<f64>>,
    /// Whether the motion as it was found explains its samples.
    fits: Fits,
}

impl Solved {
    /// The motion with parameters of the scene, by their indices, to be given from outside; `None` where there is no exact
    /// motion. Priors and cones of these parameters are left to whoever gives their values.
    pub fn sharing(&self, parameters: &[usize]) -> Option<SharedMotion> {
        let mut problem = self.posed.problem.clone();
        if !self.solution.finished.converged || problem.velocity_gap_weight.is_some() {
            return None;
        }
        for parameter in parameters.iter().copied() {
            problem.parameters[parameter].prior_sd = None;
            if !problem.bounded.contains(&Bounded { parameter }) {
                problem.bounded.push(Bounded { parameter });
            }
            let is_of = |cone: &Cone| cone.parameters.contains(&parameter);
            problem.cones.retain(|cone| !is_of(cone));
        }
        Some(SharedMotion {
            posed: Posed::new(problem),
            epochs_s: self.epochs_s.clone(),
            solution: self.solution.clone(),
            parameters: parameters.to_vec(),
            responses: Vec::new(),
            fits: self.estimate.fits(),
        })
    }
}

impl SharedMotion {
    /// The values at which it is.
    pub fn values(&self) -> DVector<f64> {
        let values = &self.solution.point.parameters;
        let of = self.parameters.iter().map(|parameter| values[*parameter]);
        DVector::from_iterator(self.parameters.len(), of)
    }

    /// Whether the motion as it was found explains its samples, where that was asked.
    pub fn fits(&self) -> Fits {
        self.fits
    }

    /// What the take says at other values; `None` where it has no motion there. It stays where it was then.
    pub fn at(&mut self, values: &DVector<f64>, observer: &mut dyn Observer) -> Option<TakeShare> {
        let change = values - self.values();
        let before = self.posed.problem.parameters.clone();
        for (parameter, value) in self.parameters.iter().zip(values.iter()) {
            let free = &mut self.posed.problem.parameters[*parameter];
            (free.lower, free.upper) = (*value, *value);
        }
        let found = self.found(values, &change, observer);
        if found.is_none() {
            self.posed.problem.parameters = before;
        }
        let (solution, reduced) = found?;
        let share = self.share(&solution, &reduced, values);
        (self.solution, self.responses) = (solution, reduced.responses);
        Some(share)
    }

    /// The optimum with these values, from where it is, first along what all unknowns follow them by.
    fn found(
        &self,
        values: &DVector<f64>,
        change: &DVector<f64>,
        observer: &mut dyn Observer,
    ) -> Option<(Solution, Reduced)> {
        let mut start = self.solution.point.clone();
        let units = self.units();
        if !self.responses.is_empty() && change.amax() > 0.0 {
            let context = self.context(&self.solution);
            let along = self.responses.iter().zip(change.iter().zip(&units));
            let step = along.fold(
                DVector::zeros(self.posed.layout.size()),
                |sum, (response, by)| sum + response * (by.0 / by.1),
            );
            let from = start.clone();
            context.retract(&from, &step, &mut start);
        }
        for (parameter, value) in self.parameters.iter().zip(values.iter()) {
            start.parameters[*parameter] = *value;
        }
        let mut solution = self.posed.solved_near(&start, &self.epochs_s, observer)?;
        let context = self.context(&solution);
        let reduced = Reduced::of(&context, &Guidance::none(), &mut solution, &self.rows())?;
        Some((solution, reduced))
    }

    /// The share, from the derivatives by the rows that hold the parameters, whose units are other than the parameters'.
    fn share(&self, solution: &Solution, reduced: &Reduced, values: &DVector<f64>) -> TakeShare {
        let units = DVector::from_vec(self.units());
        let count = units.len();
        let curvature = &reduced.curvature;
        let (residual, samples) = residual(&self.posed.problem, &self.context(solution), solution);
        TakeShare {
            values: values.clone(),
            cost: solution.system.cost,
            gradient: reduced.gradient.component_div(&units),
            curvature: DMatrix::from_fn(count, count, |a, b| {
                curvature[(a, b)] / (units[a] * units[b])
            }),
            residual,
            samples,
        }
    }

    /// One unit of the row that holds each parameter.
    fn units(&self) -> Vec<f64> {
        let free = &self.posed.problem.parameters;
        let of = self.parameters.iter();
        of.map(|parameter| free[*parameter].length()).collect()
    }

    /// The rows that hold the parameters.
    fn rows(&self) -> Vec<usize> {
        let Posed { problem, layout } = &self.posed;
        let mut first = 0;
        let mut rows = vec![0; self.parameters.len()];
        for (constraint, pattern) in problem.constraints().zip(&layout.structure.blocks) {
            let mut held = self.parameters.iter();
            if let Some(of) = held.position(|of| constraint.bounds_parameter() == Some(*of)) {
                rows[of] = first;
            }
            first += pattern.row_count();
        }
        rows
    }

    fn context(&self, at: &Solution) -> SolveContext<'_> {
        self.posed.context(self.epochs_s.clone(), &at.point)
    }
}

/// Root mean square residuals per axis of positions \[m\] and orientations \[rad\], and how many samples show each.
fn residual(
    problem: &Problem,
    context: &SolveContext,
    solution: &Solution,
) -> ([f64; 2], [usize; 2]) {
    let errors = outcome::errors(problem, context, &solution.point);
    let (mut squares, mut samples) = ([0.0; 2], [0; 2]);
    for (of, (_, view)) in errors.iter().zip(problem.views()) {
        for kind in (0..2).filter(|kind| of.kinds[*kind]) {
            samples[kind] += of.each.len();
            let axes = of.each.iter().flat_map(|six| &six[3 * kind..3 * kind + 3]);
            squares[kind] += axes.map(|x| (x * view.units[kind]).powi(2)).sum::<f64>();
        }
    }
    let rms = [0, 1].map(|kind| (squares[kind] / (3 * samples[kind].max(1)) as f64).sqrt());
    (rms, samples)
}
