//! Bodies joined in a tree.

use crate::math::Pose;
use crate::motion::index::LinkIndex;
use crate::physics::Body;
use crate::physics::tree::{self, JointKind, Tree, TreeError};

/// A joint between two links, or between a link and the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Unique name.
    pub name: String,
    /// What it hangs from; `None`: the world.
    pub parent: Option<LinkIndex>,
    /// What hangs on it.
    pub child: LinkIndex,
    /// How the child may move against the parent.
    pub joint: tree::Joint,
}

/// Links that joints tie to each other, without circles.
#[derive(Clone, Debug, PartialEq)]
pub struct JointTree {
    /// The link that flies and hangs from nothing; `None`: the first joint hangs from the world.
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
