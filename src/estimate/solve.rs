//! The stage as the pipeline sees it: guesses in, an estimate out.

use super::layout::Layout;
use super::outcome;
use super::point::Point;
use super::problem::Problem;
use super::recipe::{self, Recipe, Solution};
use super::system::Frame;
use crate::motion::{Counters, Estimate, Guess, Observer, Phase, Scene, Segment, Sketch};

/// Solves from each guess and keeps the best: the lowest objective of those that converged.
///
/// There is one guess unless the arcs' own fits are ambiguous, so a clear performance costs one
/// solve. Fails never; what did not converge has the verdict that says so.
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
    let problem = Problem::new(scene, sketch, segments);
    let layout = Layout::new(&problem);
    let (best, solution) = best(&problem, &layout, guesses, recipe, observer);
    observer.phase(Phase::Covariance);
    let epochs_s = recipe::epochs_s(&guesses[best]);
    let frame = Frame::new(
        &problem,
        &layout,
        epochs_s,
        &Point::new(&problem, &guesses[best]),
    );
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
    let mut counters = Counters::default();
    for (index, guess) in guesses.iter().enumerate() {
        let solution = recipe::solve(problem, layout, guess, recipe, observer);
        counters.iterations += solution.counters.iterations;
        counters.evaluations += solution.counters.evaluations;
        counters.factorisations += solution.counters.factorisations;
        counters.starts += 1;
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
    solution.counters = counters;
    (index, solution)
}
