//! One of several problems that differ in what touches at their events: solved as far as it may be the best of them.

use super::continuation::Continued;
use super::modes::walked;
use super::optimum::{Solved, finished};
use super::part::Part;
use super::problem::TreeProblem;
use super::program::TreeProgram;
use super::solve::{CONTINUATIONS, in_one, likeliest, swept};
use crate::math::random::Random;
use crate::motion::Observer;
use crate::optimise::{Program, Schedule, Work};
use crate::physics::tree::TreeState;

/// A motion is worse that is near to what touches and to the goals, and whose samples cost so many times what they do in the
/// best one.
const WORSE: f64 = 4.0;
/// How near it is then, in units.
const NEARLY: f64 = 1e-3;
/// Valleys are walked along of what costs at most so many times as much as the best.
const NEAR: f64 = 1.5;

/// Where the solution of such a problem led.
pub enum RivalOutcome {
    /// To an optimum.
    Solved(Box<Solved>),
    /// To what costs much more than the best.
    Worse,
    /// To nothing.
    Lost,
}

/// Solves such a problem as another one is that names what touches, but growing once, and where that leads to nothing, or to
/// what is much worse, from the motion of the best of the others. What is four times worse after steps in a trust region is not
/// followed to its optimum.
pub fn rival(
    problem: &TreeProblem,
    starts: &[(f64, TreeState)],
    best: Option<&Solved>,
    observer: &mut dyn Observer,
) -> RivalOutcome {
    let mut work = Work::default();
    let given = &*problem.given();
    let times = |share: f64| best.map_or(f64::INFINITY, |best| share * best.cost());
    let random = &mut Random::default();
    let mut ways = likeliest(
        given,
        starts,
        CONTINUATIONS[0],
        random,
        &mut None,
        &mut work,
        observer,
    );
    let (mut is_worse, mut is_lost) = (false, false);
    let mut warm = best;
    loop {
        let (there, point) = match (ways.is_empty(), warm.take()) {
            (false, kept) => {
                warm = kept;
                ways.remove(0)
            }
            (true, Some(best)) => swept(moved(given, best), &mut work, observer),
            (true, None) => break,
        };
        let program = TreeProgram::new(&there, point.clone());
        let near = program.evaluated(&Part::whole(), &point);
        if near.cost > times(WORSE) && near.violation() <= NEARLY {
            is_worse = true;
            continue;
        }
        let at_once = Schedule::default().from_the_last();
        let solved = finished(&there, &point, &at_once, &mut work, observer);
        if !solved.solution.finished.converged || solved.is_far() {
            is_lost = true;
            continue;
        }
        let mut solved = in_one(solved, &mut work, observer);
        if solved.cost() <= times(NEAR) {
            solved = walked(solved, &mut work, observer);
        }
        return RivalOutcome::Solved(Box::new(solved.let_go(problem, observer)));
    }
    match is_worse && !is_lost && !observer.should_stop() {
        true => RivalOutcome::Worse,
        false => RivalOutcome::Lost,
    }
}

/// The motion of another problem, with what touches in this one.
fn moved(problem: &TreeProblem, from: &Solved) -> Continued {
    let mut again = from.problem.clone();
    for (event, other) in again.events.iter_mut().zip(&problem.events) {
        event.touch.clone_from(&other.touch);
    }
    again.goals.clone_from(&problem.goals);
    Continued {
        problem: again,
        point: from.solution.point.clone(),
        is_lost: false,
    }
}
