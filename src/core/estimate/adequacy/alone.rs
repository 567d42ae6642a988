//! Every flight by itself: the minimum of the objective without constraints and without goals that have
//! a weight, which are wishes and no measurements. Times of events, which then depend on nothing but
//! their marks, stay.

use nalgebra::DVector;

use crate::estimate::covariance::bins::Residuals;
use crate::estimate::outcome;
use crate::estimate::terms::context::{Guidance, SolveContext};
use crate::estimate::unknowns::point::Point;
use crate::optimise::envelope::Envelope;
use crate::optimise::kkt::DAMPING;
use crate::optimise::{Program, System};

/// Greatest number of Gauss–Newton steps.
const STEPS: usize = 4;
/// Steps end where the next one promises less than this share of the objective.
const PROMISE: f64 = 1e-3;
/// Greatest number of halvings of a step.
const HALVINGS: usize = 2;

/// The flights by themselves.
pub(super) struct Alone {
    /// States, and sample times where they are unknown, at the minimum.
    pub(super) point: Point,
    /// Objective and constraints there.
    pub(super) system: System,
    /// Residuals of all samples, arc by arc, in units.
    pub(super) errors: Vec<Residuals>,
    /// What is left of the way to the minimum, of which constraints are predicted; zero there.
    step: DVector<f64>,
    /// The factorised Hessian.
    factor: Envelope,
    /// Unknowns on which the samples do not depend.
    is_unseen: Vec<bool>,
}

impl Alone {
    /// Releases all constraints at a solution; `None` where the Hessian cannot be factorised.
    pub(super) fn new(context: &SolveContext, point: &Point, system: &System) -> Option<Self> {
        let (mut point, mut system) = (point.clone(), without_wishes(context, point, system));
        let pattern = &context.structure().pattern;
        let is_unseen = unseen(context, &system);
        let mut factor = damped(context, &system)?;
        for _ in 0..STEPS {
            let mut step = -&system.gradient;
            solve(context, &factor, &is_unseen, &mut step);
            let promise = -0.5 * system.gradient.dot(&step);
            if promise <= PROMISE * system.cost {
                break;
            }
            let mut is_lower = false;
            for _ in 0..=HALVINGS {
                let mut there = point.clone();
                context.retract(&point, &step, &mut there);
                let of_there = context.evaluated(&Guidance::without_wishes(), &there);
                if of_there.cost < system.cost {
                    (point, system, is_lower) = (there, of_there, true);
                    break;
                }
                step *= 0.5;
            }
            if !is_lower {
                break;
            }
            factor = damped(context, &system)?;
        }
        Some(Self {
            step: DVector::zeros(pattern.size()),
            is_unseen,
            errors: outcome::errors(context.problem, context, &point),
            point,
            system,
            factor,
        })
    }

    /// The same as predicted at the solution itself, for the errors of the flights by themselves.
    /// Where flights are so free that their minimum is far, derivatives are right only at one of
    /// the two, under a right model here.
    pub(super) fn predicted(
        context: &SolveContext,
        point: &Point,
        system: &System,
        errors: &[Residuals],
    ) -> Option<Self> {
        let system = without_wishes(context, point, system);
        let is_unseen = unseen(context, &system);
        let factor = damped(context, &system)?;
        let mut step = -&system.gradient;
        solve(context, &factor, &is_unseen, &mut step);
        Some(Self {
            step,
            is_unseen,
            errors: errors.to_vec(),
            point: point.clone(),
            system,
            factor,
        })
    }

    /// What a row of the constraints adds to its value on the way that is left.
    pub(super) fn ahead(&self, derivative: &DVector<f64>) -> f64 {
        derivative.dot(&self.step)
    }

    /// Whether the samples do not depend on an unknown.
    pub(super) fn is_unseen(&self, unknown: usize) -> bool {
        self.is_unseen[unknown]
    }

    /// `H⁻¹ b` in place, of what the objective depends on; zero for the rest.
    pub(super) fn solve(&self, context: &SolveContext, b: &mut DVector<f64>) {
        solve(context, &self.factor, &self.is_unseen, b);
    }
}

/// The system at a point without goals that have a weight, given that with them.
fn without_wishes(context: &SolveContext, point: &Point, system: &System) -> System {
    if context.problem.conditions.iter().any(|of| of.is_soft()) {
        context.evaluated(&Guidance::without_wishes(), point)
    } else {
        system.clone()
    }
}

/// The unknowns on which the samples do not depend.
fn unseen(context: &SolveContext, system: &System) -> Vec<bool> {
    let pattern = &context.structure().pattern;
    let diagonal = (0..pattern.size()).map(|at| system.hessian.get(pattern, at, at));
    let mut is_unseen: Vec<bool> = diagonal.map(|entry| entry == 0.0).collect();
    for event in context.layout.events.iter().flatten() {
        is_unseen[*event] = true;
    }
    is_unseen
}

fn solve(context: &SolveContext, factor: &Envelope, is_unseen: &[bool], b: &mut DVector<f64>) {
    let clear = |b: &mut DVector<f64>| {
        for (entry, is_unseen) in b.iter_mut().zip(is_unseen) {
            if *is_unseen {
                *entry = 0.0;
            }
        }
    };
    clear(b);
    factor.solve(&context.structure().pattern, b);
    // Marks couple times of events with those of samples.
    clear(b);
}

/// The factorised Hessian of the objective, damped by rounding so that unknowns on which it does
/// not depend stay.
fn damped(context: &SolveContext, system: &System) -> Option<Envelope> {
    let pattern = &context.structure().pattern;
    let mut matrix = system.hessian.clone();
    for row in 0..pattern.size() {
        let diagonal = matrix.get(pattern, row, row);
        let damping = if diagonal == 0.0 {
            1.0
        } else {
            DAMPING * diagonal
        };
        matrix.add(pattern, row, row, damping);
    }
    matrix.factorise(pattern).ok()?;
    Some(matrix)
}
