//! Levenberg–Marquardt on the augmented Lagrangian, with a second-order correction.
//!
//! The damping matrix is fixed ([`Program::damping`]): the
//! diagonal of the normal matrix would let the constraints' weight damp the motion along
//! their valley.

use nalgebra::DVector;

use super::envelope::Envelope;
use super::lagrangian::{Acting, AugmentedLagrangian};
use super::program::Program;
use super::system::System;
use super::work::Work;

/// Least and greatest damping at the start of a descent.
pub const DAMPING: (f64, f64) = (1e-6, 1e-2);

/// A point and everything that moves it.
pub struct Descent<'a, P: Program> {
    /// What is minimised.
    pub program: &'a P,
    /// Where it stands.
    pub point: P::Point,
    /// Cost and constraints there.
    pub system: System,
    /// Levenberg–Marquardt's λ.
    pub damping: f64,
    /// Work done so far.
    pub work: Work,
    scale: DVector<f64>,
    trial: (P::Point, System),
    corrected: (P::Point, System),
    matrix: Envelope,
    acting: Acting,
    gradient: DVector<f64>,
}

/// Steps on end that change less than is worth a step, after which a descent stops.
const IDLE_STEPS: usize = 2;

/// A damped step.
struct Direction {
    delta: DVector<f64>,
    /// Decrease of the model.
    predicted: f64,
    /// What the damping takes of it.
    damped: f64,
}

/// When a descent may stop.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// At most so many steps.
    pub steps: usize,
    /// Enough when no more than this is left to gain, or two steps on end changed less.
    pub gain: f64,
}

impl<'a, P: Program> Descent<'a, P> {
    /// At `point`, which [`Descent::refresh`] evaluates.
    pub fn new(program: &'a P, point: P::Point) -> Self {
        let structure = program.structure();
        let system = System::new(structure);
        Self {
            scale: program.damping(),
            trial: (point.clone(), system.clone()),
            corrected: (point.clone(), system.clone()),
            matrix: Envelope::zeros(&structure.pattern),
            acting: Acting::default(),
            gradient: DVector::zeros(structure.size()),
            program,
            point,
            system,
            damping: 1e-3,
            work: Work::default(),
        }
    }

    /// Evaluates the point under a guidance.
    pub fn refresh(&mut self, guidance: &P::Guidance) {
        self.program
            .evaluate(guidance, &self.point, &mut self.system);
        self.work.evaluations += 1;
    }

    /// Descends on the augmented Lagrangian; returns the number of steps.
    pub fn run(
        &mut self,
        guidance: &P::Guidance,
        lagrangian: &AugmentedLagrangian,
        patience: Patience,
    ) -> usize {
        self.damping = self.damping.clamp(DAMPING.0, DAMPING.1);
        self.go_on(guidance, lagrangian, patience)
    }

    /// The same, with the damping as it is.
    pub fn go_on(
        &mut self,
        guidance: &P::Guidance,
        lagrangian: &AugmentedLagrangian,
        patience: Patience,
    ) -> usize {
        let mut growth = 2.0;
        let mut idle = 0;
        for step in 1..=patience.steps {
            let before = lagrangian.merit(&self.system);
            let Some(Direction {
                delta,
                predicted,
                damped,
            }) = self.direction(lagrangian)
            else {
                self.damping = (self.damping * 10.0).max(1e-6);
                continue;
            };
            let after = self.try_step(guidance, lagrangian, &delta, before, predicted);
            let gained = before - after;
            let ratio = gained / predicted.max(f64::MIN_POSITIVE);
            if gained.is_finite() && ratio > 1e-4 {
                std::mem::swap(&mut self.point, &mut self.trial.0);
                std::mem::swap(&mut self.system, &mut self.trial.1);
                self.damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).max(1.0 / 3.0);
                growth = 2.0;
            } else {
                self.damping *= growth;
                growth *= 2.0;
            }
            // After a whole step nothing is left but what damping kept back and the model did not
            // know. At a kink (a contact between sticking and sliding, a bound) all steps promise
            // what none keeps.
            let left = (gained - predicted).abs() + damped;
            idle = if gained.abs() < patience.gain {
                idle + 1
            } else {
                0
            };
            if left < patience.gain || idle == IDLE_STEPS {
                return step;
            }
        }
        patience.steps
    }

    /// The decrease that a step with the least damping promises; infinite where there is none.
    pub fn promise(&mut self, lagrangian: &AugmentedLagrangian) -> f64 {
        let damping = std::mem::replace(&mut self.damping, DAMPING.0);
        let direction = self.direction(lagrangian);
        self.damping = damping;
        direction.map_or(f64::INFINITY, |direction| direction.predicted)
    }

    /// The damped step; `None` where there is none.
    fn direction(&mut self, lagrangian: &AugmentedLagrangian) -> Option<Direction> {
        let structure = self.program.structure();
        self.work.iterations += 1;
        self.work.factorisations += 1;
        lagrangian.act(&self.system, &mut self.acting);
        let acting = &self.acting;
        self.gradient.copy_from(&self.system.gradient);
        let pull = |row: usize| acting.weights[row] * acting.distances[row];
        self.system.add_pull(structure, pull, &mut self.gradient);
        self.matrix.copy_from(&self.system.hessian);
        self.system
            .add_square(structure, &acting.weights, &mut self.matrix);
        for (at, value) in self.system.curvature(structure, pull) {
            self.matrix.add(&structure.pattern, at, at, value);
        }
        for row in 0..structure.size() {
            self.matrix
                .add(&structure.pattern, row, row, self.damping * self.scale[row]);
        }
        self.matrix.factorise(&structure.pattern).ok()?;
        let mut delta = -&self.gradient;
        self.matrix.solve(&structure.pattern, &mut delta);
        let size: f64 = delta.iter().zip(&self.scale).map(|(d, s)| d * d * s).sum();
        let damped = self.damping * size;
        let predicted = 0.5 * (-self.gradient.dot(&delta) + damped);
        Some(Direction {
            delta,
            predicted,
            damped,
        })
    }

    /// Evaluates the step, corrected for the curvature of the constraints where that helps,
    /// and leaves the better in `trial`; returns its merit.
    fn try_step(
        &mut self,
        guidance: &P::Guidance,
        lagrangian: &AugmentedLagrangian,
        delta: &DVector<f64>,
        before: f64,
        predicted: f64,
    ) -> f64 {
        let after = self.evaluate_trial(guidance, lagrangian, delta);
        if before - after >= 0.9 * predicted {
            return after;
        }
        let Some(corrected) = self.correct(delta) else {
            return after;
        };
        std::mem::swap(&mut self.trial, &mut self.corrected);
        let corrected_after = self.evaluate_trial(guidance, lagrangian, &corrected);
        if corrected_after < after {
            return corrected_after;
        }
        std::mem::swap(&mut self.trial, &mut self.corrected);
        after
    }

    fn evaluate_trial(
        &mut self,
        guidance: &P::Guidance,
        lagrangian: &AugmentedLagrangian,
        delta: &DVector<f64>,
    ) -> f64 {
        let (point, system) = &mut self.trial;
        self.program.retract(&self.point, delta, point);
        self.program.evaluate(guidance, point, system);
        self.work.evaluations += 1;
        let merit = lagrangian.merit(system);
        if merit.is_finite() {
            merit
        } else {
            f64::INFINITY
        }
    }

    /// The step plus what removes the constraints' departure from their linearisation; `None`
    /// where that is no small correction.
    fn correct(&self, delta: &DVector<f64>) -> Option<DVector<f64>> {
        let structure = self.program.structure();
        let weights = &self.acting.weights;
        let correction =
            self.system
                .correction(structure, &self.trial.1, delta, weights, &self.matrix);
        let size = |d: &DVector<f64>| -> f64 {
            d.iter()
                .zip(&self.scale)
                .map(|(d, s)| d * d * s)
                .sum::<f64>()
                .sqrt()
        };
        (size(&correction) < 0.75 * size(delta)).then(|| delta + correction)
    }
}
