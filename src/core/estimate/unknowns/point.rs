//! Values of all unknowns, and their retraction `point ⊞ step`.

use nalgebra::DVector;

use super::kept::KeptSteps;
use super::layout::Layout;
use crate::estimate::problem::Problem;
use crate::motion::{ArcGuess, Guess};
use crate::physics::State;
use crate::physics::state::{self, StateTangent};

/// Values of all unknowns.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// States of the arcs at their epochs.
    pub arcs: Vec<State>,
    /// States of held bodies at their collisions.
    pub held: Vec<State>,
    /// Physical times of the scene's events \[s\].
    pub event_times_s: Vec<f64>,
    /// Physical times of the nodes \[s\].
    pub node_times_s: Vec<f64>,
    /// Free parameters.
    pub parameters: Vec<f64>,
    /// Of the arcs' rotations.
    pub kept: KeptSteps,
}

impl Point {
    /// The values of a guess.
    pub fn new(problem: &Problem, guess: &Guess) -> Self {
        let mut node_times_s = problem.nodes_acted_s.clone();
        for (arc, arc_guess) in problem.arcs.iter().zip(&guess.arcs) {
            let samples = arc.samples_as_read().flat_map(|(_, samples)| samples);
            for (sample, time_s) in samples.zip(&arc_guess.sample_times_s) {
                if sample.share == 0.0 {
                    node_times_s[sample.node] = *time_s;
                }
            }
        }
        let mut point = Self {
            arcs: guess.arcs.iter().map(|arc| arc.state).collect(),
            held: vec![State::at_rest(); problem.held.len()],
            event_times_s: guess.event_times_s.clone(),
            node_times_s,
            parameters: guess.parameters.clone(),
            kept: KeptSteps::default(),
        };
        problem.hold(&mut point, None);
        point
    }

    /// The point as a guess, with the epochs and the initial parameters of the guess it came from.
    pub fn guess(&self, problem: &Problem, from: &Guess) -> Guess {
        let arcs = problem.arcs.iter().zip(&self.arcs).zip(&from.arcs);
        let arcs = arcs.map(|((arc, state), of)| ArcGuess {
            epoch_s: of.epoch_s,
            state: *state,
            sample_times_s: arc
                .samples_as_read()
                .flat_map(|(_, samples)| samples)
                .map(|sample| sample.time_s(&self.node_times_s))
                .collect(),
        });
        Guess {
            arcs: arcs.collect(),
            event_times_s: self.event_times_s.clone(),
            parameters: from.parameters.clone(),
        }
    }

    /// Physical times of the nodes of another problem, which are among those of this one's \[s\].
    pub(in crate::estimate) fn at_nodes(&self, problem: &Problem, other: &Problem) -> Vec<f64> {
        let nodes = other.nodes_acted_s.iter();
        let place = |acted_s: &f64| {
            let own = &problem.nodes_acted_s;
            own.partition_point(|node_s| node_s < acted_s)
        };
        nodes
            .map(|acted_s| self.node_times_s[place(acted_s)])
            .collect()
    }

    /// `self = origin ⊞ delta`.
    ///
    /// Where times are unknown, the interval `d` between neighbouring nodes is multiplied by
    /// `e^{asinh(δ/d)}`, which agrees with `d + δ` to first order and is positive: the order of
    /// times (paper eq. 7) holds by construction, without bounds. Events are not part of that
    /// chain: a sample beside a collision may come to lie on its arc's continuation. Parameters
    /// stop at their bounds.
    pub fn retract_from(
        &mut self,
        origin: &Point,
        problem: &Problem,
        layout: &Layout,
        delta: &DVector<f64>,
    ) {
        self.kept.clear();
        for (arc, (state, from)) in self.arcs.iter_mut().zip(&origin.arcs).enumerate() {
            let delta = &delta.as_slice()[layout.state(arc)];
            *state = from.retract(&StateTangent::from_column_slice(delta));
        }
        let held = self.held.iter_mut().zip(&origin.held);
        for ((state, from), at) in held.zip(&layout.held) {
            *state = from.retract(&delta.fixed_rows::<{ state::DIMENSION }>(*at).into());
        }
        let change = |at: Option<usize>| at.map_or(0.0, |at| delta[at]);
        for (event, time_s) in self.event_times_s.iter_mut().enumerate() {
            *time_s = origin.event_times_s[event] + change(layout.events[event]);
        }
        if problem.times_are_unknown() {
            for (node, pair) in origin.node_times_s.windows(2).enumerate() {
                let gap_s = pair[1] - pair[0];
                let change_s = change(layout.nodes[node + 1]) - change(layout.nodes[node]);
                self.node_times_s[node + 1] =
                    self.node_times_s[node] + gap_s * positive_factor(change_s / gap_s);
            }
        }
        for (index, free) in problem.parameters.iter().enumerate() {
            self.parameters[index] = (origin.parameters[index] + delta[layout.parameters[index]])
                .clamp(free.lower, free.upper);
        }
    }
}

/// `e^{asinh x}`: `1 + x` to first order, positive and smooth, and undone by `−x`.
fn positive_factor(x: f64) -> f64 {
    let root = (1.0 + x * x).sqrt();
    // Written without cancellation where x is negative.
    if x >= 0.0 { root + x } else { 1.0 / (root - x) }
}
