//! Trees side by side at one instant: states of links.

use nalgebra::{DMatrix, Vector3};

use super::Forest;
use crate::physics::state::{State, StateTangent};
use crate::physics::tree::snapshot::Snapshot;
use crate::physics::tree::state::TreeState;

/// Room for all that is computed of trees at one instant; used again and again.
#[derive(Clone, Debug)]
pub struct ForestSnapshot<'t> {
    pub(in crate::physics::tree) forest: &'t Forest,
    pub(in crate::physics::tree) trees: Vec<Snapshot<'t>>,
}

impl<'t> ForestSnapshot<'t> {
    /// Room for trees in a field of gravity [m/s²].
    pub fn new(forest: &'t Forest, gravity_m_s2: &Vector3<f64>) -> Self {
        let trees = forest.trees.iter();
        Self {
            forest,
            trees: trees
                .map(|tree| Snapshot::new(tree, gravity_m_s2))
                .collect(),
        }
    }

    /// Moves to a state.
    pub fn set(&mut self, state: &TreeState) {
        for (index, tree) in self.trees.iter_mut().enumerate() {
            tree.set(&self.forest.part(state, index));
        }
    }

    /// State of the link at a place, as [`Snapshot::link_state`] says.
    pub fn link_state(&self, place: usize) -> State {
        let (tree, link) = self.forest.tree_of(place);
        self.trees[tree].link_state(link)
    }

    /// How it changes with time where all coordinates and rates stay, as [`Snapshot::link_carried`] says.
    pub fn link_carried(&self, place: usize) -> StateTangent {
        let (tree, link) = self.forest.tree_of(place);
        self.trees[tree].link_carried(link)
    }

    /// Derivative of that state's tangent by the tangent of all, as [`Snapshot::link_jacobian`] says.
    pub fn link_jacobian(&self, place: usize, result: &mut DMatrix<f64>) {
        let (tree, link) = self.forest.tree_of(place);
        if let [alone] = self.trees.as_slice() {
            return alone.link_jacobian(link, result);
        }
        let rates = self.forest.rates_of(tree).len();
        let mut own = DMatrix::zeros(result.nrows(), 2 * rates);
        self.trees[tree].link_jacobian(link, &mut own);
        result.fill(0.0);
        for (column, to) in self.forest.tangent_of(tree).enumerate() {
            result.column_mut(to).copy_from(&own.column(column));
        }
    }
}
