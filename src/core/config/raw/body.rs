//! Bodies, their parts, and what trackers see of them.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::super::spanned::Spanned;
use super::shape::{RawFace, RawShape};
use super::value::{Number, Quadruple, Text, Triple};

/// A rigid body. Its geometry is given in any frame: where its centre of mass is and how its principal
/// axes lie is computed from shape and mass, and its poses are written in the frame in which it is
/// given (docs/scene_shapes.md).
///
/// ```toml
/// [[body]]
/// name = "pencil"
/// # The origin is at the tip.
/// shape = { kind = "cylinder", length_mm = 190, radius_mm = 3.75, position_mm = [0, 0, 95] }
/// mass_g = 6
/// tracker = { position_mm = [12, -5, 135] }
/// restitution = 0.75
/// features_mm = { tip = [0, 0, 0], eraser = [0, 0, 190] }
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a body")]
#[schemars(rename = "body")]
pub(in crate::config) struct RawBody {
    /// Its name, in reports and topics.
    pub(in crate::config) name: Text,
    /// The topic of its tracker. Default: `/tracker/<name>/pose`.
    pub(in crate::config) topic: Option<Text>,
    /// Its shape; in place of it `[[body.part]]` where it has several.
    pub(in crate::config) shape: Option<Spanned<RawShape>>,
    /// Its parts, where it has several.
    #[serde(default)]
    pub(in crate::config) part: Vec<Spanned<RawPart>>,
    /// Its mass: one of `mass_g`, `mass_kg`, `density_kg_m3`, or those of its parts.
    pub(in crate::config) mass_g: Option<Number>,
    /// Its mass.
    pub(in crate::config) mass_kg: Option<Number>,
    /// Its density, uniform.
    pub(in crate::config) density_kg_m3: Option<Number>,
    /// Its centre of mass, where that is known otherwise than from shape and mass; with `inertia_kg_m2`
    /// or `moments_kg_m2`. Default: computed.
    pub(in crate::config) centre_mm: Option<Triple>,
    /// Its moments of inertia about the centre of mass, along the axes in which it is given, which are
    /// then principal ones. Default: computed.
    pub(in crate::config) moments_kg_m2: Option<Triple>,
    /// Its tensor of inertia about the centre of mass, along the axes in which it is given, as CAD
    /// programs print it: xx, yy, zz, xy, xz, yz; with `centre_mm`. Default: computed.
    pub(in crate::config) inertia_kg_m2: Option<Spanned<[f64; 6]>>,
    /// Where its tracker is on it. Default: at its origin, along its axes.
    pub(in crate::config) tracker: Option<Spanned<RawTracker>>,
    /// What trackers see of it, where it is not one pose (docs/tracks.md).
    #[serde(default)]
    pub(in crate::config) track: Vec<Spanned<RawTrack>>,
    /// Whether a tracker sees it; of joined bodies not all need one. Default: true.
    pub(in crate::config) tracked: Option<Spanned<bool>>,
    /// Whether somebody holds it, and it moves as it was tracked (docs/held.md). Default: false.
    pub(in crate::config) held: Option<Spanned<bool>>,
    /// Of a held body, standard deviation of its tracker's positions per axis. Default: as its stream
    /// shows.
    pub(in crate::config) tracker_sd_mm: Option<Number>,
    /// Of a held body, standard deviation of its tracker's orientations per axis. Default: as its
    /// stream shows.
    pub(in crate::config) tracker_sd_deg: Option<Number>,
    /// Coefficient of restitution at all its impacts. Default: each event has its own.
    pub(in crate::config) restitution: Option<Number>,
    /// Coefficient of friction at all its impacts, beside `restitution`. Default: 0.
    pub(in crate::config) friction: Option<Number>,
    /// Tangential restitution at all its impacts, beside `friction`: where a contact sticks, with how much of its velocity
    /// along the surface it springs back, from 0 to 1, as a superball does. Default: none.
    pub(in crate::config) tangential_restitution: Option<Number>,
    /// Standard deviation of `restitution` from one occasion to the next, of which `predict` makes its spread.
    /// Default: 0.
    pub(in crate::config) restitution_sd: Option<Number>,
    /// The same of `friction`. Default: 0.
    pub(in crate::config) friction_sd: Option<Number>,
    /// A constant force per mass, in the axes of the world. Default: none.
    pub(in crate::config) force_m_s2: Option<Triple>,
    /// Drag that grows with speed, per mass. Default: none.
    pub(in crate::config) drag_linear_per_s: Option<Number>,
    /// Drag that grows with the square of speed, per mass. Default: none.
    pub(in crate::config) drag_quadratic_per_m: Option<Number>,
    /// Lift of a ball that spins: it accelerates by `lift` times its angular velocity times, as vectors, its velocity. Of a
    /// ball of radius r and mass m in air of density ρ it is ρ C π r³/(2 m), with C about 1: 0.006 of a football or of a
    /// table-tennis ball. Default: none.
    pub(in crate::config) lift: Option<Number>,
    /// Points by which it may touch, by their names. Default: those of its shape.
    #[serde(default)]
    pub(in crate::config) features_mm: BTreeMap<Text, Triple>,
    /// Flat faces by which it may touch. Default: those of its shape.
    #[serde(default)]
    pub(in crate::config) face: Vec<RawFace>,
}

/// A part of a body: a shape at its place, with or without a mass of its own. Where no part has a mass
/// the body has one, spread evenly.
///
/// ```toml
/// [[body]]
/// name = "hammer"
/// restitution = 0.3
///
/// [[body.part]]
/// name = "handle"
/// shape = { kind = "cylinder", length_mm = 300, radius_mm = 14, position_mm = [0, 0, 150] }
/// density_kg_m3 = 700
///
/// [[body.part]]
/// name = "head"
/// shape = { kind = "cuboid", size_mm = [110, 28, 28], position_mm = [0, 0, 300] }
/// mass_g = 500
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a part of a body")]
#[schemars(rename = "body.part")]
pub(in crate::config) struct RawPart {
    /// Its name; its features are `<part>/<feature>`.
    pub(in crate::config) name: Text,
    /// Its shape, at its place in the body.
    pub(in crate::config) shape: Spanned<RawShape>,
    /// Its mass.
    pub(in crate::config) mass_g: Option<Number>,
    /// Its mass.
    pub(in crate::config) mass_kg: Option<Number>,
    /// Its density.
    pub(in crate::config) density_kg_m3: Option<Number>,
}

/// What a tracker sees of a body (docs/tracks.md).
///
/// ```toml
/// [[body.track]]
/// name = "camera"
/// sees = "point"
/// point = "centre"
/// position_sd_mm = 3
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a track")]
#[schemars(rename = "body.track")]
pub(in crate::config) struct RawTrack {
    /// Its name, where the body has several.
    pub(in crate::config) name: Option<Text>,
    /// Its topic. Default: `/tracker/<body>/<name>`.
    pub(in crate::config) topic: Option<Text>,
    /// "pose", "point", "orientation" or "direction". Default: "pose".
    pub(in crate::config) sees: Option<Text>,
    /// The feature whose place it sees, or "centre", the centre of mass.
    pub(in crate::config) point: Option<Text>,
    /// The axis whose direction it sees, in the axes in which the body is given.
    pub(in crate::config) axis: Option<Triple>,
    /// Where it is on the body. Default: at the origin of the body, along its axes.
    pub(in crate::config) tracker: Option<Spanned<RawTracker>>,
    /// Weight of its positions, as a standard deviation. Default: that of the scene.
    pub(in crate::config) position_sd_mm: Option<Number>,
    /// Weight of its orientations, as a standard deviation. Default: that of the scene.
    pub(in crate::config) orientation_sd_deg: Option<Number>,
    /// "messages": as the covariances in its messages say. Default: the weights of the scene.
    pub(in crate::config) weights: Option<Text>,
}

/// Where a tracker is on its body: its frame in the one in which the body is given.
///
/// ```toml
/// [[body]]
/// name = "box"
/// shape = { kind = "cuboid", size_mm = [80, 60, 40] }
/// mass_g = 150
/// restitution = 0.5
/// tracker = { position_mm = [0, 0, 32], orientation_wxyz = [0.7071, 0.7071, 0, 0] }
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "a table with `position_mm` and `orientation_wxyz`"
)]
#[schemars(rename = "tracker")]
pub(in crate::config) struct RawTracker {
    /// Its origin. Default: [0, 0, 0].
    pub(in crate::config) position_mm: Option<Triple>,
    /// Its orientation, as a unit quaternion. Default: [1, 0, 0, 0].
    pub(in crate::config) orientation_wxyz: Option<Quadruple>,
    /// The same as angles about x, then y, then z of the axes in which it is given: roll, pitch, yaw.
    /// Default: `orientation_wxyz`.
    pub(in crate::config) rpy_deg: Option<Triple>,
}
