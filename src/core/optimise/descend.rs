//! Levenberg–Marquardt on the augmented Lagrangian, with a second-order correction:
//!
//! ```text
//! (H + Jᵀ W J + λ D) δ = −(g + Jᵀ W d)
//! ρ = (L(x) − L(x ⊞ δ)) / (½ δᵀ(λ D δ − g_L)),   accepted where ρ > 1e-4
//! accepted: λ ← λ max(1/3, 1 − (2ρ − 1)³);   refused: λ ← 2λ, then 4λ, 8λ, …
//! ```
//!
//! with `g_L` the gradient of the augmented Lagrangian `L`, `W` and `d` its weights and distances
//! of active rows. `H` contains what is convex of the rows' own curvature
//! ([`System::curvature`]): at an apex nothing else holds the time of a goal. The rule for `λ` is
//! that of H. B. Nielsen, "Damping Parameter in Marquardt's Method" (IMM-REP-1999-05). The damping
//! matrix `D` is fixed ([`Program::damping`]): the diagonal of the normal matrix would let the
//! constraints' weight damp the motion along their valley.

use nalgebra::DVector;

use super::envelope::Envelope;
use super::lagrangian::{Acting, AugmentedLagrangian};
use super::program::Program;
use super::system::{Curvature, System};
use super::work::Work;

/// Least and greatest damping `λ` at the start of a descent.
pub const DAMPING: (f64, f64) = (1e-6, 1e-2);

/// A descent: the current point with its system, and the memory for its steps.
pub struct Descent<'a, P: Program> {
    /// What is minimised.
    pub program: &'a P,
    /// The current point.
    pub point: P::Point,
    /// Cost and constraints at the point.
    pub system: System,
    /// The damping `λ`.
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

/// A descent stops after so many successive steps that change less than [`Patience::gain`].
const IDLE_STEPS: usize = 2;

/// A damped step.
struct DampedStep {
    delta: DVector<f64>,
    /// Decrease of the undamped quadratic model over the step.
    predicted: f64,
    /// `λ δᵀ D δ`.
    damped: f64,
}

/// When a descent stops.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// Greatest number of steps.
    pub steps: usize,
    /// It stops where the estimated remaining decrease, or the change of two successive steps, is
    /// less than this.
    pub gain: f64,
}

impl<'a, P: Program> Descent<'a, P> {
    /// A descent from `point`; call [`Descent::refresh`] to evaluate it.
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

    /// Descends on the augmented Lagrangian from a `λ` clipped to [`DAMPING`], until `should_stop`, which is told
    /// the work of each step, returns true at the latest; returns the number of steps.
    pub fn run(
        &mut self,
        guidance: &P::Guidance,
        lagrangian: &AugmentedLagrangian,
        patience: Patience,
        should_stop: &mut dyn FnMut(usize) -> bool,
    ) -> usize {
        self.damping = self.damping.clamp(DAMPING.0, DAMPING.1);
        self.go_on(guidance, lagrangian, patience, should_stop)
    }

    /// [`Descent::run`] without clipping `λ`.
    pub fn go_on(
        &mut self,
        guidance: &P::Guidance,
        lagrangian: &AugmentedLagrangian,
        patience: Patience,
        should_stop: &mut dyn FnMut(usize) -> bool,
    ) -> usize {
        let mut growth = 2.0;
        let mut idle = 0;
        for step in 1..=patience.steps {
            if should_stop(self.program.iteration_work(&self.point).plain) {
                return step - 1;
            }
            let before = lagrangian.merit(&self.system);
            let Some(DampedStep {
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
                let (point, system) = &mut self.trial;
                self.program.differentiate(guidance, point, system);
                std::mem::swap(&mut self.point, &mut self.trial.0);
                std::mem::swap(&mut self.system, &mut self.trial.1);
                self.damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).max(1.0 / 3.0);
                growth = 2.0;
            } else {
                self.damping *= growth;
                growth *= 2.0;
            }
            // Estimate of the decrease that remains: the error of the model and the part that
            // damping held back. At a kink (a contact between sticking and sliding, a bound)
            // predictions stay large though no step gains anything; idle steps end it there.
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

    /// Predicted decrease of a step with the least damping; infinite where there is no such step.
    pub fn promise(&mut self, lagrangian: &AugmentedLagrangian) -> f64 {
        let damping = std::mem::replace(&mut self.damping, DAMPING.0);
        let direction = self.direction(lagrangian);
        self.damping = damping;
        direction.map_or(f64::INFINITY, |direction| direction.predicted)
    }

    /// The damped step; `None` where the matrix is not positive definite.
    fn direction(&mut self, lagrangian: &AugmentedLagrangian) -> Option<DampedStep> {
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
        let curvature = self.system.curvature(structure, pull).into_iter();
        for of in curvature.filter(Curvature::is_convex) {
            self.matrix
                .add(&structure.pattern, of.row, of.column, of.value);
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
        Some(DampedStep {
            delta,
            predicted,
            damped,
        })
    }

    /// Evaluates the step and, where it gains less than 0.9 of the predicted decrease, the
    /// corrected step; leaves the better one in `trial` and returns its augmented Lagrangian.
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
        self.program.try_out(guidance, point, system);
        self.work.evaluations += 1;
        let merit = lagrangian.merit(system);
        if merit.is_finite() {
            merit
        } else {
            f64::INFINITY
        }
    }

    /// The step with its second-order correction ([`System::correction`]); `None` where the
    /// correction is longer than 0.75 of the step, both measured by `√(δᵀ D δ)`.
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
