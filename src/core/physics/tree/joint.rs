//! Joints: how a link may move against its parent.

use nalgebra::Vector3;

use crate::math::Pose;

/// What a joint leaves free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointKind {
    /// Nothing: both links are one rigid body.
    Fixed,
    /// Rotation about an axis of the joint's frame.
    Pin {
        /// Axis, of any length.
        axis: Vector3<f64>,
    },
    /// Rotation about a first axis, fixed in the parent, then about a second, fixed in the link: the
    /// cross of a universal joint.
    ///
    /// Its coordinates are regular wherever the axes are not parallel, that is everywhere: the angle
    /// between them never changes. Only its *inertia* is uneven: where the link's long axis comes to lie
    /// along the first axis, rotation about that axis turns the link about itself, with the little
    /// moment it has there, and rates become large as those of a rod passing a pole. So both
    /// axes are best laid across the link in the middle of its range, the pole then is 90° away.
    Universal {
        /// First and second axis, of any length, in the joint's frame where both angles are zero.
        axes: [Vector3<f64>; 2],
    },
    /// Any rotation about the joint's origin.
    Ball,
    /// Everything: the first link of a tree that flies. The joint's poses mean nothing then; the
    /// coordinates are those of the link's [`State`](crate::physics::State).
    Free,
}

impl JointKind {
    /// The axes about which it has angles, in the joint's frame where all are zero.
    pub fn axes(&self) -> &[Vector3<f64>] {
        match self {
            Self::Pin { axis } => std::slice::from_ref(axis),
            Self::Universal { axes } => axes,
            Self::Fixed | Self::Ball | Self::Free => &[],
        }
    }

    /// Number of directions in which the joint moves.
    pub fn freedoms(&self) -> usize {
        match self {
            Self::Fixed => 0,
            Self::Pin { .. } => 1,
            Self::Universal { .. } => 2,
            Self::Ball => 3,
            Self::Free => 6,
        }
    }
}

/// A joint between a link and its parent.
///
/// Where its coordinates are zero, `world_from_link` is
/// `world_from_parent · parent_from_joint · link_from_joint⁻¹`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// What it leaves free.
    pub kind: JointKind,
    /// The joint's frame in the parent's, or in the world's.
    pub parent_from_joint: Pose,
    /// The joint's frame in the link's.
    pub link_from_joint: Pose,
    /// Linear damping [N m s]: a moment `−d ω` against each rate.
    pub damping_n_m_s: f64,
    /// Stiffness of a linear spring [N m/rad]: a moment `−k (q − q₀)` about each axis, and `−k Log(R)`
    /// in a ball joint.
    pub stiffness_n_m: f64,
    /// Where the spring is at rest \[rad\], per axis; a ball's rests at the identity.
    pub rest_rad: [f64; 2],
    /// Least and greatest angle per axis \[rad\]. The flow knows no stops: motions
    /// are checked against them.
    pub limits_rad: [[f64; 2]; 2],
}

impl Joint {
    /// A joint without friction, spring and limits.
    pub fn new(kind: JointKind, parent_from_joint: Pose, link_from_joint: Pose) -> Self {
        Self {
            kind,
            parent_from_joint,
            link_from_joint,
            damping_n_m_s: 0.0,
            stiffness_n_m: 0.0,
            rest_rad: [0.0; 2],
            limits_rad: [[f64::NEG_INFINITY, f64::INFINITY]; 2],
        }
    }
}
