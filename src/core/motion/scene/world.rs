//! The static world: surfaces that links collide with, and solids.

use nalgebra::Vector3;

use crate::math::Pose;
use crate::motion::index::LinkIndex;
use crate::physics::Shape;
use crate::physics::contact;

/// Something with which a body may collide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    /// A plane that stands for itself (index into `Scene::surfaces`).
    Surface(usize),
    /// A solid part of the static world (index into `Scene::obstacles`).
    Obstacle(usize),
    /// Another link.
    Link(LinkIndex),
}

/// A named part of the static world's surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Unique name.
    pub name: String,
    /// Geometry in world axes.
    pub geometry: contact::Feature,
    /// The obstacle to which it belongs (index into `Scene::obstacles`); `None` for a plane by
    /// itself.
    pub obstacle: Option<usize>,
}

impl Surface {
    /// A point and the unit normal of a plane that belongs to no obstacle; `None` for other
    /// surfaces.
    pub fn plane(&self) -> Option<(Vector3<f64>, Vector3<f64>)> {
        match (self.geometry, self.obstacle) {
            (contact::Feature::Face { point_m, normal }, None) => Some((point_m, normal)),
            _ => None,
        }
    }
}

/// A solid part of the static world.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// Unique name.
    pub name: String,
    /// Its shape.
    pub shape: Shape,
    /// Its pose.
    pub world_from_shape: Pose,
}
