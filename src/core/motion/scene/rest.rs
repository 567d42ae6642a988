//! What must hold when all has come to rest, after the last event.

use nalgebra::Vector3;

use crate::motion::index::LinkIndex;

/// A goal at rest: once the motion has gone on by simulation and rests, an axis of a link points in
/// a direction. Which way round it lies about that direction is free.
#[derive(Clone, Debug, PartialEq)]
pub struct RestGoal {
    /// The link that it is asked of.
    pub link: LinkIndex,
    /// Name of the axis: `+z`, or a face of the link.
    pub name: String,
    /// The axis, a unit vector in link axes: out of the face.
    pub axis: Vector3<f64>,
    /// Where it points, a unit vector in world axes.
    pub direction: Vector3<f64>,
    /// Greatest angle between both \[rad\].
    pub within_rad: f64,
    /// Whether the faces' labels may be turned on the link, where that changes nothing of the
    /// motion.
    pub labels_are_free: bool,
}
