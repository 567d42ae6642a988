//! A lower bound of what a part of a performance costs at the least, for the search over
//! collision sequences.
//!
//! For any multipliers `ν` and weight `w` the least value of the augmented Lagrangian, less
//! `½ Σ ν²/w`, is at most the constrained optimum: where the constraints hold, its terms
//! `½ w dist²(v + ν/w)` are at most `½ ν²/w`. Multipliers from a round or two make it tight. It
//! takes no finish, so it is cheap and never fails. Leaving out arcs, and the terms and conditions
//! that tie them, lowers it further: what is left out is never negative.
//!
//! As the descent finds a local minimum it is a bound for what the estimation would find from
//! the same guess, and no proof beyond.

use super::constraint::Block;
use super::descend::{Descent, Patience};
use super::layout::Layout;
use super::merit::Price;
use super::point::Point;
use super::problem::{Problem, VELOCITY_GAP_WEIGHT};
use super::recipe::{self, Recipe};
use super::system::{Frame, Guidance};
use crate::motion::{ArcGuess, Counters, Guess, Scene, Segment, Sketch, VelocityGaps};

/// Rounds of multipliers.
const ROUNDS: usize = 2;
/// Steps of a round at most.
const STEPS: usize = 25;
/// A round ends when a step gains less than this share of the recipe's gain.
const GAIN: f64 = 0.01;

/// A lower bound and what it took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// Half the sum of squared residuals, at least.
    pub cost: f64,
    /// Work done.
    pub counters: Counters,
}

/// The bound of the arcs of `segments` (indices into `all`), with those collisions that tie two
/// of them and whose contacts the scene knows. `guess` has an arc for each of `all`.
///
/// `own_priors` says whether priors of parameters count: in a sum of bounds they may only once.
///
/// # Panics
/// Where two of the arcs meet at a collision that is open, or without an arc.
pub fn bound(
    scene: &Scene,
    sketch: &Sketch,
    (all, segments): (&[Segment], &[usize]),
    guess: &Guess,
    own_priors: bool,
) -> Bound {
    let part: Vec<Segment> = segments.iter().map(|index| all[*index].clone()).collect();
    let arcs: Vec<ArcGuess> = segments.iter().map(|i| guess.arcs[*i].clone()).collect();
    let guess = &Guess {
        arcs,
        event_times_s: guess.event_times_s.clone(),
        parameters: guess.parameters.clone(),
    };
    let mut problem = Problem::new(scene, sketch, &part);
    for (event, is_free) in problem.event_is_free.iter_mut().enumerate() {
        let bounds_an_arc =
            |arc: &super::problem::Arc| arc.start == Some(event) || arc.end == Some(event);
        *is_free &= problem.arcs.iter().any(bounds_an_arc);
    }
    if !own_priors {
        for free in &mut problem.parameters {
            free.prior_sd = None;
        }
    }
    if scene.velocity_gaps == VelocityGaps::Always {
        // The price is that of the whole performance.
        let samples = |of: &[Segment]| {
            let count: usize = of.iter().map(|segment| segment.samples.len()).sum();
            count as f64 / of.len() as f64
        };
        let information = problem.information() * samples(all) / samples(&part);
        problem.velocity_gap_weight = Some(VELOCITY_GAP_WEIGHT * information);
    }
    let layout = Layout::new(&problem);
    let start = Point::new(&problem, guess);
    let frame = Frame::new(&problem, &layout, recipe::epochs_s(guess), &start);
    least(&problem, guess, &frame, start)
}

fn least(problem: &Problem, guess: &Guess, frame: &Frame, start: Point) -> Bound {
    let recipe = Recipe::default().scaled(problem.information());
    let mut guidance = recipe::leading(problem, guess, frame, &start);
    guidance.orientations_per_arc = recipe.orientations_per_arc;
    if !problem.times_are_unknown() {
        guidance.event_sd_s = Some(recipe.event_sd_s * 10f64.sqrt());
    }
    let mut descent = Descent::new(frame, &guidance, start);
    let is_tied = descent
        .system
        .blocks
        .iter()
        .any(|b: &Block| !b.values.is_empty());
    if is_tied {
        let mut price = Price::new(&descent.system, recipe.sweep_weights[0]);
        price.approach_weight = price.weight.max(recipe.multiplier_weight / 10.0);
        let patience = Patience {
            steps: recipe.sweep_steps,
            gain: recipe.gain,
        };
        descent.run(&guidance, &price, patience);
    }
    let exact = Guidance::none(problem);
    descent.refresh(&exact);
    let mut price = Price::new(&descent.system, recipe.multiplier_weight);
    let patience = Patience {
        steps: STEPS,
        gain: GAIN * recipe.gain,
    };
    let mut cost: f64 = 0.0;
    for _ in 0..if is_tied { ROUNDS } else { 1 } {
        descent.run(&exact, &price, patience);
        // One step more would gain less than the patience; what it could is taken off.
        let value = price.dual(&descent.system) - patience.gain;
        if value.is_finite() {
            cost = cost.max(value);
        }
        price.update(&descent.system);
    }
    Bound {
        cost,
        counters: descent.counters,
    }
}
