//! The finish: Newton steps on the optimality conditions ([`super::kkt`]) until constraints hold to
//! rounding. Steps are judged by the ℓ₁ merit.

use nalgebra::DVector;

use super::active::ActiveSet;
use super::envelope::Envelope;
use super::kkt::{Kkt, KktStep};
use super::program::Program;
use super::qp;
use super::system::System;
use super::work::Work;

/// Rounds in which the set of active bounds must settle.
const ACTIVE_ROUNDS: usize = 12;
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
    /// Those tolerances.
    pub tolerances: Tolerances,
    /// Largest violation left, in units.
    pub violation: f64,
    /// Decrease that a further step would promise, relative to the objective, as far as the last
    /// ones tell.
    pub decrease: f64,
}

/// What was taken of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Taken {
    Whole,
    Part,
    Not,
}

/// A point on its way through the finish.
pub struct Finish<'a, P: Program> {
    /// What is minimised.
    pub program: &'a P,
    /// Where it stands.
    pub point: P::Point,
    /// Cost and constraints there.
    pub system: System,
    /// Multipliers, row by row.
    pub multipliers: Vec<f64>,
    /// Work done so far.
    pub work: Work,
}

impl<P: Program> Finish<'_, P> {
    /// Steps until within tolerances, no step helps, or `should_stop`. `guidance` is that of the end.
    pub fn run(
        &mut self,
        guidance: &P::Guidance,
        tolerances: &Tolerances,
        should_stop: &mut dyn FnMut() -> bool,
    ) -> Finished {
        let mut trial = (self.point.clone(), self.system.clone());
        let mut finished = Finished {
            converged: false,
            tolerances: *tolerances,
            violation: self.system.violation(),
            decrease: f64::INFINITY,
        };
        let mut promised_before: Option<f64> = None;
        let mut is_slow = false;
        for taken_before in 0..tolerances.steps {
            if should_stop() {
                break;
            }
            self.work.iterations += 1;
            let Some((kkt, step)) = self.step(is_slow) else {
                break;
            };
            let decrease = self.system.gradient.dot(&step.delta).abs();
            let promised = decrease / self.system.cost.max(NO_COST);
            let taken = self.search(guidance, &kkt, &step, &mut trial);
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
        let at = (&self.point, &self.system);
        self.program
            .add_curvature(at, &self.multipliers, &mut curved);
        self.step_with(Some(&curved))
    }

    fn step_with(&mut self, curved: Option<&Envelope>) -> Option<(Kkt, KktStep)> {
        let (program, system) = (self.program, &self.system);
        let structure = program.structure();
        let hessian = curved.unwrap_or(&system.hessian);
        let information = program.information().1;
        let mut active = ActiveSet::of(system, &self.multipliers, information);
        let mut tried = Vec::new();
        while tried.len() < ACTIVE_ROUNDS && !tried.contains(&active) {
            self.work.factorisations += 1;
            let kkt = Kkt::with(program, (system, hessian), &self.multipliers, &active)?;
            let step = kkt.step(structure, (system, hessian));
            tried.push(active.clone());
            if !active.revise(structure, system, (&step.delta, &step.multipliers)) {
                return Some((kkt, step));
            }
        }
        let multipliers = qp::multipliers(structure, system);
        let multipliers = multipliers.as_ref().unwrap_or(&self.multipliers);
        self.work.factorisations += 1;
        let kkt = Kkt::new(program, system, multipliers)?;
        let step = kkt.step(structure, (system, &system.hessian));
        Some((kkt, step))
    }

    fn evaluate(
        &mut self,
        guidance: &P::Guidance,
        delta: &DVector<f64>,
        (point, system): &mut (P::Point, System),
    ) {
        self.program.retract(&self.point, delta, point);
        self.program.evaluate(guidance, point, system);
        self.work.evaluations += 1;
    }

    /// Finds along `step` what lowers the ℓ₁ merit: the whole, the whole corrected, a half, …
    fn search(
        &mut self,
        guidance: &P::Guidance,
        kkt: &Kkt,
        step: &KktStep,
        trial: &mut (P::Point, System),
    ) -> Taken {
        let largest =
            |multipliers: &[f64]| multipliers.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let lagrangian = 1.5 * largest(&step.multipliers).max(largest(&self.multipliers)) + 1e-12;
        let merit = |system: &System| system.cost + lagrangian * system.total_violation();
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
                let corrected =
                    kkt.correct(self.program.structure(), (&self.system, &trial.1), &delta);
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
