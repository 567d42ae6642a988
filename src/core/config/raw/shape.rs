//! Shapes and faces.

use schemars::JsonSchema;
use serde::Deserialize;

use super::super::spanned::Spanned;
use super::value::{Number, Quadruple, Text, Triple};

/// A shape, about the origin of its own frame; cylinders, capsules, cones and what is turned are about
/// z.
///
/// | `kind` | needs | what it is |
/// |---|---|---|
/// | `"cuboid"` | `size_mm` | a box |
/// | `"rounded_cuboid"` | `size_mm`, `radius_mm` | a box with rounded edges |
/// | `"sphere"` | `radius_mm` | a ball |
/// | `"cylinder"` | `length_mm`, `radius_mm` | a cylinder |
/// | `"capsule"` | `length_mm`, `radius_mm` | a cylinder between two half balls, whose centres are so far apart |
/// | `"cone"` | `height_mm`, `radius_mm` | a cone, apex up; its origin is a quarter of the height above the base |
/// | `"hull"` | `points_mm` | the convex hull of points |
/// | `"revolution"` | `profile_mm` | what a profile sweeps about z; open with `wall_mm` |
/// | `"pieces"` | `pieces_mm` | hulls side by side, as `enact scene new` makes them of a mesh |
///
/// ```toml
/// [[obstacle]]
/// name = "mug"
/// # Outwards below, then up: 80 mm wide, 95 mm high, open above.
/// shape = { kind = "revolution", profile_mm = [[0, 0], [40, 0], [40, 95]], wall_mm = 4 }
/// position_mm = [0, 0, 0]
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "a shape such as { kind = \"sphere\", radius_mm = 10 }"
)]
#[schemars(rename = "shape")]
pub(in crate::config) struct RawShape {
    /// What it is.
    pub(in crate::config) kind: Text,
    /// Sides of a box, outside.
    pub(in crate::config) size_mm: Option<Triple>,
    /// Radius.
    pub(in crate::config) radius_mm: Option<Number>,
    /// Length along z; of a capsule between the centres of its caps.
    pub(in crate::config) length_mm: Option<Number>,
    /// Height of a cone.
    pub(in crate::config) height_mm: Option<Number>,
    /// Points of a hull.
    pub(in crate::config) points_mm: Option<Spanned<Vec<[f64; 3]>>>,
    /// A profile as distances from the axis and heights, [[r, z], …]. Filled up to the axis where there
    /// is no `wall_mm`: heights then rise.
    pub(in crate::config) profile_mm: Option<Spanned<Vec<[f64; 2]>>>,
    /// Points of each hull.
    pub(in crate::config) pieces_mm: Option<Spanned<Vec<Vec<[f64; 3]>>>>,
    /// Thickness of the wall of what is hollow. Of a revolution it is on the left of the profile as
    /// that is written; of others the cavity is closed. Default: filled.
    pub(in crate::config) wall_mm: Option<Number>,
    /// Where its origin is in the frame of the body, part or obstacle. Default: [0, 0, 0].
    pub(in crate::config) position_mm: Option<Triple>,
    /// How it is turned there, as a unit quaternion. Default: [1, 0, 0, 0].
    pub(in crate::config) orientation_wxyz: Option<Quadruple>,
    /// The same as angles about x, then y, then z of the axes in which it is given: roll, pitch, yaw.
    /// Default: `orientation_wxyz`.
    pub(in crate::config) rpy_deg: Option<Triple>,
}

/// A flat face of a body by which it may touch, in the frame in which the body is given.
///
/// ```toml
/// [[body]]
/// name = "hat"
/// shape = { kind = "revolution", profile_mm = [[140, 0], [100, 0], [100, 100], [0, 100]], wall_mm = 3 }
/// mass_g = 90
/// restitution = 0.1
///
/// [[body.face]]
/// name = "inside"
/// point_mm = [0, 0, 97]
/// normal = [0, 0, -1]
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "a table with `name`, `point_mm` and `normal`"
)]
#[schemars(rename = "body.face")]
pub(in crate::config) struct RawFace {
    /// Its name.
    pub(in crate::config) name: Text,
    /// A point on it.
    pub(in crate::config) point_mm: Triple,
    /// Its normal, out of the body; any length.
    pub(in crate::config) normal: Triple,
}
