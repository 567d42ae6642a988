//! Bodies joined in a tree.

use nalgebra::Vector3;

use crate::math::{Pose, so3};
use crate::motion::index::LinkIndex;
use crate::physics::Body;
use crate::physics::contact::Feature;
use crate::physics::tree::{self, JointKind, Tree, TreeError};

/// A joint between two links, or between a link and the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Unique name.
    pub name: String,
    /// What it hangs from, of the first joint of a tree perhaps a held link; `None`: the world.
    pub parent: Option<LinkIndex>,
    /// What hangs on it.
    pub child: LinkIndex,
    /// How the child may move against the parent.
    pub joint: tree::Joint,
}

/// One of the two that a joint ties.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointEnd {
    /// What it hangs from: a link, or the world.
    Parent,
    /// What hangs on it.
    Child,
}

impl Joint {
    /// Where it is in the axes of one of the two \[m\].
    pub fn place_m(&self, end: JointEnd) -> Vector3<f64> {
        match end {
            JointEnd::Parent => self.joint.parent_from_joint.translation.vector,
            JointEnd::Child => self.joint.link_from_joint.translation.vector,
        }
    }

    /// Moves it in the axes of one of the two \[m\].
    pub(super) fn shift(&mut self, end: JointEnd, axis: usize, by_m: f64) {
        let pose = match end {
            JointEnd::Parent => &mut self.joint.parent_from_joint,
            JointEnd::Child => &mut self.joint.link_from_joint,
        };
        pose.translation.vector[axis] += by_m;
    }

    /// Keeps it where it is on a link whose axes move with its centre of mass [m, link axes].
    pub(super) fn move_centre(&mut self, link: LinkIndex, by_m: &Vector3<f64>) {
        if self.parent == Some(link) {
            self.joint.parent_from_joint.translation.vector -= by_m;
        }
        if self.child == link {
            self.joint.link_from_joint.translation.vector -= by_m;
        }
    }

    /// Axes about which turning the joint in both that it ties makes another joint of it [joint axes, unit length]:
    /// those across a pin, any three of a universal joint, none of a ball.
    pub fn turns(&self) -> Vec<Vector3<f64>> {
        match &self.joint.kind {
            JointKind::Pin { axis } => Feature::tangents(&axis.normalize()).to_vec(),
            JointKind::Universal { .. } => vec![Vector3::x(), Vector3::y(), Vector3::z()],
            JointKind::Ball | JointKind::Fixed | JointKind::Free => Vec::new(),
        }
    }

    /// Turns its axes in both that it ties \[rad\].
    pub(super) fn turn(&mut self, by: Vector3<f64>) {
        let turn = so3::exp(&by);
        self.joint.parent_from_joint.rotation *= turn;
        self.joint.link_from_joint.rotation *= turn;
    }
}

/// Links that joints tie to each other, without circles.
#[derive(Clone, Debug, PartialEq)]
pub struct JointTree {
    /// The link that flies and hangs from nothing; `None`: the first joint hangs from the world or from a held body.
    pub base: Option<LinkIndex>,
    /// The joints, each after that of its parent.
    pub joints: Vec<Joint>,
}

impl JointTree {
    /// Its links in the order of the tree's model: parents first.
    pub fn links(&self) -> impl Iterator<Item = LinkIndex> + '_ {
        let hanging = self.joints.iter().map(|joint| joint.child);
        self.base.into_iter().chain(hanging)
    }

    /// The place of a link in that order.
    pub fn place_of(&self, link: LinkIndex) -> Option<usize> {
        self.links().position(|of| of == link)
    }

    /// The equations of motion of links with these masses. Fails where joints or masses allow none.
    pub fn model(&self, body: impl Fn(LinkIndex) -> Body) -> Result<Tree, TreeError> {
        Tree::new(&self.model_links(body))
    }

    /// The links of the equations of motion, in their order, with these masses.
    pub fn model_links(&self, body: impl Fn(LinkIndex) -> Body) -> Vec<tree::Link> {
        let free = tree::Joint::new(JointKind::Free, Pose::identity(), Pose::identity());
        let base = self.base.map(|link| tree::Link {
            parent: None,
            joint: free,
            body: body(link),
        });
        let hanging = self.joints.iter().map(|of| tree::Link {
            parent: of.parent.and_then(|parent| self.place_of(parent)),
            joint: of.joint,
            body: body(of.child),
        });
        base.into_iter().chain(hanging).collect()
    }
}
