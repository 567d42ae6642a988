//! A problem on nodes that are given, to compare numbers of them.

use super::grow::{Grown, Growth, KICK_RAD_S, Legs, grown, growth};
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
const GROWTH: Growth = growth(1.5, Legs::Given, KICK_RAD_S);

/// From where a problem is solved on its own nodes.
pub enum Start {
    /// A state at the beginning, from which the part of the sketch that counts grows.
    Grown(TreeState),
    /// A state at each node.
    Nodes(Vec<TreeState>),
}

/// Solves a problem on the very nodes that it says, from one start: where that leads to nothing, nothing else is tried.
pub fn solve_on_nodes(problem: &TreeProblem, start: Start, observer: &mut dyn Observer) -> Solved {
    let mut work = Work::default();
    let led = match start {
        Start::Grown(state) => grown(
            problem,
            state,
            GROWTH,
            &mut Random::default(),
            &mut work,
            observer,
        ),
        Start::Nodes(states) => {
            let mut problem = problem.clone();
            let point = TreePoint::new(&problem, states);
            problem.step_s = problem.step_for(&point, problem.span_s[1], ROUGHLY);
            Grown {
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
