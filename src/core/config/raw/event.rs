//! What happens, and what is wanted.

use schemars::JsonSchema;
use serde::Deserialize;

use super::super::spanned::Spanned;
use super::value::{Corners, Number, Quadruple, Text, Triple};

/// Something that happens. Each is marked while acting; what a collision does not name is inferred.
///
/// ```toml
/// [[event]]
/// name = "bounce"
/// kind = "collision"
/// body = "pencil"
/// feature = "tip"
/// surface = "table"
/// restitution = 0.75
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an event")]
#[schemars(rename = "event")]
pub(in crate::config) struct RawEvent {
    /// Its name, which marks have.
    pub(in crate::config) name: Text,
    /// "start", "collision", "change", "waypoint" or "end".
    pub(in crate::config) kind: Text,
    /// The body that collides, whose phase changes, or that flies by a waypoint.
    pub(in crate::config) body: Option<Text>,
    /// By what it touches. Default: inferred.
    pub(in crate::config) feature: Option<Text>,
    /// By what it touches, where these are up to three at once.
    pub(in crate::config) features: Option<Spanned<Vec<Text>>>,
    /// What it touches. Default: inferred.
    pub(in crate::config) surface: Option<Text>,
    /// The other body, where two collide.
    pub(in crate::config) other: Option<Text>,
    /// By what that touches. Default: inferred.
    pub(in crate::config) other_feature: Option<Text>,
    /// Coefficient of restitution. Default: that of the body.
    pub(in crate::config) restitution: Option<Number>,
    /// Whether what is hit gives energy, as a pinball's bumper does: its `restitution` may exceed 1. Default:
    /// false.
    pub(in crate::config) bumper: Option<Spanned<bool>>,
    /// Coefficient of friction. Default: that of the body, or none.
    pub(in crate::config) friction: Option<Number>,
    /// Tangential restitution. Default: that of the body, or none.
    pub(in crate::config) tangential_restitution: Option<Number>,
    /// How many collisions it stands for: a number, or the least and the greatest. Default: 1.
    pub(in crate::config) count: Option<Spanned<RawCount>>,
    /// "free" or "fixed" at its mark. Default: free for collisions and waypoints, and for an end with a
    /// goal where stamps are a tempo.
    pub(in crate::config) time: Option<Text>,
    /// Standard deviation of its mark. Default: that of `timing.mark_sd_ms`.
    pub(in crate::config) time_sd_ms: Option<Number>,
    /// Earliest time after its mark. Default: none.
    pub(in crate::config) earliest_ms: Option<Number>,
    /// Latest time after its mark. Default: none.
    pub(in crate::config) latest_ms: Option<Number>,
}

/// How often a collision happens: a number, or the least and the greatest.
#[derive(Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a number such as 6, or a range such as [4, 8]")]
pub(in crate::config) enum RawCount {
    Exact(usize),
    Range([usize; 2]),
}

/// What must hold at an event, whatever was acted; docs/goals.md has an example of every kind. Points
/// and axes of a body are in the frame in which it is given.
///
/// ```toml
/// [[goal]]
/// event = "landing"
/// body = "pencil"
/// axis = "+z"
/// within_deg = 10
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a goal")]
#[schemars(rename = "goal")]
pub(in crate::config) struct RawGoal {
    /// The event; "rest" is when all has come to rest.
    pub(in crate::config) event: Text,
    /// The body.
    pub(in crate::config) body: Option<Text>,
    /// The joint whose angles are meant.
    pub(in crate::config) joint: Option<Text>,
    /// Angles of the joint.
    pub(in crate::config) angles_deg: Option<Spanned<Vec<f64>>>,
    /// Least and greatest angles of the joint.
    pub(in crate::config) angles_within_deg: Option<Spanned<[Vec<f64>; 2]>>,
    /// Whether just after a collision. Default: false.
    pub(in crate::config) after: Option<Spanned<bool>>,
    /// Where the centre of mass, or `point_mm` or `feature`, is.
    pub(in crate::config) position_mm: Option<Triple>,
    /// A box in which that is, by two corners.
    pub(in crate::config) position_within_mm: Option<Corners>,
    /// How far from `position_mm` at most. Default: exactly there.
    pub(in crate::config) within_mm: Option<Number>,
    /// Makes it a wish with that standard deviation. Default: it is hard.
    pub(in crate::config) sd_mm: Option<Number>,
    /// A point of the body. Default: the centre of mass.
    pub(in crate::config) point_mm: Option<Triple>,
    /// A corner of the body.
    pub(in crate::config) feature: Option<Text>,
    /// Whether the point that touches is meant. Default: false.
    pub(in crate::config) contact: Option<Spanned<bool>>,
    /// Makes a half-space of a vector: from there on along this.
    pub(in crate::config) normal: Option<Triple>,
    /// A body in whose frame positions, orientations and directions are. Default: the world.
    pub(in crate::config) relative_to: Option<Text>,
    /// How the body is turned, as a unit quaternion.
    pub(in crate::config) orientation_wxyz: Option<Quadruple>,
    /// The same as angles about x, then y, then z of the world: roll, pitch, yaw.
    pub(in crate::config) rpy_deg: Option<Triple>,
    /// An axis of the body: "+x" … "-z", the name of a face, or three numbers.
    pub(in crate::config) axis: Option<Spanned<RawAxis>>,
    /// Where the axis points. Default: up.
    pub(in crate::config) direction: Option<Triple>,
    /// How far from `orientation_wxyz`, `axis` or `face_up` at most. Default: exactly; of `face_up` 10.
    pub(in crate::config) within_deg: Option<Number>,
    /// Makes it a wish with that standard deviation. Default: it is hard.
    pub(in crate::config) sd_deg: Option<Number>,
    /// Velocity of the centre of mass, or of the point.
    pub(in crate::config) velocity_m_s: Option<Triple>,
    /// A box in which that is, by two corners.
    pub(in crate::config) velocity_within_m_s: Option<Corners>,
    /// How far from `velocity_m_s` at most. Default: exactly.
    pub(in crate::config) within_m_s: Option<Number>,
    /// Makes it a wish with that standard deviation. Default: it is hard.
    pub(in crate::config) sd_m_s: Option<Number>,
    /// Angular velocity.
    pub(in crate::config) spin_rad_s: Option<Triple>,
    /// A box in which that is, by two corners.
    pub(in crate::config) spin_within_rad_s: Option<Corners>,
    /// How far from `spin_rad_s` at most. Default: exactly.
    pub(in crate::config) within_rad_s: Option<Number>,
    /// Makes it a wish with that standard deviation. Default: it is hard.
    pub(in crate::config) sd_rad_s: Option<Number>,
    /// "world", or "body": the axes of a spin. Default: "world".
    pub(in crate::config) axes: Option<Text>,
    /// Whether velocity and spin are zero. Default: false.
    pub(in crate::config) at_rest: Option<Spanned<bool>>,
    /// Time of the event.
    pub(in crate::config) time_ms: Option<Number>,
    /// Earliest and latest time of the event.
    pub(in crate::config) time_within_ms: Option<Spanned<[f64; 2]>>,
    /// The event from which times count. Default: the first sample.
    pub(in crate::config) since: Option<Text>,
    /// Makes it a wish with that standard deviation. Default: it is hard.
    pub(in crate::config) sd_ms: Option<Number>,
    /// At rest: the axis or the face of the body that is up.
    pub(in crate::config) face_up: Option<Text>,
    /// At rest: "free" allows to turn the labels of faces instead. Default: "fixed".
    pub(in crate::config) labels: Option<Text>,
}

/// An axis of a body: a name such as `+z`, or three numbers.
#[derive(Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "an axis such as \"+z\", a face's name, or three numbers"
)]
pub(in crate::config) enum RawAxis {
    Name(String),
    Vector([f64; 3]),
}
