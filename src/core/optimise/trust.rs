//! Composite steps in a trust region, for programs of few unknowns whose constraints leave directions free
//! that the cost determines weakly: along them the Gauss–Newton model holds only near by, and a valley's
//! floor is curved (Nocedal and Wright, *Numerical Optimization*, section 18.5).
//!
//! ```text
//! normal       d_n = −C⁺ c,                                        |d_n| ≤ 4Δ
//! tangential   min ½ zᵀ ZᵀHZ z + (g + H d_n)ᵀ Z z,                 |z| ≤ Δ,   C Z = 0
//! accepted where the ℓ₁ merit f + μ Σ |c| falls as the model says,  μ = 2 max |ν|
//! ```
//!
//! in units of [`Program::damping`]. Rows act that are equalities, are violated, or would be by the step; one
//! that is within its bounds is let go when its multiplier pulls inwards. Steps come near the optimum; [the
//! finish](super::finish) decides that it is one.

mod model;
#[cfg(test)]
mod tests;

use nalgebra::DVector;

use super::program::Program;
use super::system::{Structure, System};
use super::work::Work;
use model::Model;

/// Shares of the predicted decrease above which the radius grows, below which it shrinks, and below which a
/// step is led back to the constraints.
const GOOD: f64 = 0.7;
const POOR: f64 = 0.25;
const LED_BACK: f64 = 0.9;
/// Factors on the radius.
const GROW: f64 = 3.0;
const SHRINK: f64 = 0.5;
/// Least share of the predicted decrease of a step that is taken.
const LEAST: f64 = 1e-4;
/// Steps are slow that, after so many, predict more than this share of what the one before predicted: the
/// curvature of constraints and residuals is then added.
const SLOW_STEPS: usize = 5;
const SLOW: f64 = 0.3;
/// How often a step is told again with rows that it would violate.
const HELD_ROUNDS: usize = 3;
/// Least radius, of the first: what is gained there is rounding.
const LEAST_RADIUS: f64 = 1e-8;

/// When steps end.
#[derive(Clone, Copy, Debug)]
pub struct Nearness {
    /// Greatest number of steps.
    pub steps: usize,
    /// They end where a step predicts less of the cost,
    pub decrease: f64,
    /// and no row is violated by more, in units.
    pub violation: f64,
}

/// Where steps led.
pub struct Near<T> {
    /// Values of all unknowns.
    pub point: T,
    /// Work done.
    pub work: Work,
}

/// Takes steps from a point until the model predicts nearly nothing, none lowers the merit, or numbers are not finite.
pub fn approach<P: Program>(
    program: &P,
    start: P::Point,
    guidance: &P::Guidance,
    nearness: &Nearness,
    should_stop: &mut dyn FnMut(usize) -> bool,
) -> Near<P::Point> {
    let mut point = start;
    let mut system = program.evaluated(guidance, &point);
    let mut work = Work {
        evaluations: 1,
        ..Work::default()
    };
    let (mut trial, mut there) = (point.clone(), system.clone());
    let scale = program.damping().map(|weight| weight.sqrt().recip());
    // One typical length of one unknown.
    let first = (10.0 * program.information().0).sqrt();
    let mut radius = first;
    let mut multipliers = vec![0.0; system.row_count()];
    let mut held = vec![false; system.row_count()];
    let (mut is_slow, mut last) = (false, f64::INFINITY);
    'steps: for number in 0..nearness.steps {
        if should_stop(program.iteration_work(&point).plain) {
            break;
        }
        let mut hessian = system.hessian.clone();
        if is_slow {
            program.add_curvature((&point, &system), &multipliers, &mut hessian);
        }
        let Some(mut model) = Model::new(program, &system, &hessian, &scale, &held) else {
            break;
        };
        let mut step = model.step(radius);
        for _ in 0..HELD_ROUNDS {
            let delta = step.delta.component_mul(&scale);
            if !hold_crossed(program.structure(), &system, &delta, &mut held) {
                break;
            }
            let Some(holding) = Model::new(program, &system, &hessian, &scale, &held) else {
                break 'steps;
            };
            model = holding;
            step = model.step(radius);
        }
        is_slow |= number >= SLOW_STEPS && step.predicted > SLOW * last;
        last = step.predicted;
        work.iterations += 1;
        work.factorisations += 1;
        if step.predicted <= nearness.decrease * system.cost
            && system.violation() <= nearness.violation
        {
            break;
        }
        let merit = |system: &System| system.cost + step.price * system.total_violation();
        let before = merit(&system);
        let mut share = f64::NEG_INFINITY;
        let mut delta = step.delta.clone();
        for is_led_back in [false, true] {
            program.retract(&point, &delta.component_mul(&scale), &mut trial);
            program.try_out(guidance, &trial, &mut there);
            work.evaluations += 1;
            share = (before - merit(&there)) / step.predicted;
            if is_led_back || !(share < LED_BACK) {
                break;
            }
            delta -= &model.inverse * model.acting(&there);
        }
        multipliers.fill(0.0);
        for (row, multiplier) in model.rows.iter().zip(step.multipliers.iter()) {
            multipliers[row.number] = *multiplier;
            held[row.number] = row.side * multiplier > 0.0;
        }
        if share > LEAST {
            program.differentiate(guidance, &trial, &mut there);
            std::mem::swap(&mut point, &mut trial);
            std::mem::swap(&mut system, &mut there);
        }
        if share > GOOD && step.is_at_border {
            radius *= GROW;
        } else if !(share >= POOR) {
            radius = SHRINK * radius.min(step.delta.norm());
        }
        if radius < LEAST_RADIUS * first {
            break;
        }
    }
    Near { point, work }
}

/// Holds the rows within their bounds that a step would lead out of them; whether there are new ones.
fn hold_crossed(
    structure: &Structure,
    system: &System,
    delta: &DVector<f64>,
    held: &mut [bool],
) -> bool {
    let mut change = Vec::new();
    system.along(structure, delta, &mut change);
    let rows = system.blocks.iter().flat_map(|block| {
        let bounds = block.bounds.iter().enumerate();
        bounds.map(|(row, bounds)| (block.values[row], *bounds, block.acts(row)))
    });
    let mut is_new = false;
    for (((value, (lower, upper), acts), change), held) in rows.zip(change).zip(held) {
        let to = value + change;
        if !acts && !*held && (to < lower || to > upper) {
            *held = true;
            is_new = true;
        }
    }
    is_new
}
