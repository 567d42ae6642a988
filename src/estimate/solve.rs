//! The stage as the pipeline sees it: guesses in, an estimate out.

use super::layout::Layout;
use super::outcome;
use super::point::Point;
use super::problem::Problem;
use super::recipe::{self, Recipe, Solution};
use super::system::Frame;
use crate::motion::{
    Counters, Estimate, Guess, Observer, Phase, Scene, Segment, Sketch, VelocityGaps,
};

/// Price of a squared unit of velocity gap against that of a squared residual, per
/// [`Problem::information`]: a gap is worth a hundred times what a sample's misfit of one unit is,
/// so that the motion bends to the performance no more than it must.
pub(super) const VELOCITY_GAP_WEIGHT: f64 = 100.0;

/// Solves from each guess and keeps the best: the lowest objective of those that converged.
///
/// There is one guess unless the arcs' own fits are ambiguous, so a clear performance costs one
/// solve. Where no motion meets all conditions, velocities may jump at collisions, if the scene
/// allows it. Fails never; what did not converge has the verdict that says so.
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
    let mut problem = Problem::new(scene, sketch, segments);
    let layout = Layout::new(&problem);
    let is_hopeless = problem.is_overconstrained();
    let mut work = Counters::default();
    let mut found = None;
    if scene.velocity_gaps == VelocityGaps::Never
        || scene.velocity_gaps == VelocityGaps::WhenNeeded && !is_hopeless
    {
        let (best, solution) = best(&problem, &layout, guesses, recipe, observer);
        work.add(&solution.counters);
        found = Some((best, solution));
    }
    let is_enough = |(_, solution): &(usize, Solution)| {
        solution.finished.converged
            || solution.stopped
            || scene.velocity_gaps == VelocityGaps::Never
            || problem.collisions.is_empty()
    };
    if !found.as_ref().is_some_and(is_enough) {
        problem.velocity_gap_weight = Some(VELOCITY_GAP_WEIGHT * problem.information());
        let (best, solution) = best(&problem, &layout, guesses, recipe, observer);
        work.add(&solution.counters);
        found = Some((best, solution));
    }
    let (best, mut solution) = found.expect("solved one way or the other");
    solution.counters = work;
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
