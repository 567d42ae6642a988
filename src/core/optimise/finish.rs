//! The finish: sequential quadratic programming by KKT steps ([`super::kkt`]) until the constraints
//! hold to rounding.
//!
//! Steps are accepted by a merit (`search`): in full, in full with corrections that lead it back to
//! the constraints, or halved.
//!
//! Where the constraints determine nearly every unknown, damping the Hessian would do nothing. Where
//! they and the samples leave some open, as the turn of a body of which only the centre is seen, its
//! exact Hessian is small or indefinite there ([`Program::is_open`]); where constraints are strongly
//! curved it is indefinite far from the optimum ([`Program::is_curved`]). Steps are then damped,
//! `H + λ D` ([`Program::damping`]), the more the worse they go.

mod search;

use super::active::ActiveSet;
use super::envelope::Envelope;
use super::kkt::{Kkt, KktStep};
use super::program::Program;
use super::qp;
use super::system::System;
use super::work::Work;

/// Greatest number of revisions of the active set before clarabel decides.
const ACTIVE_ROUNDS: usize = 12;
/// Convergence is slow where, after [`SLOW_STEPS`] steps, a step predicts more than this share of
/// the decrease that the previous one predicted. The curvature of constraints and residuals is then added to `H`.
const SLOW: f64 = 0.5;
const SLOW_STEPS: usize = 5;
/// Least and greatest damping `λ`, and the factor from one to the next.
const DAMPING: (f64, f64) = (1e-6, 1e4);
const DAMPING_FACTOR: f64 = 4.0;
/// How many times as many steps there may be where they are damped.
const DAMPED_STEPS: usize = 3;
/// Number of steps that together must gain something, where they are damped: directions that next to
/// nothing determines are valleys along which steps could go on for long.
const CREEPING_STEPS: usize = 8;
/// Least objective to which the predicted decrease is relative. With a smaller objective, the
/// remaining decrease is less than a nanometre and of the size of rounding.
const NO_COST: f64 = 1e-6;

/// When the finish is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Largest violation of a constraint, in units.
    pub violation: f64,
    /// Predicted decrease `|g·d|` of the next step, relative to the objective.
    pub decrease: f64,
    /// Greatest number of steps.
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
    /// Whether violation and decrease are within tolerances.
    pub converged: bool,
    /// Those tolerances.
    pub tolerances: Tolerances,
    /// Largest violation left, in units.
    pub violation: f64,
    /// Predicted decrease of a further step, relative to the objective, extrapolated from the last
    /// two.
    pub decrease: f64,
}

/// How much of a step was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StepTaken {
    Whole,
    Part,
    Not,
}

/// Where a step leads.
struct FinishPlace<T> {
    point: T,
    system: System,
    multipliers: Vec<f64>,
}

/// A point on its way through the finish.
pub struct Finish<'a, P: Program> {
    /// What is minimised.
    pub program: &'a P,
    /// The current point.
    pub point: P::Point,
    /// Cost and constraints at the point.
    pub system: System,
    /// Multipliers `ν`, row by row.
    pub multipliers: Vec<f64>,
    /// Damping `λ` of steps with the exact Hessian; zero where they go well without.
    pub damping: f64,
    /// Work done so far.
    pub work: Work,
    /// The Lagrangian's Hessian at the point, once it was asked for.
    pub exact: Option<Envelope>,
}

impl<P: Program> Finish<'_, P> {
    /// Takes steps until `tolerances` are met, no step lowers the merit, or `should_stop` returns
    /// true. `guidance` is that of [`Stage::Finish`](super::Stage::Finish).
    pub fn run(
        &mut self,
        guidance: &P::Guidance,
        tolerances: &Tolerances,
        should_stop: &mut dyn FnMut(usize) -> bool,
    ) -> Finished {
        let mut trial = self.here();
        let mut finished = Finished {
            converged: false,
            tolerances: *tolerances,
            violation: self.system.violation(),
            decrease: f64::INFINITY,
        };
        let mut promised_before: Option<f64> = None;
        // At an apex the constraint's own curvature alone would be a wrong model.
        let mut is_slow = self.system.has_pulled_curvature(&self.multipliers);
        let mut was_damped = false;
        let mut merits = Vec::new();
        for taken_before in 0..DAMPED_STEPS * tolerances.steps {
            // Where damping ends late one step without it is due.
            let is_damped = self.damping > 0.0;
            let is_over = taken_before >= tolerances.steps && !(is_damped || was_damped);
            was_damped = is_damped;
            let each = self.program.iteration_work(&self.point).curved;
            if is_over || should_stop(each) {
                break;
            }
            self.work.iterations += 1;
            let Some((kkt, step)) = self.step(is_slow) else {
                break;
            };
            let promised = self.promises(&step);
            let may_damp = is_slow && self.is_dampable();
            let taken = self.search(guidance, &kkt, &step, may_damp, &mut trial);
            finished.decrease = match (taken, promised_before) {
                // Convergence is at least linear: the next predicted decrease is smaller by at
                // least the last ratio.
                (StepTaken::Whole, Some(before)) => promised * (promised / before).min(1.0),
                _ => promised,
            };
            if taken != StepTaken::Not {
                self.go(&mut trial);
            }
            // A damped step promises little wherever it is.
            let is_restored = taken != StepTaken::Not && self.damping > 0.0 && {
                merits.push(self.merit());
                finished.decrease = finished.decrease.max(self.gained(&merits));
                finished.decrease < tolerances.decrease
                    && self.restores(guidance, tolerances, &mut trial)
            };
            finished.violation = self.system.violation();
            let is_met = finished.violation < tolerances.violation;
            // Where a damped step promises nothing, the undamped one tells whether there is nothing left.
            let is_asked = is_met && self.damping > 0.0 && promised < tolerances.decrease;
            let undamped = is_asked.then(|| self.undamped_promise()).flatten();
            let undamped = undamped.filter(|promise| *promise < tolerances.decrease);
            finished.decrease = undamped.unwrap_or(finished.decrease);
            finished.converged = is_met
                && finished.decrease < tolerances.decrease
                && (is_restored || self.damping == 0.0 || undamped.is_some());
            if finished.converged || taken == StepTaken::Not && !self.can_damp() {
                break;
            }
            if taken == StepTaken::Whole {
                self.relax();
            } else if may_damp {
                self.damp();
            }
            // Shortened or slowly converging steps mean that the Gauss–Newton model lacks
            // curvature.
            let is_late = taken_before + 1 >= SLOW_STEPS;
            is_slow |= taken != StepTaken::Whole
                || is_late && promised_before.is_some_and(|before| promised > SLOW * before);
            promised_before = (taken == StepTaken::Whole).then_some(promised);
        }
        finished
    }

    /// Decrease `|g·d|` that a step predicts, relative to the objective.
    fn promises(&self, step: &KktStep) -> f64 {
        self.system.gradient.dot(&step.delta).abs() / self.system.cost.max(NO_COST)
    }

    /// What the last steps gained together, relative to the objective; infinite where there were too few.
    fn gained(&self, merits: &[f64]) -> f64 {
        let Some(at) = merits.len().checked_sub(1 + CREEPING_STEPS) else {
            return f64::INFINITY;
        };
        (merits[at] - merits[merits.len() - 1]).abs() / self.system.cost.max(NO_COST)
    }

    /// The step to the optimum of the quadratic programme at the current point. The active set is
    /// revised until the step violates no bound and no multiplier has the wrong sign; where that
    /// cycles, clarabel finds it ([`qp::multipliers`]).
    fn step(&mut self, is_slow: bool) -> Option<(Kkt, KktStep)> {
        if is_slow && let Some(curved) = self.curved_step() {
            return Some(curved);
        }
        self.step_with(None)
    }

    /// The step with the exact Hessian, damped until the model is convex on the active rows where it
    /// may be; `None` where it is not convex then.
    fn curved_step(&mut self) -> Option<(Kkt, KktStep)> {
        let exact = self.exact();
        loop {
            let step = if self.damping > 0.0 {
                self.step_with(Some(&self.damped(&exact)))
            } else {
                self.step_with(Some(&exact))
            };
            if step.is_some() || !self.can_damp() {
                return step;
            }
            self.damp();
        }
    }

    /// Hessian of the Lagrangian, computed once for each place.
    fn exact(&mut self) -> Envelope {
        if let Some(exact) = &self.exact {
            return exact.clone();
        }
        let mut exact = self.system.hessian.clone();
        let at = (&self.point, &self.system);
        self.program
            .add_curvature(at, &self.multipliers, &mut exact);
        self.exact = Some(exact.clone());
        exact
    }

    /// What the undamped step with the exact Hessian promises, relative to the objective; `None` where the model is
    /// not convex on the active rows.
    fn undamped_promise(&mut self) -> Option<f64> {
        let exact = self.exact();
        let (_, step) = self.step_with(Some(&exact))?;
        Some(self.promises(&step))
    }

    /// `H + λ D`.
    fn damped(&self, exact: &Envelope) -> Envelope {
        let pattern = &self.program.structure().pattern;
        let mut damped = exact.clone();
        for (row, scale) in self.program.damping().iter().enumerate() {
            damped.add(pattern, row, row, self.damping * scale);
        }
        damped
    }

    /// Whether damping does something: directions are open, or constraints so curved that the model may
    /// be concave along them.
    fn is_dampable(&self) -> bool {
        self.program.is_open() || self.program.is_curved()
    }

    /// Whether steps may be damped more than they are.
    fn can_damp(&self) -> bool {
        self.is_dampable() && self.damping < DAMPING.1
    }

    fn damp(&mut self) {
        self.damping = (self.damping * DAMPING_FACTOR).max(DAMPING.0);
    }

    fn relax(&mut self) {
        let less = self.damping / DAMPING_FACTOR;
        self.damping = if less < DAMPING.0 { 0.0 } else { less };
    }

    fn step_with(&mut self, curved: Option<&Envelope>) -> Option<(Kkt, KktStep)> {
        let (program, system) = (self.program, &self.system);
        let structure = program.structure();
        let information = program.information().1;
        let mut active = ActiveSet::of(system, &self.multipliers, information);
        let mut tried = Vec::new();
        while tried.len() < ACTIVE_ROUNDS && !tried.contains(&active) {
            self.work.factorisations += 1;
            let kkt = Kkt::with(program, system, curved, &self.multipliers, &active)?;
            let step = kkt.step(structure, system, curved);
            tried.push(active.clone());
            if !active.revise(structure, system, &step.delta, &step.multipliers) {
                return Some((kkt, step));
            }
        }
        let multipliers = qp::multipliers(structure, system);
        let multipliers = multipliers.as_ref().unwrap_or(&self.multipliers);
        self.work.factorisations += 1;
        let kkt = Kkt::new(program, system, multipliers)?;
        let step = kkt.step(structure, system, None);
        Some((kkt, step))
    }
}
