//! The scene file as it is written: all keys with their units; only types are checked.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::spanned::Spanned;

pub(super) type Number = Spanned<f64>;
pub(super) type Triple = Spanned<[f64; 3]>;
pub(super) type Quadruple = Spanned<[f64; 4]>;
pub(super) type Text = Spanned<String>;
/// Lower and upper corner of a box.
pub(super) type Corners = Spanned<[[f64; 3]; 2]>;

/// A scene: what moves, what stands, what happens, what is wanted. The least is a name, `[timing]` and
/// one `[[body]]`.
///
/// ```toml
/// name = "a ball on a table"
/// settle_s = 3
///
/// [timing]
/// stamps = "tempo"
///
/// [[body]]
/// name = "ball"
/// shape = { kind = "sphere", radius_mm = 33 }
/// mass_g = 58
/// restitution = 0.7
///
/// [[surface]]
/// name = "table"
/// point_mm = [0, 0, 0]
/// normal = [0, 0, 1]
///
/// [[event]]
/// name = "bounce"
/// kind = "collision"
/// body = "ball"
///
/// [[event]]
/// name = "landing"
/// kind = "end"
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a scene")]
#[schemars(rename = "scene")]
pub(super) struct RawScene {
    /// Its name, in reports.
    pub(super) name: Text,
    /// Gravity, in the axes of the world, which are those of the trackers. Default: [0, 0, -9.80665].
    pub(super) gravity_m_s2: Option<Triple>,
    /// The topic of the marks. Default: "/marks".
    pub(super) marks_topic: Option<Text>,
    /// What the stamps of samples mean.
    pub(super) timing: RawTiming,
    /// Whether velocities may jump where physics has them continuous: "when needed" where no motion
    /// does without, "always" from the start, "never". Default: "when needed".
    pub(super) velocity_gaps: Option<Text>,
    /// How long the motion goes on by simulation after its end, until all rests, at most. Default: it
    /// ends where the performance does.
    pub(super) settle_s: Option<Number>,
    /// How `enact capture` records.
    pub(super) capture: Option<RawCapture>,
    /// How well the performance shows what was meant.
    pub(super) weights: Option<RawWeights>,
    /// What moves, or is in the hand.
    #[serde(default)]
    pub(super) body: Vec<Spanned<RawBody>>,
    /// What ties bodies together (docs/joints.md).
    #[serde(default)]
    pub(super) joint: Vec<Spanned<RawJoint>>,
    /// What stands and is flat.
    #[serde(default)]
    pub(super) surface: Vec<RawSurface>,
    /// What stands and is solid.
    #[serde(default)]
    pub(super) obstacle: Vec<RawObstacle>,
    /// What happens, in order of time.
    #[serde(default)]
    pub(super) event: Vec<Spanned<RawEvent>>,
    /// What must hold at an event (docs/goals.md).
    #[serde(default)]
    pub(super) goal: Vec<Spanned<RawGoal>>,
    /// What is estimated beside the motion.
    #[serde(default)]
    pub(super) free: Vec<RawFree>,
}

/// What the stamps of samples mean.
///
/// ```toml
/// [timing]
/// stamps = "tempo"
/// mark_sd_ms = 30
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table with `stamps`")]
#[schemars(rename = "timing")]
pub(super) struct RawTiming {
    /// "physical": the times are those of the motion; "tempo": it was acted in a tempo that is not
    /// known; "edited": every flight is on a topic of its own, `<topic>/1`, `<topic>/2`, …, with times
    /// from any zero.
    pub(super) stamps: Text,
    /// How much a tempo wavers, as the standard deviation of its logarithm after one second. Default:
    /// 0.5.
    pub(super) tempo_sd_per_sqrt_s: Option<Number>,
    /// Standard deviation of marks. Default: half a sample's interval where stamps are physical, 50
    /// where they are not.
    pub(super) mark_sd_ms: Option<Number>,
}

/// How far a performance is from what was meant, per axis, as standard deviations.
///
/// ```toml
/// [weights]
/// position_mm = 10
/// orientation_deg = 5
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table of weights")]
#[schemars(rename = "weights")]
pub(super) struct RawWeights {
    /// Of positions. Default: 10.
    pub(super) position_mm: Option<Number>,
    /// Of orientations. Default: 5.73 (0.1 rad).
    pub(super) orientation_deg: Option<Number>,
}

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
pub(super) struct RawBody {
    /// Its name, in reports and topics.
    pub(super) name: Text,
    /// The topic of its tracker. Default: `/tracker/<name>/pose`.
    pub(super) topic: Option<Text>,
    /// Its shape; in place of it `[[body.part]]` where it has several.
    pub(super) shape: Option<Spanned<RawShape>>,
    /// Its parts, where it has several.
    #[serde(default)]
    pub(super) part: Vec<Spanned<RawPart>>,
    /// Its mass: one of `mass_g`, `mass_kg`, `density_kg_m3`, or those of its parts.
    pub(super) mass_g: Option<Number>,
    /// Its mass.
    pub(super) mass_kg: Option<Number>,
    /// Its density, uniform.
    pub(super) density_kg_m3: Option<Number>,
    /// Its centre of mass, where that is known otherwise than from shape and mass; with `inertia_kg_m2`
    /// or `moments_kg_m2`. Default: computed.
    pub(super) centre_mm: Option<Triple>,
    /// Its moments of inertia about the centre of mass, along the axes in which it is given, which are
    /// then principal ones. Default: computed.
    pub(super) moments_kg_m2: Option<Triple>,
    /// Its tensor of inertia about the centre of mass, along the axes in which it is given, as CAD
    /// programs print it: xx, yy, zz, xy, xz, yz; with `centre_mm`. Default: computed.
    pub(super) inertia_kg_m2: Option<Spanned<[f64; 6]>>,
    /// Where its tracker is on it. Default: at its origin, along its axes.
    pub(super) tracker: Option<Spanned<RawTracker>>,
    /// What trackers see of it, where it is not one pose (docs/tracks.md).
    #[serde(default)]
    pub(super) track: Vec<Spanned<RawTrack>>,
    /// Whether a tracker sees it; of joined bodies not all need one. Default: true.
    pub(super) tracked: Option<Spanned<bool>>,
    /// Whether somebody holds it, and it moves as it was tracked (docs/held.md). Default: false.
    pub(super) held: Option<Spanned<bool>>,
    /// Of a held body, standard deviation of its tracker's positions per axis. Default: as its stream
    /// shows.
    pub(super) tracker_sd_mm: Option<Number>,
    /// Of a held body, standard deviation of its tracker's orientations per axis. Default: as its
    /// stream shows.
    pub(super) tracker_sd_deg: Option<Number>,
    /// Coefficient of restitution at all its impacts. Default: each event has its own.
    pub(super) restitution: Option<Number>,
    /// Coefficient of friction at all its impacts, beside `restitution`. Default: 0.
    pub(super) friction: Option<Number>,
    /// Standard deviation of `restitution` from one occasion to the next, of which `predict` makes its spread.
    /// Default: 0.
    pub(super) restitution_sd: Option<Number>,
    /// The same of `friction`. Default: 0.
    pub(super) friction_sd: Option<Number>,
    /// A constant force per mass, in the axes of the world. Default: none.
    pub(super) force_m_s2: Option<Triple>,
    /// Drag that grows with speed, per mass. Default: none.
    pub(super) drag_linear_per_s: Option<Number>,
    /// Drag that grows with the square of speed, per mass. Default: none.
    pub(super) drag_quadratic_per_m: Option<Number>,
    /// Points by which it may touch, by their names. Default: those of its shape.
    #[serde(default)]
    pub(super) features_mm: BTreeMap<Text, Triple>,
    /// Flat faces by which it may touch. Default: those of its shape.
    #[serde(default)]
    pub(super) face: Vec<RawFace>,
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
pub(super) struct RawPart {
    /// Its name; its features are `<part>/<feature>`.
    pub(super) name: Text,
    /// Its shape, at its place in the body.
    pub(super) shape: Spanned<RawShape>,
    /// Its mass.
    pub(super) mass_g: Option<Number>,
    /// Its mass.
    pub(super) mass_kg: Option<Number>,
    /// Its density.
    pub(super) density_kg_m3: Option<Number>,
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
pub(super) struct RawJoint {
    /// Its name.
    pub(super) name: Text,
    /// "pin", "universal", "ball" or "fixed".
    pub(super) kind: Text,
    /// The body that it hangs from. Default: the world.
    pub(super) parent: Option<Text>,
    /// The body that hangs.
    pub(super) child: Text,
    /// Where the joint is in the frame in which the parent is given. Default: its centre of mass, or
    /// the origin of the world.
    pub(super) parent_at_mm: Option<Triple>,
    /// Where it is in the frame in which the child is given. Default: its centre of mass.
    pub(super) child_at_mm: Option<Triple>,
    /// How the child is turned in its parent where all angles are zero. Default: not at all.
    pub(super) child_orientation_wxyz: Option<Quadruple>,
    /// Axis of a pin, in the axes of the parent.
    pub(super) axis: Option<Triple>,
    /// Axes of a universal joint, in the axes of the parent.
    pub(super) axes: Option<Spanned<[[f64; 3]; 2]>>,
    /// Moment against each rate. Default: none.
    pub(super) damping_n_m_s: Option<Number>,
    /// Spring to angle zero. Default: none.
    pub(super) stiffness_n_m: Option<Number>,
    /// Least and greatest angle about each axis. Default: none.
    pub(super) limits_deg: Option<Spanned<Vec<[f64; 2]>>>,
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
pub(super) struct RawTrack {
    /// Its name, where the body has several.
    pub(super) name: Option<Text>,
    /// Its topic. Default: `/tracker/<body>/<name>`.
    pub(super) topic: Option<Text>,
    /// "pose", "point", "orientation" or "direction". Default: "pose".
    pub(super) sees: Option<Text>,
    /// The feature whose place it sees, or "centre", the centre of mass.
    pub(super) point: Option<Text>,
    /// The axis whose direction it sees, in the axes in which the body is given.
    pub(super) axis: Option<Triple>,
    /// Where it is on the body. Default: at the origin of the body, along its axes.
    pub(super) tracker: Option<Spanned<RawTracker>>,
    /// Weight of its positions, as a standard deviation. Default: that of the scene.
    pub(super) position_sd_mm: Option<Number>,
    /// Weight of its orientations, as a standard deviation. Default: that of the scene.
    pub(super) orientation_sd_deg: Option<Number>,
    /// "messages": as the covariances in its messages say. Default: the weights of the scene.
    pub(super) weights: Option<Text>,
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
pub(super) struct RawTracker {
    /// Its origin. Default: [0, 0, 0].
    pub(super) position_mm: Option<Triple>,
    /// Its orientation, as a unit quaternion. Default: [1, 0, 0, 0].
    pub(super) orientation_wxyz: Option<Quadruple>,
    /// The same as angles about x, then y, then z of the axes in which it is given: roll, pitch, yaw.
    /// Default: `orientation_wxyz`.
    pub(super) rpy_deg: Option<Triple>,
}

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
pub(super) struct RawShape {
    /// What it is.
    pub(super) kind: Text,
    /// Sides of a box, outside.
    pub(super) size_mm: Option<Triple>,
    /// Radius.
    pub(super) radius_mm: Option<Number>,
    /// Length along z; of a capsule between the centres of its caps.
    pub(super) length_mm: Option<Number>,
    /// Height of a cone.
    pub(super) height_mm: Option<Number>,
    /// Points of a hull.
    pub(super) points_mm: Option<Spanned<Vec<[f64; 3]>>>,
    /// A profile as distances from the axis and heights, [[r, z], …]. Filled up to the axis where there
    /// is no `wall_mm`: heights then rise.
    pub(super) profile_mm: Option<Spanned<Vec<[f64; 2]>>>,
    /// Points of each hull.
    pub(super) pieces_mm: Option<Spanned<Vec<Vec<[f64; 3]>>>>,
    /// Thickness of the wall of what is hollow. Of a revolution it is on the left of the profile as
    /// that is written; of others the cavity is closed. Default: filled.
    pub(super) wall_mm: Option<Number>,
    /// Where its origin is in the frame of the body, part or obstacle. Default: [0, 0, 0].
    pub(super) position_mm: Option<Triple>,
    /// How it is turned there, as a unit quaternion. Default: [1, 0, 0, 0].
    pub(super) orientation_wxyz: Option<Quadruple>,
    /// The same as angles about x, then y, then z of the axes in which it is given: roll, pitch, yaw.
    /// Default: `orientation_wxyz`.
    pub(super) rpy_deg: Option<Triple>,
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
pub(super) struct RawFace {
    /// Its name.
    pub(super) name: Text,
    /// A point on it.
    pub(super) point_mm: Triple,
    /// Its normal, out of the body; any length.
    pub(super) normal: Triple,
}

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
pub(super) struct RawSurface {
    /// Its name.
    pub(super) name: Text,
    /// A point on it; of a board the middle.
    pub(super) point_mm: Triple,
    /// Its normal, out of the solid; any length.
    pub(super) normal: Triple,
    /// Sides of a board. Default: it has no end.
    pub(super) size_mm: Option<Spanned<[f64; 2]>>,
    /// Thickness of a board, below the surface. Default: 10.
    pub(super) thickness_mm: Option<Number>,
    /// Direction of the first side of a board, as far as it is across the normal. Default: x, or y where
    /// the normal is near x.
    pub(super) along: Option<Triple>,
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
pub(super) struct RawObstacle {
    /// Its name.
    pub(super) name: Text,
    /// Its shape.
    pub(super) shape: Spanned<RawShape>,
    /// Where its origin is.
    pub(super) position_mm: Triple,
    /// How it is turned. Default: [1, 0, 0, 0].
    pub(super) orientation_wxyz: Option<Quadruple>,
    /// The same as angles about x, then y, then z of the axes in which it is given: roll, pitch, yaw.
    /// Default: `orientation_wxyz`.
    pub(super) rpy_deg: Option<Triple>,
}

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
pub(super) struct RawEvent {
    /// Its name, which marks have.
    pub(super) name: Text,
    /// "start", "collision", "waypoint" or "end".
    pub(super) kind: Text,
    /// The body that collides, or flies by a waypoint.
    pub(super) body: Option<Text>,
    /// By what it touches. Default: inferred.
    pub(super) feature: Option<Text>,
    /// By what it touches, where these are up to three at once.
    pub(super) features: Option<Spanned<Vec<Text>>>,
    /// What it touches. Default: inferred.
    pub(super) surface: Option<Text>,
    /// The other body, where two collide.
    pub(super) other: Option<Text>,
    /// By what that touches. Default: inferred.
    pub(super) other_feature: Option<Text>,
    /// Coefficient of restitution. Default: that of the body.
    pub(super) restitution: Option<Number>,
    /// Coefficient of friction. Default: that of the body, or none.
    pub(super) friction: Option<Number>,
    /// How many collisions it stands for: a number, or the least and the greatest. Default: 1.
    pub(super) count: Option<Spanned<RawCount>>,
    /// "free" or "fixed" at its mark. Default: free for collisions and waypoints, and for an end with a
    /// goal where stamps are a tempo.
    pub(super) time: Option<Text>,
    /// Standard deviation of its mark. Default: `timing.mark_sd_ms`; of a waypoint 50 where that is not
    /// given.
    pub(super) time_sd_ms: Option<Number>,
    /// Earliest time after its mark. Default: none.
    pub(super) earliest_ms: Option<Number>,
    /// Latest time after its mark. Default: none.
    pub(super) latest_ms: Option<Number>,
}

/// How often a collision happens: a number, or the least and the greatest.
#[derive(Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a number such as 6, or a range such as [4, 8]")]
pub(super) enum RawCount {
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
pub(super) struct RawGoal {
    /// The event; "rest" is when all has come to rest.
    pub(super) event: Text,
    /// The body.
    pub(super) body: Option<Text>,
    /// The joint whose angles are meant.
    pub(super) joint: Option<Text>,
    /// Angles of the joint.
    pub(super) angles_deg: Option<Spanned<Vec<f64>>>,
    /// Least and greatest angles of the joint.
    pub(super) angles_within_deg: Option<Spanned<[Vec<f64>; 2]>>,
    /// Whether just after a collision. Default: false.
    pub(super) after: Option<Spanned<bool>>,
    /// Where the centre of mass, or `point_mm` or `feature`, is.
    pub(super) position_mm: Option<Triple>,
    /// A box in which that is, by two corners.
    pub(super) position_within_mm: Option<Corners>,
    /// How far from `position_mm` at most. Default: exactly there.
    pub(super) within_mm: Option<Number>,
    /// Makes it a wish with that standard deviation. Default: it is hard.
    pub(super) sd_mm: Option<Number>,
    /// A point of the body. Default: the centre of mass.
    pub(super) point_mm: Option<Triple>,
    /// A corner of the body.
    pub(super) feature: Option<Text>,
    /// Whether the point that touches is meant. Default: false.
    pub(super) contact: Option<Spanned<bool>>,
    /// Makes a half-space of a vector: from there on along this.
    pub(super) normal: Option<Triple>,
    /// A body in whose frame positions, orientations and directions are. Default: the world.
    pub(super) relative_to: Option<Text>,
    /// How the body is turned, as a unit quaternion.
    pub(super) orientation_wxyz: Option<Quadruple>,
    /// The same as angles about x, then y, then z of the world: roll, pitch, yaw.
    pub(super) rpy_deg: Option<Triple>,
    /// An axis of the body: "+x" … "-z", the name of a face, or three numbers.
    pub(super) axis: Option<Spanned<RawAxis>>,
    /// Where the axis points. Default: up.
    pub(super) direction: Option<Triple>,
    /// How far from `orientation_wxyz`, `axis` or `face_up` at most. Default: exactly; of `face_up` 10.
    pub(super) within_deg: Option<Number>,
    /// Makes it a wish with that standard deviation. Default: it is hard.
    pub(super) sd_deg: Option<Number>,
    /// Velocity of the centre of mass, or of the point.
    pub(super) velocity_m_s: Option<Triple>,
    /// A box in which that is, by two corners.
    pub(super) velocity_within_m_s: Option<Corners>,
    /// How far from `velocity_m_s` at most. Default: exactly.
    pub(super) within_m_s: Option<Number>,
    /// Makes it a wish with that standard deviation. Default: it is hard.
    pub(super) sd_m_s: Option<Number>,
    /// Angular velocity.
    pub(super) spin_rad_s: Option<Triple>,
    /// A box in which that is, by two corners.
    pub(super) spin_within_rad_s: Option<Corners>,
    /// How far from `spin_rad_s` at most. Default: exactly.
    pub(super) within_rad_s: Option<Number>,
    /// Makes it a wish with that standard deviation. Default: it is hard.
    pub(super) sd_rad_s: Option<Number>,
    /// "world", or "body": the axes of a spin. Default: "world".
    pub(super) axes: Option<Text>,
    /// Whether velocity and spin are zero. Default: false.
    pub(super) at_rest: Option<Spanned<bool>>,
    /// Time of the event.
    pub(super) time_ms: Option<Number>,
    /// Earliest and latest time of the event.
    pub(super) time_within_ms: Option<Spanned<[f64; 2]>>,
    /// The event from which times count. Default: the first sample.
    pub(super) since: Option<Text>,
    /// Makes it a wish with that standard deviation. Default: it is hard.
    pub(super) sd_ms: Option<Number>,
    /// At rest: the axis or the face of the body that is up.
    pub(super) face_up: Option<Text>,
    /// At rest: "free" allows to turn the labels of faces instead. Default: "fixed".
    pub(super) labels: Option<Text>,
}

/// An axis of a body: a name such as `+z`, or three numbers.
#[derive(Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "an axis such as \"+z\", a face's name, or three numbers"
)]
pub(super) enum RawAxis {
    Name(String),
    Vector([f64; 3]),
}

/// A free quantity, with a number of each key in each unit.
macro_rules! raw_free {
    ($($about:literal: $($key:ident)*;)*) => {
        /// A quantity that is estimated. Its keys end in the unit of the quantity; the documentation of
        /// `enact::config` lists all quantities.
        ///
        /// ```toml
        /// [[free]]
        /// quantity = "bounce.restitution"
        /// lower = 0.5
        /// upper = 0.9
        /// ```
        #[derive(Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, expecting = "a free quantity")]
        #[schemars(rename = "free")]
        pub(super) struct RawFree {
            /// Its name, such as `bounce.restitution` or `table.height`.
            pub(super) quantity: Text,
            $($(#[doc = $about] $key: Option<Number>,)*)*
            /// Half the opening of a cone in which both tilts of a normal are.
            pub(super) cone_deg: Option<Number>,
        }

        impl RawFree {
            /// The number at a key, if it is given.
            pub(super) fn number(&self, key: &str) -> Option<&Number> {
                match key {
                    $($(stringify!($key) => self.$key.as_ref(),)*)*
                    _ => None,
                }
            }
        }
    };
}

raw_free! {
    "Where it begins. Default: what the scene says, or 0, or of a factor 1.":
    initial initial_m_s2 initial_deg initial_mm initial_ms initial_percent
    initial_per_s initial_per_m;
    "Least value. Default: the least there is.":
    lower lower_m_s2 lower_deg lower_mm lower_ms lower_percent lower_per_s lower_per_m;
    "Greatest value. Default: the greatest there is.":
    upper upper_m_s2 upper_deg upper_mm upper_ms upper_percent upper_per_s upper_per_m;
    "How well it is known beforehand, as a standard deviation about where it begins. Default: not at all.":
    prior_sd prior_sd_m_s2 prior_sd_deg prior_sd_mm prior_sd_ms prior_sd_percent
    prior_sd_per_s prior_sd_per_m;
}

/// How `enact capture` records.
///
/// ```toml
/// [capture]
/// folder = "takes"
/// viewer_port = 8765
/// ```
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table of capture settings")]
#[schemars(rename = "capture")]
pub(super) struct RawCapture {
    /// Folder of the takes. Default: "takes".
    pub(super) folder: Option<Text>,
    /// Longest time that samples are only in memory. Default: 100.
    pub(super) chunk_ms: Option<Number>,
    /// How often the journal is written through to the disk. Default: 1000.
    pub(super) sync_ms: Option<Number>,
    /// Address of viewers and metrics. Default: "127.0.0.1".
    pub(super) listen: Option<Text>,
    /// Port for viewers, 0 for any. Default: not served.
    pub(super) viewer_port: Option<Number>,
    /// Port for health and metrics, 0 for any. Default: not served.
    pub(super) metrics_port: Option<Number>,
    /// Pages in browsers that may watch from elsewhere. Default: those of this machine and of known viewers.
    pub(super) origins: Option<Vec<Text>>,
    /// So much of what came in before its start a take begins with. Default: 0.
    pub(super) pre_roll_s: Option<Number>,
    /// Whose stamps are not chosen by what its first sample has.
    #[serde(default)]
    pub(super) tracker: Vec<RawTrackerClock>,
}

/// The stamps of a live tracker.
///
/// ```toml
/// [[capture.tracker]]
/// body = "pencil"
/// stamps = "sequence"
/// rate_hz = 120
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table with `body` and `stamps`")]
#[schemars(rename = "capture.tracker")]
pub(super) struct RawTrackerClock {
    /// The body, or the track as `<body>.<name>`.
    pub(super) body: Text,
    /// "sample", "device", "sequence" or "receipt". Default: "sample" if the first sample has that,
    /// else "device", else "receipt".
    pub(super) stamps: Text,
    /// Rate of "sequence".
    pub(super) rate_hz: Option<Number>,
}
