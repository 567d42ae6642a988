//! The program's recipe over any grid's unknowns: sweep, multipliers, finish; the same weights,
//! rounds and ends.

use enact::estimate::collision;
use enact::estimate::finish::{Finished, Tolerances};
use enact::estimate::merit::AugmentedLagrangian;
use enact::estimate::problem::Problem;
use enact::estimate::recipe::Recipe;
use enact::estimate::system::{Guidance, System};

use super::descent::Descent;
use super::finish::Finish;
use super::model::Model;
use super::setting::Place;

/// A violation that the greatest weight leaves only where there is nothing better, in units.
const HOPELESS: f64 = 1.0;
const STALLED: f64 = 0.8;
const STALLED_ROUNDS: usize = 2;
const SWEEP_RATIO: f64 = 30.0;

/// Where a solve ended.
pub struct End {
    /// All unknowns.
    pub place: Place,
    /// Within tolerances, by its own account.
    pub converged: bool,
    /// Factorisations.
    pub iterations: usize,
}

/// Solves from a place, by a recipe whose tolerances are those.
pub fn solve(model: &mut Model, start: Place, usual: &Recipe, tolerances: &Tolerances) -> End {
    if !start.exists {
        return End {
            place: start,
            converged: false,
            iterations: 0,
        };
    }
    let problem = model.outer.problem;
    let information = problem.information();
    let recipe = &scaled(usual, problem);
    let mut guidance = leading(model);
    guidance.orientations_per_arc = recipe.orientations_per_arc;
    let mut descent = Descent::new(model, start);
    for weight in &recipe.sweep_weights {
        if !problem.times_are_unknown() {
            let loosened = (weight / information).log10().max(0.0);
            guidance.event_sd_s = Some(recipe.event_sd_s * 10f64.powf(0.5 * loosened));
        }
        descent.refresh(&guidance);
        let mut lagrangian = AugmentedLagrangian::new(&descent.system, *weight);
        lagrangian.approach_weight = weight.max(100.0 * information);
        descent.run(&guidance, &lagrangian, (recipe.sweep_steps, recipe.gain));
    }
    let coarse = Guidance {
        orientations_per_arc: recipe.orientations_per_arc,
        ..Guidance::none(problem)
    };
    descent.refresh(&coarse);
    let mut lagrangian = AugmentedLagrangian::new(&descent.system, recipe.multiplier_weight);
    tighten(&mut descent, &coarse, &mut lagrangian, recipe);
    let exact = Guidance::none(problem);
    descent.refresh(&exact);
    let (place, system, mut iterations) = (descent.place, descent.system, descent.iterations);
    let mut at = (place, system, lagrangian.multipliers.clone());
    let mut finished = conclude(
        model,
        &mut at,
        lagrangian.weight,
        recipe,
        tolerances,
        &mut iterations,
    );
    // Who asks for no finish gets none.
    let retries = if tolerances.steps > 0 {
        recipe.retries
    } else {
        0
    };
    for retry in 0..retries {
        if finished.converged || retry > 0 && finished.decrease.is_infinite() {
            break;
        }
        let mut descent = Descent::new(model, at.0);
        descent.refresh(&exact);
        let mut lagrangian = AugmentedLagrangian::new(&descent.system, recipe.multiplier_weight);
        lagrangian.multipliers = at.2;
        let patient = Recipe {
            gain: 1e-7 * recipe.gain,
            finish_below: 1e-5,
            ..recipe.clone()
        };
        tighten(&mut descent, &exact, &mut lagrangian, &patient);
        iterations += descent.iterations;
        at = (
            descent.place,
            descent.system,
            lagrangian.multipliers.clone(),
        );
        finished = conclude(
            model,
            &mut at,
            lagrangian.weight,
            recipe,
            tolerances,
            &mut iterations,
        );
    }
    End {
        place: at.0,
        converged: finished.converged,
        iterations,
    }
}

fn conclude(
    model: &mut Model,
    at: &mut (Place, System, Vec<f64>),
    weight: f64,
    recipe: &Recipe,
    tolerances: &Tolerances,
    iterations: &mut usize,
) -> Finished {
    if at.1.violation() > HOPELESS && weight >= 100.0 * recipe.multiplier_weight {
        return Finished {
            converged: false,
            violation: at.1.violation(),
            decrease: f64::INFINITY,
        };
    }
    let mut finish = Finish {
        model,
        place: at.0.clone(),
        system: at.1.clone(),
        multipliers: at.2.clone(),
        iterations: 0,
    };
    let finished = finish.run(tolerances);
    *iterations += finish.iterations;
    *at = (finish.place, finish.system, finish.multipliers);
    finished
}

fn tighten(
    descent: &mut Descent,
    guidance: &Guidance,
    lagrangian: &mut AugmentedLagrangian,
    recipe: &Recipe,
) {
    let (rounds, steps) = recipe.multiplier_rounds;
    let weight_max = 100.0 * recipe.multiplier_weight;
    let mut violation = f64::INFINITY;
    let mut stalled = 0;
    for _ in 0..rounds {
        descent.run(guidance, lagrangian, (steps, recipe.gain));
        lagrangian.update(&descent.system);
        let now = descent.system.violation();
        let is_stalled = now > STALLED * violation && lagrangian.weight >= weight_max;
        stalled = if is_stalled { stalled + 1 } else { 0 };
        if now < recipe.finish_below || now > HOPELESS && stalled >= STALLED_ROUNDS {
            break;
        }
        if now > 0.25 * violation {
            lagrangian.weight = (lagrangian.weight * 10.0).min(weight_max);
            lagrangian.approach_weight = lagrangian.weight;
        }
        violation = now;
    }
}

/// The recipe for a problem with as much information.
fn scaled(recipe: &Recipe, problem: &Problem) -> Recipe {
    let (least, most) = (problem.least_information(), problem.information());
    let between = ((most / least).log(SWEEP_RATIO).ceil() as i32).max(0);
    let levels = (0..=between).map(|level| (least * SWEEP_RATIO.powi(level)).min(most));
    let weights = &recipe.sweep_weights;
    Recipe {
        sweep_weights: levels
            .flat_map(|level| weights.iter().map(move |weight| weight * level))
            .collect(),
        gain: recipe.gain * least,
        event_sd_s: recipe.event_sd_s / most.sqrt(),
        multiplier_weight: recipe.multiplier_weight * most,
        ..recipe.clone()
    }
}

/// Contacts approach at least at three tenths of the speed of the arcs' own fits; events are pulled
/// to their marks.
fn leading(model: &Model) -> Guidance {
    let (frame, fits) = model.fits();
    let problem = frame.problem;
    let mut guidance = Guidance::none(problem);
    guidance.event_times_s = fits.event_times_s.clone();
    for (index, of) in problem.collisions.iter().enumerate() {
        let fastest_m_s = collision::fastest_approach_m_s(problem, of, fits, &frame.epochs_s);
        guidance.approach_limits_m_s[index] = (0.3 * fastest_m_s).min(-0.1);
    }
    guidance
}
