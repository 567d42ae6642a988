//! A quantity set free for a trial: where its value is far off, the slope at the scene's own no longer ranks it.

use nalgebra::DVector;

use super::candidates::{STEP, change};
use super::linear::{Linear, LinearChange};
use crate::estimate::tree::point::TreePoint;
use crate::estimate::tree::problem::TreeProblem;
use crate::motion::{Quantity, Scene};
use crate::optimise::active::ActiveSet;

/// Greatest number of steps of Gauss and Newton,
const STEPS: usize = 12;
/// and of halvings of one.
const HALVINGS: usize = 4;
/// Steps end where one gains less than this share of the objective.
const GAIN: f64 = 1e-3;
/// Weight of rows that do not hold, per unit and information.
const ROWS: f64 = 1e3;

/// The motion with a quantity at its likely value.
pub(super) struct TriedQuantity {
    pub(super) value: f64,
    pub(super) linear: Linear,
    /// By the quantity, there.
    pub(super) change: LinearChange,
}

/// Moves motion and quantity to where both fit best; `None` where that leads to no motion.
pub(super) fn tried(
    scene: &Scene,
    problem: &TreeProblem,
    point: &TreePoint,
    active: &ActiveSet,
    quantity: Quantity,
) -> Option<TriedQuantity> {
    let [lower, upper] = quantity.limits();
    let step = STEP * quantity.typical();
    let information = problem.information;
    let merit = |of: &Linear| {
        let (cost, off) = of.merit();
        cost + ROWS * information.1 * off
    };
    let mut point = point.clone();
    let mut value = scene.value_of(quantity);
    let mut linear = Linear::new(problem, &point, active)?;
    let mut by = change(scene, problem, &point, active, quantity, value, step)?;
    for _ in 0..STEPS {
        let (delta, off) = linear.step(&by, information.0)?;
        let mut gain = 0.0;
        let mut share = 1.0;
        for _ in 0..=HALVINGS {
            let there_value = (value + share * off).clamp(lower, upper);
            let mut there_point = point.clone();
            let delta: DVector<f64> = &delta * share;
            point.retract(problem, &delta, &mut there_point);
            let there = Linear::new(
                &problem.with(scene, (quantity, there_value))?,
                &there_point,
                active,
            );
            if let Some(there) = there.filter(|there| merit(there) < merit(&linear)) {
                gain = (merit(&linear) - merit(&there)) / merit(&there);
                (point, value, linear) = (there_point, there_value, there);
                break;
            }
            share *= 0.5;
        }
        if gain > 0.0 {
            by = change(scene, problem, &point, active, quantity, value, step)?;
        }
        if gain < GAIN {
            break;
        }
    }
    Some(TriedQuantity {
        value,
        linear,
        change: by,
    })
}
