//! The flow of trees side by side: that of each.

use nalgebra::{DMatrix, DVector, Vector3};

use super::Forest;
use crate::physics::tree::flow::Flow;
use crate::physics::tree::state::TreeState;
use crate::physics::tree::tableau::Tableau;

/// The motion of trees from a start, advanced from sample to sample.
#[derive(Clone, Debug)]
pub struct ForestFlow<'t> {
    forest: &'t Forest,
    flows: Vec<Flow<'t>>,
    /// Room for the derivatives of each; none where one tree is alone.
    rooms: Vec<DMatrix<f64>>,
}

impl<'t> ForestFlow<'t> {
    /// Room for trees in a field of gravity [m/s²].
    pub fn new(forest: &'t Forest, gravity_m_s2: &Vector3<f64>, tableau: Tableau) -> Self {
        let trees = forest.trees.iter();
        let is_alone = trees.len() == 1;
        let rooms = trees.clone().filter(|_| !is_alone);
        Self {
            forest,
            flows: trees
                .map(|tree| Flow::new(tree, gravity_m_s2, tableau))
                .collect(),
            rooms: rooms
                .map(|tree| DMatrix::zeros(2 * tree.freedoms(), 2 * tree.freedoms()))
                .collect(),
        }
    }

    /// Begins at a state.
    pub fn begin(&mut self, state: &TreeState, has_derivatives: bool) {
        for (index, flow) in self.flows.iter_mut().enumerate() {
            flow.begin(&self.forest.part(state, index), has_derivatives);
        }
    }

    /// Goes on as [`Flow::advance`] does.
    pub fn advance(&mut self, duration_s: f64, steps: usize) {
        for flow in &mut self.flows {
            flow.advance(duration_s, steps);
        }
    }

    /// Goes to a time since the start, as [`Flow::reach`] does.
    pub fn reach(&mut self, elapsed_s: f64, step_s: f64) {
        for flow in &mut self.flows {
            flow.reach(elapsed_s, step_s);
        }
    }

    /// The state now.
    pub fn state(&mut self) -> TreeState {
        self.forest.whole(self.flows.iter_mut().map(Flow::state))
    }

    /// How it goes on, as [`Flow::rate`] says.
    pub fn rate(&mut self) -> DVector<f64> {
        let mut rate = DVector::zeros(2 * self.forest.freedoms());
        for (index, flow) in self.flows.iter_mut().enumerate() {
            for (at, of) in self.forest.tangent_of(index).zip(flow.rate().iter()) {
                rate[at] = *of;
            }
        }
        rate
    }

    /// Its derivative by the tangent of the start, as [`Flow::jacobian`] says.
    pub fn jacobian(&mut self, result: &mut DMatrix<f64>) {
        if let [alone] = self.flows.as_mut_slice() {
            return alone.jacobian(result);
        }
        result.fill(0.0);
        let both = self.flows.iter_mut().zip(&mut self.rooms);
        for (index, (flow, own)) in both.enumerate() {
            flow.jacobian(own);
            for (column, to) in self.forest.tangent_of(index).enumerate() {
                for (row, at) in self.forest.tangent_of(index).enumerate() {
                    result[(at, to)] = own[(row, column)];
                }
            }
        }
    }
}
