//! The stage as the pipeline sees it: guesses in, an estimate out.

use super::layout::Layout;
use super::outcome;
use super::point::Point;
use super::problem::Problem;
use super::recipe::{self, Recipe, Solution};
use super::system::{Frame, Guidance, System};
use crate::motion::{
    Counters, Estimate, Guess, Observer, Phase, Scene, Segment, Sketch, VelocityGaps,
};

/// Solves from each guess and keeps the best: the lowest objective of those that converged.
///
/// There is one guess unless the arcs' own fits are ambiguous, so a clear performance costs one
/// solve. Where that finds no motion, and the scene allows it, velocities may jump at collisions;
/// from the motion found then it is tried once more to close the gaps. Fails never; what did not
/// converge has the verdict that says so.
///
/// # Panics
/// Without a guess or without a segment.
pub fn estimate(
    scene: &Scene,
    sketch: &Sketch,
    segments: &[Segment],
    guesses: &[Guess],
    recipe: &Recipe,
    observer: &mut dyn Observer,
) -> Estimate {
    let exact = Problem::new(scene, sketch, segments);
    let exact_layout = Layout::new(&exact);
    let may_bend = scene.velocity_gaps != VelocityGaps::Never && !exact.collisions.is_empty();
    let is_hopeless = scene.velocity_gaps == VelocityGaps::Always || exact.is_overconstrained();
    let bent = exact.bent();
    let bent_layout;

    let mut work = Counters::default();
    let mut found = None;
    if !(may_bend && is_hopeless) {
        let (best, solution) = best(&exact, &exact_layout, guesses, recipe, observer);
        work.add(&solution.counters);
        found = Some(((&exact, &exact_layout), best, solution));
    }
    let is_final = |s: &Solution| s.finished.converged || s.stopped || !may_bend;
    if !found
        .as_ref()
        .is_some_and(|(_, _, solution)| is_final(solution))
    {
        bent_layout = Layout::new(&bent);
        let (best, solution) = best(&bent, &bent_layout, guesses, recipe, observer);
        work.add(&solution.counters);
        let again = (!is_hopeless && !solution.stopped).then(|| {
            let guess = solution.point.guess(&exact, &guesses[best]);
            recipe::solve(
                &exact,
                &exact_layout,
                &guess,
                &recipe.without_sweep(),
                observer,
            )
        });
        found = Some(((&bent, &bent_layout), best, solution));
        if let Some(again) = again {
            work.add(&again.counters);
            if again.finished.converged {
                found = Some(((&exact, &exact_layout), best, again));
            }
        }
    }
    let ((problem, layout), best, mut solution) = found.expect("solved one way or the other");
    solution.counters = work;
    observer.phase(Phase::Covariance);
    let epochs_s = recipe::epochs_s(&guesses[best]);
    let start = Point::new(problem, &guesses[best]);
    let frame = Frame::new(problem, layout, epochs_s, &start);
    outcome::estimate(scene, sketch, segments, &frame, &solution)
}

/// The best solution, the index of the guess it came from, and the work of all.
pub fn best(
    problem: &Problem,
    layout: &Layout,
    guesses: &[Guess],
    recipe: &Recipe,
    observer: &mut dyn Observer,
) -> (usize, Solution) {
    let mut best: Option<(usize, Solution)> = None;
    let mut work = Counters::default();
    for (index, guess) in guesses.iter().enumerate() {
        let solution = recipe::solve(problem, layout, guess, recipe, observer);
        work.add(&solution.counters);
        work.starts += 1;
        let is_better = best.as_ref().is_none_or(|(_, known)| {
            let rank = |s: &Solution| (!s.finished.converged, s.system.cost);
            rank(&solution) < rank(known)
        });
        let stopped = solution.stopped;
        if is_better {
            best = Some((index, solution));
        }
        if stopped {
            break;
        }
    }
    let (index, mut solution) = best.expect("at least one guess");
    solution.counters = work;
    (index, solution)
}

/// Half the sum of squared residuals of a guess, priors included, whatever its constraints say.
pub fn cost(scene: &Scene, sketch: &Sketch, segments: &[Segment], guess: &Guess) -> f64 {
    let problem = Problem::new(scene, sketch, segments);
    let layout = Layout::new(&problem);
    let start = Point::new(&problem, guess);
    let frame = Frame::new(&problem, &layout, recipe::epochs_s(guess), &start);
    let mut system = System::new(&frame);
    system.evaluate(&frame, &Guidance::none(&problem), &start);
    system.cost
}
