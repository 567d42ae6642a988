//! The finish: Newton steps on the optimality conditions until constraints hold to rounding.
//!
//! `[H Jᵀ; J 0][d; ν] = [−g; −c]` is solved by the method of multipliers on the quadratic
//! model: one factorisation of `H + w JᵀJ`, which keeps the envelope and is positive definite
//! where the solution is unique, then a few back-substitutions, each of which shrinks the
//! error by the ratio of `H` to `w JᵀJ`. Steps are judged by the ℓ₁ merit.

use nalgebra::DVector;

use super::merit::{self, Price};
use super::point::Point;
use super::system::{Frame, Guidance, System};
use crate::math::envelope::Envelope;
use crate::motion::Counters;

/// Weight of the rows in the factorised matrix, per squared unit.
const WEIGHT: f64 = 1e5;
/// Damping of the factorised matrix, so small that it only keeps undetermined unknowns still.
const DAMPING: f64 = 1e-9;
/// Back-substitutions at most.
const REFINEMENTS: usize = 8;

/// When the finish is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Largest violation of a constraint, in units.
    pub violation: f64,
    /// Decrease promised by the next step, relative to the objective.
    pub decrease: f64,
    /// Steps at most.
    pub steps: usize,
}

impl Default for Tolerances {
    fn default() -> Self {
        Self {
            violation: 1e-9,
            decrease: 1e-10,
            steps: 60,
        }
    }
}

/// How the finish ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finished {
    /// Within tolerances.
    pub converged: bool,
    /// Largest violation left, in units.
    pub violation: f64,
    /// Decrease the last step promised, relative to the objective.
    pub decrease: f64,
}

/// A solution of the linearised optimality conditions.
pub struct KktStep {
    /// The step.
    pub delta: DVector<f64>,
    /// The multipliers after it, block by block.
    pub multipliers: Vec<Vec<f64>>,
}

/// The factorised `H + w JᵀJ` of a system, for steps and for covariances.
pub struct Kkt {
    matrix: Envelope,
    price: Price,
}

impl Kkt {
    /// Factorises; `None` where an unknown is undetermined beyond the damping.
    pub fn new(frame: &Frame, system: &System, multipliers: &[Vec<f64>]) -> Option<Self> {
        let price = Price {
            weight: WEIGHT,
            approach_weight: WEIGHT,
            multipliers: multipliers.to_vec(),
        };
        let pattern = &frame.layout.pattern;
        let mut matrix = system.hessian.clone();
        price.add_to(
            frame,
            system,
            &mut matrix,
            &mut DVector::zeros(pattern.size()),
        );
        for row in 0..pattern.size() {
            let diagonal = matrix.get(pattern, row, row);
            matrix.add(pattern, row, row, DAMPING * (1.0 + diagonal));
        }
        matrix.factorise(pattern).ok()?;
        Some(Self { matrix, price })
    }

    /// Solves for a step from `gradient` and violations `c` of the rows that act.
    pub fn step(&self, frame: &Frame, system: &System, gradient: &DVector<f64>) -> KktStep {
        let layout = frame.layout;
        let size = layout.size();
        let mut multipliers = self.price.multipliers.clone();
        let acting = self.price.acting(system);
        let mut delta = DVector::zeros(size);
        for _ in 0..REFINEMENTS {
            // Residual of the stationarity of the model's augmented Lagrangian at delta.
            let mut residual = gradient.clone();
            system
                .hessian
                .multiply_add(&layout.pattern, &delta, &mut residual);
            let mut errors = merit::along(layout, system, &delta);
            let mut largest: f64 = 0.0;
            for (index, errors) in errors.iter_mut().enumerate() {
                for (row, error) in errors.iter_mut().enumerate() {
                    *error = acting[index][row].map_or(0.0, |violation| violation + *error);
                    largest = largest.max(error.abs());
                    *error += multipliers[index][row] / WEIGHT;
                }
            }
            self.price.add_pull(layout, system, &errors, &mut residual);
            residual.neg_mut();
            self.matrix.solve(&layout.pattern, &mut residual);
            delta += &residual;
            let errors = merit::along(layout, system, &delta);
            for (index, errors) in errors.iter().enumerate() {
                for (row, error) in errors.iter().enumerate() {
                    if let Some(violation) = acting[index][row] {
                        multipliers[index][row] += WEIGHT * (violation + error);
                    }
                }
            }
            if residual.amax() <= 1e-14 * delta.amax() {
                break;
            }
        }
        KktStep { delta, multipliers }
    }

    /// Solves `(H + w JᵀJ) x = b` in place.
    pub fn solve(&self, frame: &Frame, b: &mut DVector<f64>) {
        self.matrix.solve(&frame.layout.pattern, b);
    }
}

/// Runs the finish from `point` and `multipliers`; both are replaced by where it ends.
pub fn finish(
    frame: &Frame,
    point: &mut Point,
    system: &mut System,
    multipliers: &mut Vec<Vec<f64>>,
    tolerances: &Tolerances,
    counters: &mut Counters,
    should_stop: &mut dyn FnMut() -> bool,
) -> Finished {
    let guidance = Guidance::none(frame.problem);
    let mut trial = point.clone();
    let mut trial_system = system.clone();
    let mut finished = Finished {
        converged: false,
        violation: system.violation(),
        decrease: f64::INFINITY,
    };
    for _ in 0..tolerances.steps {
        if should_stop() {
            break;
        }
        counters.iterations += 1;
        counters.factorisations += 1;
        let Some(kkt) = Kkt::new(frame, system, multipliers) else {
            break;
        };
        let step = kkt.step(frame, system, &system.gradient);
        finished.violation = system.violation();
        finished.decrease = system.gradient.dot(&step.delta).abs() / system.cost.max(1e-30);
        let small = finished.decrease < tolerances.decrease
            || system.gradient.dot(&step.delta).abs() < 1e-22;
        if finished.violation < tolerances.violation && small {
            finished.converged = true;
            // The last step costs one evaluation and squares what error is left.
            trial.retract_from(point, frame.problem, frame.layout, &step.delta);
            trial_system.evaluate(frame, &guidance, &trial);
            counters.evaluations += 1;
            if trial_system.violation() <= finished.violation {
                std::mem::swap(point, &mut trial);
                std::mem::swap(system, &mut trial_system);
                *multipliers = step.multipliers;
                finished.violation = system.violation();
            }
            break;
        }
        let price = 1.5 * largest(&step.multipliers).max(largest(multipliers)) + 1e-12;
        let merit = |system: &System| system.cost + price * total_violation(system);
        let before = merit(system);
        let mut accepted = false;
        let mut delta = step.delta.clone();
        for halving in 0..12 {
            trial.retract_from(point, frame.problem, frame.layout, &delta);
            trial_system.evaluate(frame, &guidance, &trial);
            counters.evaluations += 1;
            if merit(&trial_system) <= before * (1.0 + 1e-14) {
                accepted = true;
                break;
            }
            if halving == 0 {
                let corrected = correct(frame, &kkt, system, &trial_system, &delta);
                trial.retract_from(point, frame.problem, frame.layout, &corrected);
                trial_system.evaluate(frame, &guidance, &trial);
                counters.evaluations += 1;
                if merit(&trial_system) <= before * (1.0 + 1e-14) {
                    accepted = true;
                    break;
                }
            }
            delta *= 0.5;
        }
        if !accepted {
            break;
        }
        std::mem::swap(point, &mut trial);
        std::mem::swap(system, &mut trial_system);
        *multipliers = step.multipliers;
    }
    finished
}

/// The step that also removes what the constraints depart from their linearisation.
fn correct(
    frame: &Frame,
    kkt: &Kkt,
    system: &System,
    trial: &System,
    delta: &DVector<f64>,
) -> DVector<f64> {
    let mut errors = merit::along(frame.layout, system, delta);
    for ((errors, block), trial) in errors.iter_mut().zip(&system.blocks).zip(&trial.blocks) {
        for (row, error) in errors.iter_mut().enumerate() {
            *error = trial.values[row] - block.values[row] - *error;
        }
    }
    let mut correction = DVector::zeros(delta.len());
    kkt.price
        .add_pull(frame.layout, system, &errors, &mut correction);
    correction.neg_mut();
    kkt.matrix.solve(&frame.layout.pattern, &mut correction);
    delta + correction
}

fn largest(multipliers: &[Vec<f64>]) -> f64 {
    multipliers
        .iter()
        .flatten()
        .fold(0.0, |most, value| value.abs().max(most))
}

fn total_violation(system: &System) -> f64 {
    let blocks = system.blocks.iter();
    blocks
        .flat_map(|block| (0..block.values.len()).map(|row| block.violation(row).abs()))
        .sum()
}
