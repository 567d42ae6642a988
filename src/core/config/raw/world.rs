//! What stands, and what ties bodies together.

use schemars::JsonSchema;
use serde::Deserialize;

use super::super::spanned::Spanned;
use super::shape::RawShape;
use super::value::{Number, Quadruple, Text, Triple};

/// A flat surface that has no end, or a board of a size.
///
/// ```toml
/// [[surface]]
/// name = "shelf"
/// point_mm = [0, 200, 400]
/// normal = [0, 0, 1]
/// size_mm = [600, 250]
/// thickness_mm = 18
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "a table with `name`, `point_mm` and `normal`"
)]
#[schemars(rename = "surface")]
pub(in crate::config) struct RawSurface {
    /// Its name.
    pub(in crate::config) name: Text,
    /// A point on it; of a board the middle.
    pub(in crate::config) point_mm: Triple,
    /// Its normal, out of the solid; any length.
    pub(in crate::config) normal: Triple,
    /// Sides of a board. Default: it has no end.
    pub(in crate::config) size_mm: Option<Spanned<[f64; 2]>>,
    /// Thickness of a board, below the surface. Default: 10.
    pub(in crate::config) thickness_mm: Option<Number>,
    /// Direction of the first side of a board, as far as it is across the normal. Default: x, or y where
    /// the normal is near x.
    pub(in crate::config) along: Option<Triple>,
}

/// A solid that stands. Its features are surfaces: `"<obstacle>/<feature>"`.
///
/// ```toml
/// [[obstacle]]
/// name = "post"
/// shape = { kind = "cylinder", length_mm = 200, radius_mm = 20 }
/// position_mm = [300, 0, 100]
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an obstacle")]
#[schemars(rename = "obstacle")]
pub(in crate::config) struct RawObstacle {
    /// Its name.
    pub(in crate::config) name: Text,
    /// Its shape.
    pub(in crate::config) shape: Spanned<RawShape>,
    /// Where its origin is.
    pub(in crate::config) position_mm: Triple,
    /// How it is turned. Default: [1, 0, 0, 0].
    pub(in crate::config) orientation_wxyz: Option<Quadruple>,
    /// The same as angles about x, then y, then z of the axes in which it is given: roll, pitch, yaw.
    /// Default: `orientation_wxyz`.
    pub(in crate::config) rpy_deg: Option<Triple>,
}

/// What ties a body to another one or to the world; what joints connect moves as one (docs/joints.md).
///
/// ```toml
/// [[joint]]
/// name = "nail"
/// kind = "pin"
/// axis = [1, 0, 0]
/// parent_at_mm = [0, 0, 1500]
/// child = "pencil"
/// child_at_mm = [0, 0, 190]
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a joint")]
#[schemars(rename = "joint")]
pub(in crate::config) struct RawJoint {
    /// Its name.
    pub(in crate::config) name: Text,
    /// "pin", "universal", "ball" or "fixed".
    pub(in crate::config) kind: Text,
    /// The body that it hangs from. Default: the world.
    pub(in crate::config) parent: Option<Text>,
    /// The body that hangs.
    pub(in crate::config) child: Text,
    /// Where the joint is in the frame in which the parent is given. Default: its centre of mass, or
    /// the origin of the world.
    pub(in crate::config) parent_at_mm: Option<Triple>,
    /// Where it is in the frame in which the child is given. Default: its centre of mass.
    pub(in crate::config) child_at_mm: Option<Triple>,
    /// How the child is turned in its parent where all angles are zero. Default: not at all.
    pub(in crate::config) child_orientation_wxyz: Option<Quadruple>,
    /// Axis of a pin, in the axes of the parent.
    pub(in crate::config) axis: Option<Triple>,
    /// Axes of a universal joint, in the axes of the parent.
    pub(in crate::config) axes: Option<Spanned<[[f64; 3]; 2]>>,
    /// Moment against each rate. Default: none.
    pub(in crate::config) damping_n_m_s: Option<Number>,
    /// Spring to angle zero. Default: none.
    pub(in crate::config) stiffness_n_m: Option<Number>,
    /// Least and greatest angle about each axis. Default: none.
    pub(in crate::config) limits_deg: Option<Spanned<Vec<[f64; 2]>>>,
    /// The event from which on it ties: a start, a change at which it catches, or one from which on two bodies are one (docs/phases.md). Default: the start, where `until` is given.
    pub(in crate::config) from: Option<Text>,
    /// The event at which it lets go. Default: the end, where `from` is given.
    pub(in crate::config) until: Option<Text>,
}

impl RawJoint {
    /// Whether it ties for a part of the time.
    pub(in crate::config) fn is_for_a_while(&self) -> bool {
        self.from.is_some() || self.until.is_some()
    }
}
