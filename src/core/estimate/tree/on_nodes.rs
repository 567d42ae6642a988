//! A problem on nodes that are given, to compare numbers of them.

use super::continuation::{
    Continuation, Continued, Intervals, KICK_RAD_S, continuation, continued,
};
use super::optimum::{Solved, finished};
use super::point::TreePoint;
use super::problem::TreeProblem;
use super::solve::swept;
use super::walk::ROUGHLY;
use crate::math::random::Random;
use crate::motion::Observer;
use crate::optimise::{Schedule, Work};
use crate::physics::tree::TreeState;

/// How the part of the sketch that counts grows.
const CONTINUATION: Continuation = continuation(1.5, Intervals::Given, KICK_RAD_S);

/// From where a problem is solved on its own nodes.
pub enum Start {
    /// A state at the beginning, from which the part of the sketch that counts grows.
    Continued(TreeState),
    /// A state at each node.
    Nodes(Vec<TreeState>),
}

/// Solves a problem on the very nodes that it says, from one start: where that leads to nothing, nothing else is tried.
pub fn solve_on_nodes(problem: &TreeProblem, start: Start, observer: &mut dyn Observer) -> Solved {
    let mut work = Work::default();
    let led = match start {
        Start::Continued(state) => continued(
            problem,
            state,
            CONTINUATION,
            &mut Random::default(),
            &mut work,
            observer,
        ),
        Start::Nodes(states) => {
            let mut problem = problem.clone();
            let point = TreePoint::new(&problem, states);
            problem.step_s = problem.step_for(&point, problem.span_s[1], ROUGHLY);
            Continued {
                problem,
                point,
                is_lost: false,
            }
        }
    };
    let (problem, point) = swept(led, &mut work, observer);
    let at_once = Schedule::default().from_the_last();
    finished(&problem, &point, &at_once, &mut work, observer)
}
