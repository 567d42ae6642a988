//! The finish: Newton steps on the optimality conditions until constraints hold to rounding.
//!
//! `[H Jᵀ; J 0][d; ν] = [−g; −c]` is solved by the method of multipliers on the quadratic
//! model: one factorisation of `H + w JᵀJ`, which keeps the envelope and is positive definite
//! where the solution is unique, then a few back-substitutions, each of which shrinks the
//! error by the ratio of `H` to `w JᵀJ`. Steps are judged by the ℓ₁ merit.

use nalgebra::DVector;

use super::acting::ActingSet;
use super::curvature;
use super::merit;
use super::point::Point;
use super::qp;
use super::system::{Frame, Guidance, System};
use crate::math::envelope::Envelope;
use crate::motion::Counters;

/// Damping of the factorised matrix, so small that it only keeps undetermined unknowns still.
pub(super) const DAMPING: f64 = 1e-9;
/// The linearised constraints hold well enough at this share of their violation (the next step
/// leaves more by curvature), or at rounding.
const EXACT: f64 = 1e-5;
const ROUNDING: f64 = 1e-14;
/// Rounds in which the set of acting bounds must settle.
const ACTING_ROUNDS: usize = 12;
/// Back-substitutions at most.
const REFINEMENTS: usize = 8;
/// After so many steps one that promises more than this share of what the one before did converges
/// slowly.
const SLOW: f64 = 0.5;
const SLOW_STEPS: usize = 5;
/// Halvings of a step at most.
const HALVINGS_MAX: usize = 12;
/// An objective below this is none: the decrease is then measured against it. What is promised
/// beyond is less than a nanometre, and of the size of rounding.
const NO_COST: f64 = 1e-6;

/// When the finish is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Largest violation of a constraint, in units.
    pub violation: f64,
    /// Decrease that the next step would promise, relative to the objective.
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
    /// Decrease that a further step would promise, relative to the objective, as far as the last
    /// ones tell.
    pub decrease: f64,
}

/// A solution of the linearised optimality conditions.
pub struct KktStep {
    /// The step.
    pub delta: DVector<f64>,
    /// The multipliers after it, row by row.
    pub multipliers: Vec<f64>,
}

/// The factorised `H + w JᵀJ` of a system, for steps and for covariances.
pub struct Kkt {
    matrix: Envelope,
    /// `H`.
    hessian: Envelope,
    /// Weight of every row, zero of those that do not act.
    weights: Vec<f64>,
    /// Signed distance of every row from the bound that acts.
    violations: Vec<f64>,
    multipliers: Vec<f64>,
    /// What keeps undetermined unknowns still: added to the diagonal.
    damping: Vec<f64>,
}

impl Kkt {
    /// Factorises with the rows acting that `multipliers` say; `None` where an unknown is
    /// undetermined beyond the damping.
    pub fn new(frame: &Frame, system: &System, multipliers: &[f64]) -> Option<Self> {
        let acting = ActingSet::of(frame, system, multipliers);
        Self::with(frame, system, multipliers, (&acting, None))
    }

    /// The same for covariances: what a parameter's bound keeps in place is not known for that. It
    /// weighs as half the width between the bounds for a standard deviation, or nothing where
    /// there is only one.
    pub fn with_soft_bounds(frame: &Frame, system: &System, multipliers: &[f64]) -> Option<Self> {
        let acting = ActingSet::of(frame, system, multipliers);
        let (mut weights, violations) = acting.weights_and_violations(frame, system);
        let mut multipliers = multipliers.to_vec();
        let problem = frame.problem;
        let bounds = problem.bounded.len() + problem.cones.len();
        let (hard, soft) = system.blocks.split_at(system.blocks.len() - bounds);
        let first: usize = hard.iter().map(|block| block.values.len()).sum();
        let rows = soft.iter().flat_map(|block| &block.bounds);
        for (row, (lower, upper)) in (first..).zip(rows) {
            if weights[row] > 0.0 {
                multipliers[row] = 0.0;
                // A cone's row goes as the square of the distance from its middle.
                let half_width = if lower.is_infinite() && row >= first + problem.bounded.len() {
                    2.0 * upper
                } else {
                    0.5 * (upper - lower)
                };
                weights[row] = half_width.powi(-2);
            }
        }
        // Samples hold every time that the tempo relates to others; a damping in proportion to how
        // stiffly neighbours are held together would hold all of them.
        let mut damping = vec![DAMPING; frame.layout.size()];
        for node in frame.layout.nodes.iter().flatten() {
            damping[*node] = 0.0;
        }
        let hessian = system.hessian.clone();
        let weighed = (weights, violations);
        Self::weighed(frame, (system, hessian), &multipliers, weighed, damping)
    }

    /// `curved` is the system's Hessian with the curvature of its constraints, where steps need it.
    fn with(
        frame: &Frame,
        system: &System,
        multipliers: &[f64],
        (acting, curved): (&ActingSet, Option<&Envelope>),
    ) -> Option<Self> {
        let weighed = acting.weights_and_violations(frame, system);
        let damping = vec![DAMPING; frame.layout.size()];
        let hessian = curved.unwrap_or(&system.hessian).clone();
        Self::weighed(frame, (system, hessian), multipliers, weighed, damping)
    }

    fn weighed(
        frame: &Frame,
        (system, mut hessian): (&System, Envelope),
        multipliers: &[f64],
        (weights, violations): (Vec<f64>, Vec<f64>),
        mut damping: Vec<f64>,
    ) -> Option<Self> {
        let pattern = &frame.layout.pattern;
        let pull = |row: usize| {
            if weights[row] > 0.0 {
                multipliers[row]
            } else {
                0.0
            }
        };
        for (at, value) in merit::curvature(frame.layout, system, pull) {
            hessian.add(pattern, at, at, value);
        }
        let mut matrix = hessian.clone();
        for (row, damping) in damping.iter_mut().enumerate() {
            *damping *= 1.0 + system.hessian.get(pattern, row, row);
            matrix.add(pattern, row, row, *damping);
        }
        merit::add_square(frame.layout, system, &weights, &mut matrix);
        matrix.factorise(pattern).ok()?;
        Some(Self {
            matrix,
            hessian,
            weights,
            violations,
            multipliers: multipliers.to_vec(),
            damping,
        })
    }

    /// The step to the optimum of the model at `system`.
    pub fn step(&self, frame: &Frame, system: &System) -> KktStep {
        let layout = frame.layout;
        let (weights, violations) = (&self.weights, &self.violations);
        let mut multipliers = self.multipliers.clone();
        let mut delta = DVector::zeros(layout.size());
        let mut residual = DVector::zeros(layout.size());
        let mut rows = vec![0.0; multipliers.len()];
        let largest = violations
            .iter()
            .fold(0.0, |most: f64, v| most.max(v.abs()));
        for _ in 0..REFINEMENTS {
            // Minus the gradient of the model's augmented Lagrangian at delta.
            residual.copy_from(&system.gradient);
            self.hessian
                .multiply_add(&layout.pattern, &delta, &mut residual);
            let pull = |row: usize| {
                if weights[row] > 0.0 {
                    multipliers[row] + weights[row] * (violations[row] + rows[row])
                } else {
                    0.0
                }
            };
            merit::add_pull(layout, system, pull, &mut residual);
            residual.neg_mut();
            self.matrix.solve(&layout.pattern, &mut residual);
            delta += &residual;
            merit::along(layout, system, &delta, &mut rows);
            let mut worst: f64 = 0.0;
            for (row, multiplier) in multipliers.iter_mut().enumerate() {
                let error = if weights[row] > 0.0 {
                    violations[row] + rows[row]
                } else {
                    0.0
                };
                *multiplier += weights[row] * error;
                worst = worst.max(error.abs());
            }
            if worst <= (EXACT * largest).max(ROUNDING) {
                break;
            }
        }
        for (multiplier, weight) in multipliers.iter_mut().zip(weights) {
            if *weight == 0.0 {
                *multiplier = 0.0;
            }
        }
        KktStep { delta, multipliers }
    }

    /// The step that also removes what the constraints depart from their linearisation.
    fn correct(
        &self,
        frame: &Frame,
        system: &System,
        trial: &System,
        delta: &DVector<f64>,
    ) -> DVector<f64> {
        let weights = &self.weights;
        delta + merit::correction(frame.layout, (system, trial), delta, weights, &self.matrix)
    }

    /// The damping's share of `xᵀ (H + w JᵀJ) x`.
    pub fn damped(&self, x: &DVector<f64>) -> f64 {
        x.iter().zip(&self.damping).map(|(x, d)| d * x * x).sum()
    }

    /// Solves `(H + w JᵀJ) x = b` in place.
    pub fn solve(&self, frame: &Frame, b: &mut DVector<f64>) {
        self.matrix.solve(&frame.layout.pattern, b);
    }
}

/// What was taken of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Taken {
    Whole,
    Part,
    Not,
}

/// A point on its way through the finish.
pub struct Finish<'a> {
    /// What stays fixed.
    pub frame: &'a Frame<'a>,
    /// Where it stands.
    pub point: Point,
    /// Objective and constraints there.
    pub system: System,
    /// Multipliers, row by row.
    pub multipliers: Vec<f64>,
    /// Work done so far.
    pub counters: Counters,
}

impl Finish<'_> {
    /// Steps until within tolerances, no step helps, or `should_stop`.
    pub fn run(
        &mut self,
        tolerances: &Tolerances,
        should_stop: &mut dyn FnMut() -> bool,
    ) -> Finished {
        let guidance = Guidance::none(self.frame.problem);
        let mut trial = (self.point.clone(), self.system.clone());
        let mut finished = Finished {
            converged: false,
            violation: self.system.violation(),
            decrease: f64::INFINITY,
        };
        let mut promised_before: Option<f64> = None;
        let mut is_slow = false;
        for taken_before in 0..tolerances.steps {
            if should_stop() {
                break;
            }
            self.counters.iterations += 1;
            let Some((kkt, step)) = self.step(is_slow) else {
                break;
            };
            let decrease = self.system.gradient.dot(&step.delta).abs();
            let promised = decrease / self.system.cost.max(NO_COST);
            let taken = self.search(&guidance, &kkt, &step, &mut trial);
            finished.decrease = match (taken, promised_before) {
                // Steps converge linearly at least: the next promises less by what this one did.
                (Taken::Whole, Some(before)) => promised * (promised / before).min(1.0),
                _ => promised,
            };
            if taken != Taken::Not {
                std::mem::swap(&mut self.point, &mut trial.0);
                std::mem::swap(&mut self.system, &mut trial.1);
                self.multipliers = step.multipliers;
            }
            finished.violation = self.system.violation();
            finished.converged = finished.violation < tolerances.violation
                && finished.decrease < tolerances.decrease;
            if finished.converged || taken == Taken::Not {
                break;
            }
            // Steps that a Gauss–Newton model shortens or repeats want the constraints' curvature.
            let is_late = taken_before + 1 >= SLOW_STEPS;
            is_slow |= taken != Taken::Whole
                || is_late && promised_before.is_some_and(|before| promised > SLOW * before);
            promised_before = (taken == Taken::Whole).then_some(promised);
        }
        finished
    }

    /// The step to the optimum of the quadratic programme here. Which bounds act is found by
    /// trying: those that the step would break join, those that pull inwards leave. Where that
    /// goes round in circles it is clarabel's word.
    fn step(&mut self, is_slow: bool) -> Option<(Kkt, KktStep)> {
        if is_slow && let Some(curved) = self.curved_step() {
            return Some(curved);
        }
        self.step_with(None)
    }

    /// The same with the curvature of the constraints; `None` where the model then has no optimum.
    fn curved_step(&mut self) -> Option<(Kkt, KktStep)> {
        let mut curved = self.system.hessian.clone();
        let multipliers = &self.multipliers;
        curvature::add(
            self.frame,
            &self.system,
            &self.point,
            multipliers,
            &mut curved,
        );
        self.step_with(Some(&curved))
    }

    fn step_with(&mut self, curved: Option<&Envelope>) -> Option<(Kkt, KktStep)> {
        let (frame, system) = (self.frame, &self.system);
        let mut acting = ActingSet::of(frame, system, &self.multipliers);
        let mut tried = Vec::new();
        while tried.len() < ACTING_ROUNDS && !tried.contains(&acting) {
            self.counters.factorisations += 1;
            let kkt = Kkt::with(frame, system, &self.multipliers, (&acting, curved))?;
            let step = kkt.step(frame, system);
            tried.push(acting.clone());
            if !acting.revise(frame, system, &step) {
                return Some((kkt, step));
            }
        }
        let multipliers = qp::multipliers(frame, system);
        let multipliers = multipliers.as_ref().unwrap_or(&self.multipliers);
        self.counters.factorisations += 1;
        let kkt = Kkt::new(frame, system, multipliers)?;
        let step = kkt.step(frame, system);
        Some((kkt, step))
    }

    fn evaluate(
        &mut self,
        guidance: &Guidance,
        delta: &DVector<f64>,
        (point, system): &mut (Point, System),
    ) {
        point.retract_from(&self.point, self.frame.problem, self.frame.layout, delta);
        system.evaluate(self.frame, guidance, point);
        self.counters.evaluations += 1;
    }

    /// Finds along `step` what lowers the ℓ₁ merit: the whole, the whole corrected, a half, …
    fn search(
        &mut self,
        guidance: &Guidance,
        kkt: &Kkt,
        step: &KktStep,
        trial: &mut (Point, System),
    ) -> Taken {
        let largest =
            |multipliers: &[f64]| multipliers.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let price = 1.5 * largest(&step.multipliers).max(largest(&self.multipliers)) + 1e-12;
        let merit = |system: &System| system.cost + price * system.total_violation();
        let enough = merit(&self.system) * (1.0 + 1e-14);
        let mut delta = step.delta.clone();
        for halving in 0..HALVINGS_MAX {
            self.evaluate(guidance, &delta, trial);
            if merit(&trial.1) <= enough {
                return if halving == 0 {
                    Taken::Whole
                } else {
                    Taken::Part
                };
            }
            if halving == 0 {
                let corrected = kkt.correct(self.frame, &self.system, &trial.1, &delta);
                self.evaluate(guidance, &corrected, trial);
                if merit(&trial.1) <= enough {
                    return Taken::Whole;
                }
            }
            delta *= 0.5;
        }
        Taken::Not
    }
}
