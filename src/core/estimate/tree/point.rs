//! The unknowns of the motion of trees.

use nalgebra::DVector;

use super::problem::TreeProblem;
use super::time_line::TimeLine;
use crate::physics::tree::TreeState;

/// Values of all unknowns. Steps are the tangents of the nodes, one after the other, then the times, then the log-paces, then
/// the parameters.
#[derive(Clone, Debug)]
pub struct TreePoint {
    /// States at the nodes.
    pub nodes: Vec<TreeState>,
    /// Times of the events within the motion \[s\].
    pub event_times_s: Vec<f64>,
    /// Logarithms of the physical per the acted time, piece by piece of the problem's tempo; none where stamps are
    /// physical times.
    pub log_paces: Vec<f64>,
    /// Values of the problem's parameters.
    pub parameters: Vec<f64>,
}

impl TreePoint {
    /// States at the nodes, with events where the problem has them about.
    pub fn new(problem: &TreeProblem, nodes: Vec<TreeState>) -> Self {
        let tempo = problem.tempo.iter();
        let log_paces = tempo.flat_map(|of| vec![of.guess.ln(); of.pieces()]);
        let log_paces: Vec<f64> = log_paces.collect();
        let line = TimeLine::new(problem, &log_paces);
        let events = problem.events.iter();
        Self {
            nodes,
            event_times_s: events.map(|event| line.time_s(event.about_s)).collect(),
            log_paces,
            parameters: problem.parameters.iter().map(|of| of.initial).collect(),
        }
    }

    /// `to = self ⊞ step`.
    pub(super) fn retract(&self, problem: &TreeProblem, step: &DVector<f64>, to: &mut Self) {
        let width = problem.width();
        let (states, rest) = step.as_slice().split_at(width * self.nodes.len());
        let (times, rest) = rest.split_at(self.event_times_s.len());
        let (paces, parameters) = rest.split_at(self.log_paces.len());
        let moved = self.nodes.iter().zip(states.chunks_exact(width));
        for ((from, step), to) in moved.zip(&mut to.nodes) {
            *to = problem.forest.retract(from, step);
        }
        let moved = self.event_times_s.iter().zip(times);
        for ((from_s, step_s), to_s) in moved.zip(&mut to.event_times_s) {
            *to_s = from_s + step_s;
        }
        let moved = self.log_paces.iter().zip(paces);
        for ((from, step), to) in moved.zip(&mut to.log_paces) {
            *to = from + step;
        }
        let moved = self.parameters.iter().zip(parameters);
        for ((from, step), to) in moved.zip(&mut to.parameters) {
            *to = from + step;
        }
    }

    /// Acted to physical time.
    pub(super) fn time_line<'p>(&self, problem: &'p TreeProblem) -> TimeLine<'p> {
        TimeLine::new(problem, &self.log_paces)
    }

    /// `self ⊟ origin`: the step that leads from there to here.
    pub(super) fn minus(&self, problem: &TreeProblem, origin: &Self) -> DVector<f64> {
        let states = self.nodes.iter().zip(&origin.nodes);
        let states = states.flat_map(|(to, from)| problem.forest.minus(to, from));
        let times = self.event_times_s.iter().zip(&origin.event_times_s);
        let paces = self.log_paces.iter().zip(&origin.log_paces);
        let parameters = self.parameters.iter().zip(&origin.parameters);
        let numbers = times.chain(paces).chain(parameters);
        let numbers = numbers.map(|(to, from)| to - from);
        let step: Vec<f64> = states.chain(numbers).collect();
        step.into()
    }

    /// Whether all rates, times, paces and parameters are finite.
    pub fn is_finite(&self) -> bool {
        let rates = self.nodes.iter().flat_map(|state| &state.rates);
        let numbers = rates.chain(&self.event_times_s).chain(&self.log_paces);
        let mut numbers = numbers.chain(&self.parameters);
        numbers.all(|number| number.is_finite())
    }
}
