//! A value of all unknowns, and how it moves.

use nalgebra::DVector;

use super::layout::{Layout, STATE};
use super::problem::Problem;
use crate::motion::Guess;
use crate::physics::State;
use crate::physics::state::StateTangent;

/// A value of every unknown.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// States of the arcs at their epochs.
    pub arcs: Vec<State>,
    /// Physical times of the scene's events [s].
    pub event_times_s: Vec<f64>,
    /// Physical times of the nodes [s].
    pub node_times_s: Vec<f64>,
    /// Free parameters.
    pub parameters: Vec<f64>,
}

impl Point {
    /// The guess, with parameters at their initial values.
    pub fn new(problem: &Problem, guess: &Guess) -> Self {
        let mut node_times_s = problem.nodes_acted_s.clone();
        for (arc, arc_guess) in problem.arcs.iter().zip(&guess.arcs) {
            for (sample, time_s) in arc.samples.iter().zip(&arc_guess.sample_times_s) {
                node_times_s[sample.node] = *time_s;
            }
        }
        Self {
            arcs: guess.arcs.iter().map(|arc| arc.state).collect(),
            event_times_s: guess.event_times_s.clone(),
            node_times_s,
            parameters: problem.parameters.iter().map(|free| free.initial).collect(),
        }
    }

    /// Moves `origin` by `delta`, into `self`.
    ///
    /// Where times are unknown, the gap between neighbours (samples and events alike) changes
    /// by a factor that agrees with `delta` to first order and is positive: order holds by
    /// construction, and no bound is needed. Parameters stop at their bounds.
    pub fn retract_from(
        &mut self,
        origin: &Point,
        problem: &Problem,
        layout: &Layout,
        delta: &DVector<f64>,
    ) {
        for ((state, from), at) in self.arcs.iter_mut().zip(&origin.arcs).zip(&layout.arcs) {
            *state = from.retract(&StateTangent::from_column_slice(
                &delta.as_slice()[*at..*at + STATE],
            ));
        }
        let change = |at: Option<usize>| at.map_or(0.0, |at| delta[at]);
        if problem.times_are_unknown() {
            self.retract_times(origin, problem, layout, change);
        } else {
            for (event, time_s) in self.event_times_s.iter_mut().enumerate() {
                *time_s = origin.event_times_s[event] + change(layout.events[event]);
            }
        }
        for (index, free) in problem.parameters.iter().enumerate() {
            self.parameters[index] = (origin.parameters[index] + delta[layout.parameters[index]])
                .clamp(free.lower, free.upper);
        }
    }

    fn retract_times(
        &mut self,
        origin: &Point,
        problem: &Problem,
        layout: &Layout,
        change: impl Fn(Option<usize>) -> f64,
    ) {
        let nodes = &problem.nodes_acted_s;
        let Some(first) = origin.node_times_s.first() else {
            return;
        };
        let (mut old_s, mut new_s, mut old_change) = (*first, *first, 0.0);
        let mut step = |time_s: f64, change_s: f64| {
            let gap = time_s - old_s;
            new_s += gap * positive_factor((change_s - old_change) / gap);
            (old_s, old_change) = (time_s, change_s);
            new_s
        };
        let mut node = 1;
        for event in 0..problem.event_is_free.len() {
            let acted_s = problem.events_acted_s[event];
            while node < nodes.len() && nodes[node] <= acted_s {
                self.node_times_s[node] =
                    step(origin.node_times_s[node], change(layout.nodes[node]));
                node += 1;
            }
            if problem.event_is_free[event] {
                self.event_times_s[event] =
                    step(origin.event_times_s[event], change(layout.events[event]));
            }
        }
        for node in node..nodes.len() {
            self.node_times_s[node] = step(origin.node_times_s[node], change(layout.nodes[node]));
        }
    }
}

/// `1 + x` to first order, positive everywhere.
fn positive_factor(x: f64) -> f64 {
    if x >= 0.0 { 1.0 + x } else { 1.0 / (1.0 - x) }
}
