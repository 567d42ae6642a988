//! How much of a step is taken.
//!
//! A step is accepted where it does not increase the ℓ₁ merit `f + μ Σ |violation|` with `μ = 1.5 max |ν|`:
//! in full, in full with corrections that lead it back to the constraints, or halved (Nocedal and Wright,
//! *Numerical Optimization*, chapter 18).
//!
//! Where directions are open the floor of the valley is curved: multipliers are large beside what little is
//! left to gain along it, so that a step which leaves it by its third order is refused unless it is short.
//! A whole step may then increase the merit if further ones lead back to the floor and below (the watchdog
//! of section 15.6).

use nalgebra::DVector;

use super::{DAMPING, Finish, FinishPlace, StepTaken, Tolerances};
use crate::optimise::kkt::{Kkt, KktStep};
use crate::optimise::program::Program;
use crate::optimise::system::System;

/// Greatest number of halvings of a step, and of one that may rather be damped.
const HALVINGS: [usize; 2] = [12, 3];
/// Greatest number of corrections that lead a step back to the constraints: of a whole step where
/// nearly every unknown is determined, and of any where not,
const CORRECTIONS: [usize; 2] = [1, 4];
/// each of which must leave less than this share of the violation for another.
const CORRECTED: f64 = 0.5;
/// Greatest number of steps that lead back to the constraints without regard to the merit.
const RESTORING_STEPS: usize = 4;
/// Greatest number of steps after one that increased the merit, until it is no more than before.
const FURTHER_STEPS: usize = 3;

/// The ℓ₁ merit that a step must reach.
#[derive(Clone, Copy)]
struct Merit {
    /// `μ`.
    per_violation: f64,
    enough: f64,
}

impl Merit {
    fn of(&self, system: &System) -> f64 {
        system.cost + self.per_violation * system.total_violation()
    }

    fn is_reached(&self, system: &System) -> bool {
        self.of(system) <= self.enough
    }
}

/// `μ` for given multipliers.
fn price(multipliers: &[f64]) -> f64 {
    1.5 * multipliers
        .iter()
        .fold(0.0, |most: f64, of| most.max(of.abs()))
        + 1e-12
}

impl<P: Program> Finish<'_, P> {
    /// The current place.
    pub(super) fn here(&self) -> FinishPlace<P::Point> {
        FinishPlace {
            point: self.point.clone(),
            system: self.system.clone(),
            multipliers: self.multipliers.clone(),
        }
    }

    /// The ℓ₁ merit of the current place.
    pub(super) fn merit(&self) -> f64 {
        let merit = Merit {
            per_violation: price(&self.multipliers),
            enough: 0.0,
        };
        merit.of(&self.system)
    }

    /// Exchanges the current place for another.
    pub(super) fn go(&mut self, to: &mut FinishPlace<P::Point>) {
        self.exact = None;
        std::mem::swap(&mut self.point, &mut to.point);
        std::mem::swap(&mut self.system, &mut to.system);
        std::mem::swap(&mut self.multipliers, &mut to.multipliers);
    }

    /// Tries the full step, the full step led back to the constraints, where steps may be damped that
    /// and further ones, a half, a quarter, … until the merit is not increased; leaves the result in
    /// `trial`.
    pub(super) fn search(
        &mut self,
        guidance: &P::Guidance,
        kkt: &Kkt,
        step: &KktStep,
        may_damp: bool,
        trial: &mut FinishPlace<P::Point>,
    ) -> StepTaken {
        let mut merit = Merit {
            per_violation: price(&step.multipliers).max(price(&self.multipliers)),
            enough: 0.0,
        };
        merit.enough = merit.of(&self.system) * (1.0 + 1e-14);
        let mut delta = step.delta.clone();
        for halving in 0..HALVINGS[usize::from(may_damp)] {
            let corrections = match halving {
                _ if self.is_dampable() => CORRECTIONS[1],
                0 => CORRECTIONS[0],
                _ => 0,
            };
            trial.multipliers.clone_from(&step.multipliers);
            if self.reaches(guidance, &merit, kkt, &delta, corrections, trial) {
                return if halving == 0 {
                    StepTaken::Whole
                } else {
                    StepTaken::Part
                };
            }
            if halving == 0 && may_damp && self.leads_back(guidance, &merit, trial) {
                return StepTaken::Whole;
            }
            delta *= 0.5;
        }
        StepTaken::Not
    }

    /// Whether a step reaches a merit by itself, or after some corrections; leaves where it leads in
    /// `trial`.
    fn reaches(
        &mut self,
        guidance: &P::Guidance,
        merit: &Merit,
        kkt: &Kkt,
        delta: &DVector<f64>,
        corrections: usize,
        trial: &mut FinishPlace<P::Point>,
    ) -> bool {
        self.evaluate(guidance, delta, trial);
        if merit.is_reached(&trial.system) {
            self.complete(guidance, trial);
            return true;
        }
        let mut corrected = delta.clone();
        for _ in 0..corrections {
            let violation = trial.system.total_violation();
            let structure = self.program.structure();
            corrected += kkt.correction(structure, &self.system, &trial.system, delta);
            self.evaluate(guidance, &corrected, trial);
            if merit.is_reached(&trial.system) {
                self.complete(guidance, trial);
                return true;
            }
            // Written so that NaN ends it too.
            if !(trial.system.total_violation() < CORRECTED * violation) {
                break;
            }
        }
        false
    }

    /// Whether further steps from where one led reach a merit; leaves where they lead in `trial`.
    fn leads_back(
        &mut self,
        guidance: &P::Guidance,
        merit: &Merit,
        trial: &mut FinishPlace<P::Point>,
    ) -> bool {
        let (mut kept, damping) = (self.here(), self.damping);
        let mut is_back = false;
        for _ in 0..FURTHER_STEPS {
            if !trial.system.cost.is_finite() {
                break;
            }
            self.complete(guidance, trial);
            self.go(trial);
            let Some((kkt, step)) = self.curved_step() else {
                break;
            };
            self.damping = damping;
            trial.multipliers.clone_from(&step.multipliers);
            is_back = self.reaches(guidance, merit, &kkt, &step.delta, CORRECTIONS[1], trial);
            if is_back {
                break;
            }
        }
        self.go(&mut kept);
        self.damping = damping;
        is_back
    }

    /// Goes to the constraints by the shortest way, by steps that are damped so much that they gain
    /// nothing. Returns whether all hold then.
    pub(super) fn restores(
        &mut self,
        guidance: &P::Guidance,
        tolerances: &Tolerances,
        trial: &mut FinishPlace<P::Point>,
    ) -> bool {
        let damping = std::mem::replace(&mut self.damping, DAMPING.1);
        for _ in 0..RESTORING_STEPS {
            let violation = self.system.violation();
            if violation < tolerances.violation {
                break;
            }
            let Some((_, step)) = self.curved_step() else {
                break;
            };
            trial.multipliers.clone_from(&step.multipliers);
            self.evaluate(guidance, &step.delta, trial);
            if !(trial.system.violation() < violation) {
                break;
            }
            self.complete(guidance, trial);
            self.go(trial);
        }
        self.damping = damping;
        self.system.violation() < tolerances.violation
    }

    /// Derivatives where a trial led that is gone on from.
    fn complete(&self, guidance: &P::Guidance, trial: &mut FinishPlace<P::Point>) {
        self.program
            .differentiate(guidance, &trial.point, &mut trial.system);
    }

    fn evaluate(
        &mut self,
        guidance: &P::Guidance,
        delta: &DVector<f64>,
        trial: &mut FinishPlace<P::Point>,
    ) {
        self.program.retract(&self.point, delta, &mut trial.point);
        self.program
            .try_out(guidance, &trial.point, &mut trial.system);
        self.work.evaluations += 1;
    }
}
