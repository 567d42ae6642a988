//! Newton steps on the optimality conditions, as the program's finish, over any grid's unknowns.

use enact::estimate::active::ActiveSet;
use enact::estimate::finish::{Finished, Tolerances};
use enact::estimate::kkt::KktStep;
use enact::estimate::merit;
use enact::estimate::system::{Guidance, SolveContext, System};
use enact::math::envelope::Envelope;
use nalgebra::DVector;

use super::model::Model;
use super::setting::Place;

/// Constants of the program's finish.
const DAMPING: f64 = 1e-9;
const EXACT: f64 = 1e-5;
const ROUNDING: f64 = 1e-14;
const ACTIVE_ROUNDS: usize = 12;
const REFINEMENTS: usize = 8;
const HALVINGS_MAX: usize = 12;
const NO_COST: f64 = 1e-6;

/// A place on its way through the finish.
pub struct Finish<'m, 'a> {
    /// What is evaluated.
    pub model: &'m mut Model<'a>,
    /// Where it stands.
    pub place: Place,
    /// Objective and constraints there.
    pub system: System,
    /// Multipliers, row by row.
    pub multipliers: Vec<f64>,
    /// Factorisations so far.
    pub iterations: usize,
}

/// The factorised matrix of a step.
struct Factor {
    matrix: Envelope,
    weights: Vec<f64>,
}

impl Finish<'_, '_> {
    /// Steps until within tolerances or no step helps.
    pub fn run(&mut self, tolerances: &Tolerances) -> Finished {
        let guidance = Guidance::none(self.model.outer.problem);
        let mut trial = (self.place.clone(), self.system.clone());
        let mut finished = Finished {
            converged: false,
            violation: self.system.violation(),
            decrease: f64::INFINITY,
        };
        let mut promised_before: Option<f64> = None;
        for _ in 0..tolerances.steps {
            let Some((factor, step)) = self.step() else {
                break;
            };
            let decrease = self.system.gradient.dot(&step.delta).abs();
            let promised = decrease / self.system.cost.max(NO_COST);
            let share = self.search(&guidance, &factor, &step, &mut trial);
            let is_whole = share == Some(1.0);
            finished.decrease = match promised_before.filter(|_| is_whole) {
                Some(before) => promised * (promised / before).min(1.0),
                None => promised,
            };
            if share.is_some() {
                std::mem::swap(&mut self.place, &mut trial.0);
                std::mem::swap(&mut self.system, &mut trial.1);
                self.multipliers = step.multipliers;
            }
            finished.violation = self.system.violation();
            finished.converged = finished.violation < tolerances.violation
                && finished.decrease < tolerances.decrease;
            if finished.converged || share.is_none() {
                break;
            }
            promised_before = is_whole.then_some(promised);
        }
        finished
    }

    fn step(&mut self) -> Option<(Factor, KktStep)> {
        let context = &self.model.outer;
        let mut active = ActiveSet::of(context, &self.system, &self.multipliers);
        let mut last = None;
        for _ in 0..ACTIVE_ROUNDS {
            self.iterations += 1;
            let (factor, step) = solved(context, &self.system, &self.multipliers, &active)?;
            let changed = active.revise(context, &self.system, (&step.delta, &step.multipliers));
            last = Some((factor, step));
            if !changed {
                break;
            }
        }
        last
    }

    fn evaluate(&mut self, guidance: &Guidance, delta: &DVector<f64>, trial: &mut (Place, System)) {
        trial.0 = self.model.moved(&self.place, delta);
        self.model.evaluate(guidance, &trial.0, &mut trial.1);
    }

    /// Finds along `step` what lowers the ℓ₁ merit, and says what share of the step it is.
    fn search(
        &mut self,
        guidance: &Guidance,
        factor: &Factor,
        step: &KktStep,
        trial: &mut (Place, System),
    ) -> Option<f64> {
        let largest =
            |multipliers: &[f64]| multipliers.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let lagrangian = 1.5 * largest(&step.multipliers).max(largest(&self.multipliers)) + 1e-12;
        let merit = |system: &System| match system.cost {
            cost if cost.is_finite() => cost + lagrangian * system.total_violation(),
            _ => f64::INFINITY,
        };
        let enough = merit(&self.system) * (1.0 + 1e-14);
        let mut delta = step.delta.clone();
        let mut share = 1.0;
        for halving in 0..HALVINGS_MAX {
            self.evaluate(guidance, &delta, trial);
            if merit(&trial.1) <= enough {
                return Some(share);
            }
            if halving == 0 && trial.1.cost.is_finite() {
                let layout = self.model.outer.layout;
                let systems = (&self.system, &trial.1);
                let weights = &factor.weights;
                let correction =
                    merit::correction(layout, systems, &delta, weights, &factor.matrix);
                self.evaluate(guidance, &(&delta + correction), trial);
                if merit(&trial.1) <= enough {
                    return Some(share);
                }
            }
            delta *= 0.5;
            share *= 0.5;
        }
        None
    }
}

/// The step to the optimum of the quadratic model with those rows active, by the method of
/// multipliers on one factorisation; `None` where an unknown is undetermined.
fn solved(
    context: &SolveContext,
    system: &System,
    multipliers: &[f64],
    active: &ActiveSet,
) -> Option<(Factor, KktStep)> {
    let layout = context.layout;
    let pattern = &layout.pattern;
    let (weights, violations) = active.weights_and_violations(context, system);
    let acts = |row: usize| weights[row] > 0.0;
    let mut matrix = system.hessian.clone();
    let pull = |row: usize| if acts(row) { multipliers[row] } else { 0.0 };
    let curvature = merit::curvature(layout, system, pull);
    for (at, value) in &curvature {
        matrix.add(pattern, *at, *at, *value);
    }
    for row in 0..pattern.size() {
        let diagonal = matrix.get(pattern, row, row);
        matrix.add(pattern, row, row, DAMPING * (1.0 + diagonal));
    }
    merit::add_square(layout, system, &weights, &mut matrix);
    matrix.factorise(pattern).ok()?;
    let mut multipliers = multipliers.to_vec();
    let mut delta = DVector::zeros(layout.size());
    let mut rows = vec![0.0; multipliers.len()];
    let largest = violations
        .iter()
        .fold(0.0, |most: f64, v| most.max(v.abs()));
    for _ in 0..REFINEMENTS {
        let mut residual = system.gradient.clone();
        system.hessian.multiply_add(pattern, &delta, &mut residual);
        for (at, value) in &curvature {
            residual[*at] += value * delta[*at];
        }
        let pull = |row: usize| match acts(row) {
            true => multipliers[row] + weights[row] * (violations[row] + rows[row]),
            false => 0.0,
        };
        merit::add_pull(layout, system, pull, &mut residual);
        residual.neg_mut();
        matrix.solve(pattern, &mut residual);
        delta += &residual;
        merit::along(layout, system, &delta, &mut rows);
        let mut worst: f64 = 0.0;
        for (row, multiplier) in multipliers.iter_mut().enumerate() {
            if acts(row) {
                let error = violations[row] + rows[row];
                *multiplier += weights[row] * error;
                worst = worst.max(error.abs());
            }
        }
        if worst <= (EXACT * largest).max(ROUNDING) {
            break;
        }
    }
    for (multiplier, weight) in multipliers.iter_mut().zip(&weights) {
        if *weight == 0.0 {
            *multiplier = 0.0;
        }
    }
    Some((Factor { matrix, weights }, KktStep { delta, multipliers }))
}
