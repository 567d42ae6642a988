//! Levenberg–Marquardt on the augmented Lagrangian, as the program's, over any grid's unknowns.

use enact::estimate::merit::{self, Acting, AugmentedLagrangian};
use enact::estimate::problem::Problem;
use enact::estimate::system::{Guidance, System};
use enact::math::envelope::Envelope;
use nalgebra::DVector;

use super::model::Model;
use super::parts::Part;
use super::setting::Place;

/// Lengths of the damping: position [m], orientation [rad], velocity [m/s], angular velocity
/// [rad/s]; times [s]; velocity gaps [units]. The program's.
const STATE_LENGTHS: [f64; 4] = [0.05, 1.0, 0.5, 5.0];
const TIME_S: f64 = 0.02;
const GAP: f64 = 5.0;
const DAMPING: (f64, f64) = enact::estimate::descend::DAMPING;
const IDLE_STEPS: usize = 2;

/// A place and everything that moves it.
pub struct Descent<'m, 'a> {
    /// What is evaluated.
    pub model: &'m mut Model<'a>,
    /// Where it stands.
    pub place: Place,
    /// Objective and constraints there.
    pub system: System,
    /// Factorisations so far.
    pub iterations: usize,
    damping: f64,
    scale: DVector<f64>,
    trial: (Place, System),
    corrected: (Place, System),
    matrix: Envelope,
    acting: Acting,
    gradient: DVector<f64>,
}

impl<'m, 'a> Descent<'m, 'a> {
    /// At a place, which [`Descent::refresh`] evaluates.
    pub fn new(model: &'m mut Model<'a>, place: Place) -> Self {
        let system = model.system();
        Self {
            iterations: 0,
            damping: 1e-3,
            scale: scale(model),
            trial: (place.clone(), system.clone()),
            corrected: (place.clone(), system.clone()),
            matrix: system.hessian.clone(),
            acting: Acting::default(),
            gradient: system.gradient.clone(),
            model,
            place,
            system,
        }
    }

    /// Evaluates the place under a guidance.
    pub fn refresh(&mut self, guidance: &Guidance) {
        self.model.evaluate(guidance, &self.place, &mut self.system);
    }

    /// So many steps at most, until no more than `gain` is left or two on end change less.
    pub fn run(
        &mut self,
        guidance: &Guidance,
        lagrangian: &AugmentedLagrangian,
        (steps, gain): (usize, f64),
    ) {
        self.damping = self.damping.clamp(DAMPING.0, DAMPING.1);
        let mut growth = 2.0;
        let mut idle = 0;
        for _ in 0..steps {
            let before = lagrangian.merit(&self.system);
            let Some((delta, predicted, damped)) = self.direction(lagrangian) else {
                self.damping = (self.damping * 10.0).max(1e-6);
                continue;
            };
            let after = self.try_step(guidance, lagrangian, &delta, before, predicted);
            let gained = before - after;
            let ratio = gained / predicted.max(f64::MIN_POSITIVE);
            if gained.is_finite() && ratio > 1e-4 {
                std::mem::swap(&mut self.place, &mut self.trial.0);
                std::mem::swap(&mut self.system, &mut self.trial.1);
                self.damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).max(1.0 / 3.0);
                growth = 2.0;
            } else {
                self.damping *= growth;
                growth *= 2.0;
            }
            let left = (gained - predicted).abs() + damped;
            idle = if gained.abs() < gain { idle + 1 } else { 0 };
            if left < gain || idle == IDLE_STEPS {
                return;
            }
        }
    }

    /// The damped step, the decrease it promises, and what damping takes of that.
    fn direction(&mut self, lagrangian: &AugmentedLagrangian) -> Option<(DVector<f64>, f64, f64)> {
        let layout = self.model.outer.layout;
        let pattern = &layout.pattern;
        self.iterations += 1;
        lagrangian.act(&self.system, &mut self.acting);
        let acting = &self.acting;
        self.gradient.copy_from(&self.system.gradient);
        let pull = |row: usize| acting.weights[row] * acting.distances[row];
        merit::add_pull(layout, &self.system, pull, &mut self.gradient);
        self.matrix.copy_from(&self.system.hessian);
        merit::add_square(layout, &self.system, &acting.weights, &mut self.matrix);
        for (at, value) in merit::curvature(layout, &self.system, pull) {
            self.matrix.add(pattern, at, at, value);
        }
        for row in 0..layout.size() {
            let damping = self.damping * self.scale[row];
            self.matrix.add(pattern, row, row, damping);
        }
        self.matrix.factorise(pattern).ok()?;
        let mut delta = -&self.gradient;
        self.matrix.solve(pattern, &mut delta);
        let size: f64 = delta.iter().zip(&self.scale).map(|(d, s)| d * d * s).sum();
        let damped = self.damping * size;
        let predicted = 0.5 * (-self.gradient.dot(&delta) + damped);
        Some((delta, predicted, damped))
    }

    /// Leaves the better of the step and the step corrected for curvature in `trial`.
    fn try_step(
        &mut self,
        guidance: &Guidance,
        lagrangian: &AugmentedLagrangian,
        delta: &DVector<f64>,
        before: f64,
        predicted: f64,
    ) -> f64 {
        let after = self.evaluate_trial(guidance, lagrangian, delta);
        if before - after >= 0.9 * predicted || !after.is_finite() {
            return after;
        }
        let (weights, systems) = (&self.acting.weights, (&self.system, &self.trial.1));
        let layout = self.model.outer.layout;
        let correction = merit::correction(layout, systems, delta, weights, &self.matrix);
        let size = |d: &DVector<f64>| -> f64 {
            d.iter()
                .zip(&self.scale)
                .map(|(d, s)| d * d * s)
                .sum::<f64>()
                .sqrt()
        };
        if !(size(&correction) < 0.75 * size(delta)) {
            return after;
        }
        std::mem::swap(&mut self.trial, &mut self.corrected);
        let corrected_after = self.evaluate_trial(guidance, lagrangian, &(delta + correction));
        if corrected_after < after {
            return corrected_after;
        }
        std::mem::swap(&mut self.trial, &mut self.corrected);
        after
    }

    fn evaluate_trial(
        &mut self,
        guidance: &Guidance,
        lagrangian: &AugmentedLagrangian,
        delta: &DVector<f64>,
    ) -> f64 {
        self.trial.0 = self.model.moved(&self.place, delta);
        self.model
            .evaluate(guidance, &self.trial.0, &mut self.trial.1);
        let merit = lagrangian.merit(&self.trial.1);
        if merit.is_finite() {
            merit
        } else {
            f64::INFINITY
        }
    }
}

/// `10/s²` for every unknown.
fn scale(model: &Model) -> DVector<f64> {
    let problem: &Problem = model.outer.problem;
    let information = problem.least_information();
    let weight = |length: f64| 10.0 * information / (length * length);
    let of = |part: Part| match part {
        Part::Piece(_) => STATE_LENGTHS.iter().flat_map(|l| [weight(*l); 3]).collect(),
        Part::Event(_) => vec![weight(TIME_S)],
        Part::Parameter(p) => vec![weight(problem.parameters[p].length())],
    };
    model.by_unknown(of, weight(GAP))
}
