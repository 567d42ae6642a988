//! The unknowns of the motion of trees.

use nalgebra::DVector;

use super::problem::TreeProblem;
use crate::physics::tree::TreeState;

/// Values of all unknowns. Steps are the tangents of the nodes, one after the other, then the times.
#[derive(Clone, Debug)]
pub struct TreePoint {
    /// States at the nodes.
    pub nodes: Vec<TreeState>,
    /// Times of the events within the motion \[s\].
    pub event_times_s: Vec<f64>,
}

impl TreePoint {
    /// States at the nodes, with events where the problem has them about.
    pub fn new(problem: &TreeProblem, nodes: Vec<TreeState>) -> Self {
        Self {
            nodes,
            event_times_s: problem.events.iter().map(|event| event.about_s).collect(),
        }
    }

    /// `to = self ⊞ step`.
    pub(super) fn retract(&self, problem: &TreeProblem, step: &DVector<f64>, to: &mut Self) {
        let width = problem.width();
        let (states, times) = step.as_slice().split_at(width * self.nodes.len());
        let moved = self.nodes.iter().zip(states.chunks_exact(width));
        for ((from, step), to) in moved.zip(&mut to.nodes) {
            *to = problem.forest.retract(from, step);
        }
        let moved = self.event_times_s.iter().zip(times);
        for ((from_s, step_s), to_s) in moved.zip(&mut to.event_times_s) {
            *to_s = from_s + step_s;
        }
    }

    /// `self ⊟ origin`: the step that leads from there to here.
    pub(super) fn minus(&self, problem: &TreeProblem, origin: &Self) -> DVector<f64> {
        let states = self.nodes.iter().zip(&origin.nodes);
        let states = states.flat_map(|(to, from)| problem.forest.minus(to, from));
        let times = self.event_times_s.iter().zip(&origin.event_times_s);
        let step: Vec<f64> = states.chain(times.map(|(to, from)| to - from)).collect();
        step.into()
    }

    /// Whether all rates and times are finite.
    pub fn is_finite(&self) -> bool {
        let mut rates = self.nodes.iter().flat_map(|state| &state.rates);
        rates.all(|rate| rate.is_finite()) && self.event_times_s.iter().all(|s| s.is_finite())
    }
}
