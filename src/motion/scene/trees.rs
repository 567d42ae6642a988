//! The trees of a scene, and all that moves as one system.

use super::joint::{Joint, JointTree};
use super::link::Mechanism;
use super::whole::Scene;
use crate::motion::estimate::Estimate;
use crate::motion::index::{LinkIndex, MechanismIndex};
use crate::physics::tree::{Forest, Tree, TreeState};

impl Scene {
    /// The tree that a mechanism is; `None` of a body by itself.
    pub fn joint_tree(&self, mechanism: MechanismIndex) -> Option<&JointTree> {
        self.mechanisms[mechanism].tree()
    }

    /// The mechanisms that are trees.
    pub fn joint_trees(&self) -> impl Iterator<Item = (MechanismIndex, &JointTree)> {
        let all = self.mechanisms.iter_enumerated();
        all.filter_map(|(index, mechanism)| Some((index, mechanism.tree()?)))
    }

    /// The joint on which a link hangs.
    pub fn joint_of(&self, child: LinkIndex) -> Option<&Joint> {
        let tree = self.joint_tree(self.mechanism_of(child))?;
        tree.joints.iter().find(|joint| joint.child == child)
    }

    /// Whether a joint ties one link to the other.
    pub fn are_joined(&self, one: LinkIndex, other: LinkIndex) -> bool {
        let tree = self.joint_tree(self.mechanism_of(one));
        let mut joints = tree.into_iter().flat_map(|tree| &tree.joints);
        joints.any(|joint| {
            let ends = (joint.parent, joint.child);
            ends == (Some(one), other) || ends == (Some(other), one)
        })
    }

    /// The equations of motion of a tree.
    ///
    /// # Panics
    /// Where its joints or masses allow none, which the makers of scenes exclude.
    pub fn tree_model(&self, tree: &JointTree) -> Tree {
        let model = tree.model(|link| self.links[link].body);
        model.expect("scenes have valid trees")
    }

    /// The equations of motion of all that moves: a tree for each mechanism, in their order.
    ///
    /// # Panics
    /// As [`Scene::tree_model`] does.
    pub fn forest(&self) -> Forest {
        let trees = self.mechanisms.iter();
        Forest::new(trees.map(|of| self.tree_model(&of.as_tree())).collect())
    }

    /// The state of all that moves at a time of an estimate with joined bodies, after what happens then; `None` where
    /// that says none.
    pub fn forest_state(
        &self,
        estimate: &Estimate,
        forest: &Forest,
        time_s: f64,
    ) -> Option<TreeState> {
        let gravity_m_s2 = &estimate.gravity_m_s2;
        let all = self.mechanisms.iter_enumerated().zip(forest.trees());
        let parts = all.map(|((mechanism, of), tree)| match of {
            Mechanism::Free(_) => {
                let arcs = estimate.arcs.iter();
                let mut own = arcs.filter(|arc| arc.mechanism == mechanism);
                let arc = own.rfind(|arc| arc.start_s <= time_s)?;
                let since_s = time_s - arc.epoch_s;
                let flown = self.dynamics(mechanism);
                let state = flown.advance(gravity_m_s2, &arc.state, since_s);
                Some(TreeState::of_body(&state))
            }
            Mechanism::Tree(_) => {
                let motion = estimate.tree_motion(mechanism)?;
                Some(motion.state(tree, gravity_m_s2, time_s))
            }
        });
        let parts: Option<Vec<TreeState>> = parts.collect();
        Some(forest.whole(parts?))
    }

    /// The links in the order of the forest's places.
    pub fn forest_links(&self) -> impl Iterator<Item = LinkIndex> {
        self.mechanisms.iter().flat_map(|of| of.links())
    }

    /// The place of a link in the forest.
    pub fn place_of(&self, link: LinkIndex) -> usize {
        let place = self.forest_links().position(|of| of == link);
        place.expect("every link moves with a mechanism")
    }
}
