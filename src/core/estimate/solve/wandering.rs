//! A motion whose samples err in time: solved again with the errors that are expected of a hand, then with those that its
//! residuals make likely.

use super::Posed;
use crate::estimate::covariance::linearised::{LinearisedSolution, free_directions};
use crate::estimate::schedule::recipe::{self, Recipe, Solution};
use crate::estimate::wander::{Process, process};
use crate::motion::Observer;
use crate::optimise::Work;
use crate::optimise::kkt::Kkt;

/// How often errors are told from residuals.
const ROUNDS: usize = 3;
/// Errors are told well where no logarithm of their sizes and times changes by more.
const SAME: f64 = 0.05;

/// The solution with the likeliest errors, and its problem; `None` where times are unknown, where velocities jump, where the
/// motion is no optimum and where that leads to none.
pub(super) fn refined(
    posed: &Posed,
    solution: &Solution,
    epochs_s: &[f64],
    observer: &mut dyn Observer,
) -> Option<(Posed, Solution)> {
    let is_bent = posed.problem.velocity_gap_weight.is_some();
    if is_bent || posed.problem.times_are_unknown() || !solution.finished.converged {
        return None;
    }
    let mut processes = [Process::EXPECTED; 2];
    let mut best: Option<(Posed, Solution)> = None;
    let mut work = Work::default();
    for _ in 0..=ROUNDS {
        if observer.should_stop() {
            break;
        }
        let from = best.as_ref().map_or(solution, |(_, solution)| solution);
        let woven = Posed::new(posed.problem.woven(processes, &from.point.event_times_s));
        let found = recipe::solve_from(
            &woven.problem,
            &woven.layout,
            from.point.clone(),
            epochs_s.to_vec(),
            &Recipe::default().from_the_last(),
            observer,
        );
        work.add(&found.work);
        if !found.finished.converged {
            break;
        }
        let likely = likely(&woven, &found, epochs_s, &processes);
        best = Some((woven, found));
        let Some(likely) = likely else { break };
        let is_same = process::change(&processes, &likely) < SAME;
        processes = likely;
        if is_same {
            break;
        }
    }
    best.map(|(posed, solution)| (posed, Solution { work, ..solution }))
}

/// The errors that a motion's residuals make likeliest; `None` where they tell nothing of them.
fn likely(
    posed: &Posed,
    solution: &Solution,
    epochs_s: &[f64],
    from: &[Process; 2],
) -> Option<[Process; 2]> {
    let (point, system) = (&solution.point, &solution.system);
    let context = posed.context(epochs_s.to_vec(), point);
    let kkt = Kkt::new(&context, system, &solution.multipliers)?;
    let free = free_directions(&context, system, &kkt)?;
    let linearised = LinearisedSolution::new(&context, point, system, &free, free.ncols())?;
    Some(linearised.restricted().fitted(from)?.processes)
}
