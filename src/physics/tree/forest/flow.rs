//! The flow of trees side by side: that of each.

use nalgebra::{DMatrix, Vector3};

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
                .map(|tree| DMatrix::zeros(2 * tree.freedoms(), 2 * tree.freedoms() + 1))
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
    pub fn advance(&mut self, duration_s: f64, steps: usize, duration_by_time: f64) {
        for flow in &mut self.flows {
            flow.advance(duration_s, steps, duration_by_time);
        }
    }

    /// The state now.
    pub fn state(&mut self) -> TreeState {
        self.forest.whole(self.flows.iter_mut().map(Flow::state))
    }

    /// Its derivative by the tangent of the start, and by time in the last column, as [`Flow::jacobian`] says.
    pub fn jacobian(&mut self, result: &mut DMatrix<f64>) {
        if let [alone] = self.flows.as_mut_slice() {
            return alone.jacobian(result);
        }
        result.fill(0.0);
        let time = 2 * self.forest.freedoms();
        let both = self.flows.iter_mut().zip(&mut self.rooms);
        for (index, (flow, own)) in both.enumerate() {
            flow.jacobian(own);
            let columns = self.forest.tangent_of(index).chain([time]);
            for (column, to) in columns.enumerate() {
                for (row, at) in self.forest.tangent_of(index).enumerate() {
                    result[(at, to)] = own[(row, column)];
                }
            }
        }
    }
}
