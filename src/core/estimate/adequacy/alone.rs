//! Every flight by itself: the minimum of the objective without constraints and without goals that have
//! a weight, which are wishes and no measurements. Times of events, which then depend on nothing but
//! their marks, stay.

use nalgebra::DVector;

use crate::estimate::covariance::residuals::Residuals;
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

/// Residuals of all samples of the flights by themselves, arc by arc, in units: without all constraints of a solution; `None`
/// where the Hessian cannot be factorised.
pub(super) fn errors_alone(
    context: &SolveContext,
    point: &Point,
    system: &System,
) -> Option<Vec<Residuals>> {
    let (mut point, mut system) = (point.clone(), without_wishes(context, point, system));
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
    Some(outcome::errors(context.problem, context, &point))
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
