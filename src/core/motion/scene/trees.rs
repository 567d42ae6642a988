//! The trees of a scene, and all that moves as one system.

use super::joint::{Joint, JointTree};
use super::link::Mechanism;
use super::phase::InHand;
use super::whole::Scene;
use crate::motion::estimate::Estimate;
use crate::motion::held::HeldEstimate;
use crate::motion::index::{LinkIndex, MechanismIndex};
use crate::physics::tree::{Forest, Hand, Tree, TreeState};

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

    /// Whether a joint ties one link to the other, a held one grips the other for a while, or they stick together.
    pub fn are_joined(&self, one: LinkIndex, other: LinkIndex) -> bool {
        let grips = |hand: LinkIndex, body: LinkIndex| {
            let mut phases = self.phases.iter().filter(|phase| phase.link == body);
            phases.any(|phase| {
                let hand_of = |of: &InHand| self.tracks[of.track].link;
                phase.in_hand().map(hand_of) == Some(hand)
            })
        };
        let hangs = |child: LinkIndex, parent: LinkIndex| {
            let joint = self.joint_of(child);
            joint.is_some_and(|joint| joint.parent == Some(parent))
        };
        let are_stuck = self.stuck_pairs().any(|pair| {
            let has = |link: LinkIndex| pair.links.contains(&link);
            has(one) && has(other)
        });
        let is_gripped = grips(one, other) || grips(other, one);
        hangs(one, other) || hangs(other, one) || is_gripped || are_stuck
    }

    /// The held body from which a tree hangs, if it does.
    pub fn hand_of(&self, tree: &JointTree) -> Option<LinkIndex> {
        let first = tree.joints.first()?;
        first.parent.filter(|parent| self.is_held(*parent))
    }

    /// Whether joined bodies hang from a link that is held.
    pub fn carries(&self, link: LinkIndex) -> bool {
        let mut trees = self.joint_trees();
        trees.any(|(_, tree)| self.hand_of(tree) == Some(link))
    }

    /// The mechanisms whose motion is unknown: all but what is held or apart. In this order they are the trees of the
    /// [forest](Scene::forest).
    pub fn moving(&self) -> impl Iterator<Item = (MechanismIndex, &Mechanism)> {
        let all = self.mechanisms.iter_enumerated();
        all.filter(|(index, _)| self.moves(*index))
    }

    /// The equations of motion of a tree that hangs from no hand.
    ///
    /// # Panics
    /// As [`Scene::tree_model_with`] does.
    pub fn tree_model(&self, tree: &JointTree) -> Tree {
        self.tree_model_with(tree, &[])
    }

    /// The equations of motion of a tree, where bodies in the hand move so.
    ///
    /// # Panics
    /// Where its joints or masses allow none, which the makers of scenes exclude, and where nothing is said of the hand
    /// from which it hangs.
    pub fn tree_model_with(&self, tree: &JointTree, hands: &[HeldEstimate]) -> Tree {
        let model = tree.model(|link| self.links[link].body);
        let model = model.expect("scenes have valid trees");
        let Some(hand) = self.hand_of(tree) else {
            return model;
        };
        let held = hands.iter().find(|held| held.link == hand);
        let held = held.expect("every hand has a motion");
        model.in_hand(Hand::new(held.curve.clone()))
    }

    /// The equations of motion of all that moves where nothing hangs from a hand.
    ///
    /// # Panics
    /// As [`Scene::tree_model_with`] does.
    pub fn forest(&self) -> Forest {
        self.forest_with(&[])
    }

    /// The equations of motion of all that [moves](Scene::moving), where bodies in the hand move so: a tree for each
    /// mechanism, in their order.
    ///
    /// # Panics
    /// As [`Scene::tree_model_with`] does.
    pub fn forest_with(&self, hands: &[HeldEstimate]) -> Forest {
        let trees = self.moving();
        let trees = trees.map(|(_, of)| self.tree_model_with(&of.as_tree(), hands));
        Forest::new(trees.collect())
    }

    /// The state of all that moves at a time of an estimate with joined bodies, after what happens then; `None` where
    /// that says none.
    pub fn forest_state(
        &self,
        estimate: &Estimate,
        forest: &Forest,
        time_s: f64,
    ) -> Option<TreeState> {
        self.forest_beside(estimate, forest, time_s, true)
    }

    /// The same before what happens then.
    pub fn forest_state_before(
        &self,
        estimate: &Estimate,
        forest: &Forest,
        time_s: f64,
    ) -> Option<TreeState> {
        self.forest_beside(estimate, forest, time_s, false)
    }

    fn forest_beside(
        &self,
        estimate: &Estimate,
        forest: &Forest,
        time_s: f64,
        is_after: bool,
    ) -> Option<TreeState> {
        let gravity_m_s2 = &estimate.gravity_m_s2;
        let all = self.moving().zip(forest.trees());
        let parts = all.map(|((mechanism, of), tree)| match of {
            Mechanism::Free(_) => {
                let arcs = estimate.arcs.iter();
                let mut own = arcs.filter(|arc| arc.mechanism == mechanism);
                let arc =
                    own.rfind(|arc| arc.start_s < time_s || (is_after && arc.start_s == time_s))?;
                Some(TreeState::of_body(&self.flown(arc, gravity_m_s2, time_s)))
            }
            Mechanism::Tree(_) => {
                let motion = estimate.tree_motion(mechanism)?;
                Some(match is_after {
                    true => motion.state(tree, gravity_m_s2, time_s),
                    false => motion.state_before(tree, gravity_m_s2, time_s),
                })
            }
            Mechanism::Apart(_) => None,
        });
        let parts: Option<Vec<TreeState>> = parts.collect();
        Some(TreeState {
            time_s,
            ..forest.whole(parts?)
        })
    }

    /// The links in the order of the forest's places.
    pub fn forest_links(&self) -> impl Iterator<Item = LinkIndex> {
        self.moving().flat_map(|(_, of)| of.links())
    }

    /// The place of a link in the forest.
    pub fn place_of(&self, link: LinkIndex) -> usize {
        let place = self.forest_links().position(|of| of == link);
        place.expect("every link that is not held moves with a mechanism")
    }
}
