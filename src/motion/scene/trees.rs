//! The trees of a scene.

use super::joint::{Joint, JointTree};
use super::whole::Scene;
use crate::motion::index::{LinkIndex, MechanismIndex};
use crate::physics::tree::Tree;

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
}
