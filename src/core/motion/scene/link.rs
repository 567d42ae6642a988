//! What moves and who sees it: links, mechanisms, tracks.

use std::borrow::Cow;

use nalgebra::{UnitQuaternion, UnitVector3, Vector3};

use super::joint::JointTree;
use super::weights::{Weighing, Weights};
use crate::math::Pose;
use crate::motion::index::{LinkIndex, MechanismIndex};
use crate::physics::contact;
use crate::physics::shape::Solid;
use crate::physics::{Body, Shape};

/// A rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Unique name.
    pub name: String,
    /// Mass and principal moments; the link's axes are principal axes at its centre of mass.
    pub body: Body,
    /// Its shape.
    pub shape: Shape,
    /// Where the origin of the shape is \[m\], in the link's axes, along which it lies: zero unless
    /// the centre of mass was estimated elsewhere ([`Scene::with_values`](super::Scene::with_values)).
    pub shape_at_m: Vector3<f64>,
    /// The frame in which its scene gives it and in which its poses are written, in the link's axes: the
    /// identity where that is at the centre of mass along principal axes.
    pub link_from_given: Pose,
    /// What of it may touch something.
    pub features: Vec<Feature>,
    /// What it moves with.
    pub mechanism: MechanismIndex,
    /// Whether somebody holds it, and what is known of its tracker then: it does not fly, but moves
    /// as it was tracked, and what hits it does not deflect it.
    pub held: Option<Held>,
}

/// What is known of the tracker on a body in the hand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Held {
    /// Standard deviation of its positions per axis \[m\]; `None`: as the stream shows.
    pub position_sd_m: Option<f64>,
    /// Standard deviation of its orientations per axis \[rad\]; `None`: as the stream shows.
    pub orientation_sd_rad: Option<f64>,
}

impl Link {
    /// Pose of its shape in its axes.
    pub fn link_from_shape(&self) -> Pose {
        Pose::from_parts(self.shape_at_m.into(), UnitQuaternion::identity())
    }

    /// Pose of its shape in the frame in which its scene gives it.
    pub fn given_from_shape(&self) -> Pose {
        self.given_from(&self.link_from_shape())
    }

    /// A pose in its axes, such as that of a tracker on it, in the frame in which its scene gives it: what a key
    /// of a scene says.
    pub fn given_from(&self, link_from_other: &Pose) -> Pose {
        self.link_from_given.inverse() * link_from_other
    }

    /// Its shape prepared for distance queries, in its axes.
    ///
    /// # Panics
    /// Where the shape is no solid, which the makers of scenes exclude.
    pub fn solid(&self) -> Solid {
        let solid = self.shape.solid().expect("scenes have valid shapes");
        solid.moved(&self.shape_at_m)
    }

    /// Radius of a sphere about its centre of mass that holds its shape \[m\].
    pub fn radius_m(&self) -> f64 {
        self.shape.radius_m() + self.shape_at_m.norm()
    }
}

/// What moves as one system of ordinary differential equations between its collisions.
#[derive(Clone, Debug, PartialEq)]
pub enum Mechanism {
    /// One rigid body by itself: in free flight, unless it is held ([`Link::held`]).
    Free(LinkIndex),
    /// Bodies joined in a tree.
    Tree(JointTree),
    /// Links of another [group](super::Group), whose motion is estimated by itself.
    Apart(Vec<LinkIndex>),
}

impl Mechanism {
    /// Its links.
    pub fn links(&self) -> impl Iterator<Item = LinkIndex> + '_ {
        let (some, tree): (&[LinkIndex], _) = match self {
            Mechanism::Free(link) => (std::slice::from_ref(link), None),
            Mechanism::Tree(tree) => (&[], Some(tree)),
            Mechanism::Apart(links) => (links, None),
        };
        let joined = tree.into_iter().flat_map(JointTree::links);
        some.iter().copied().chain(joined)
    }

    /// The link, if it is one by itself.
    pub fn free(&self) -> Option<LinkIndex> {
        match self {
            Mechanism::Free(link) => Some(*link),
            Mechanism::Tree(_) | Mechanism::Apart(_) => None,
        }
    }

    /// The tree that it is: a body by itself is one without joints.
    ///
    /// # Panics
    /// Where it is apart: it does not move here.
    pub fn as_tree(&self) -> Cow<'_, JointTree> {
        match self {
            Mechanism::Free(link) => Cow::Owned(JointTree {
                base: Some(*link),
                joints: Vec::new(),
            }),
            Mechanism::Tree(tree) => Cow::Borrowed(tree),
            Mechanism::Apart(_) => unreachable!("what is apart does not move here"),
        }
    }

    /// The tree, if it is one.
    pub fn tree(&self) -> Option<&JointTree> {
        match self {
            Mechanism::Free(_) | Mechanism::Apart(_) => None,
            Mechanism::Tree(tree) => Some(tree),
        }
    }
}

/// What one tracker sees.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Unique name: that of the link, unless that has several tracks.
    pub name: String,
    /// Topic that carries the tracker's poses; see [`stream_topic`](super::Scene::stream_topic).
    pub topic: String,
    /// The link that it is mounted on.
    pub link: LinkIndex,
    /// Pose of the tracker's frame in the link's axes.
    pub link_from_tracker: Pose,
    /// What of its messages counts.
    pub sees: Sees,
    /// How its samples are weighed.
    pub weighing: Weighing,
}

impl Track {
    /// The point of the link on which the tracker is mounted [m, link axes].
    pub fn point_m(&self) -> Vector3<f64> {
        self.link_from_tracker.translation.vector
    }

    /// Weights of its samples in a scene with those weights, where its messages say none.
    pub fn weights<'a>(&'a self, of_scene: &'a Weights) -> &'a Weights {
        match &self.weighing {
            Weighing::Own(weights) => weights,
            Weighing::Scene | Weighing::Messages => of_scene,
        }
    }
}

/// What of a tracker's messages counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sees {
    /// The pose of its frame.
    Pose,
    /// The place of its origin, a point of the link.
    Point,
    /// The orientation of its frame.
    Orientation,
    /// The direction of an axis of the link, given in link axes.
    Direction(UnitVector3<f64>),
}

/// A rigid body by itself with a tracker on it: a link, a mechanism and a track in one.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeBody {
    /// Unique name.
    pub name: String,
    /// Topic that carries its tracker's poses.
    pub topic: String,
    /// Mass and principal moments; its axes are principal axes at the centre of mass.
    pub body: Body,
    /// Shape in its axes.
    pub shape: Shape,
    /// Pose of the tracker's frame in its axes.
    pub body_from_tracker: Pose,
    /// Its features that may touch something.
    pub features: Vec<Feature>,
}

/// A named part of a link's surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// Name, unique within the link.
    pub name: String,
    /// Geometry in link axes.
    pub geometry: contact::Feature,
}
