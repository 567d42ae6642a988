//! A motion whose samples err in time: solved with the errors that are expected, then again with those that its residuals
//! make likely.

use super::adequacy::linearised::Linearised;
use super::optimum::{Solved, finished};
use super::point::TreePoint;
use super::problem::TreeProblem;
use super::solve::solve;
use crate::estimate::wander::Process;
use crate::estimate::wander::process;
use crate::motion::Observer;
use crate::optimise::Schedule;
use crate::physics::tree::TreeState;

/// How often errors are told from residuals.
const ROUNDS: usize = 3;
/// Errors are told well where no logarithm of their sizes and times changes by more.
const SAME: f64 = 0.02;

/// Solves a problem as [`solve`] does, and where samples err in time again with the likeliest errors. A motion that is no
/// optimum stays as it was found.
pub fn solved(
    problem: &TreeProblem,
    starts: &[(f64, TreeState)],
    observer: &mut dyn Observer,
) -> Solved {
    refined(solve(problem, starts, observer), observer)
}

/// The same motion with the likeliest errors.
fn refined(mut solved: Solved, observer: &mut dyn Observer) -> Solved {
    for _ in 0..ROUNDS {
        let Some(errors) = solved.problem.errors else {
            break;
        };
        if !solved.solution.finished.converged || observer.should_stop() {
            break;
        }
        let Some(likely) = likely(&solved, &errors) else {
            break;
        };
        let is_same = process::change(&errors, &likely) < SAME;
        let again = with(&solved, likely, observer);
        if !again.solution.finished.converged {
            break;
        }
        solved = again;
        if is_same {
            break;
        }
    }
    solved
}

/// The errors that a motion's residuals make likeliest.
fn likely(solved: &Solved, from: &[Process; 2]) -> Option<[Process; 2]> {
    let linearised = Linearised::new(&solved.problem, &solved.solution)?;
    Some(linearised.fitted(from)?.processes)
}

/// The optimum near by with other errors.
fn with(solved: &Solved, errors: [Process; 2], observer: &mut dyn Observer) -> Solved {
    let problem = TreeProblem {
        errors: Some(errors),
        ..solved.problem.clone()
    };
    let at_once = Schedule::default().from_the_last();
    let point: &TreePoint = &solved.solution.point;
    let mut work = solved.solution.work;
    finished(&problem, point, &at_once, &mut work, observer)
}
