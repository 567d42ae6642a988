//! TOML → checked scenes; CSV and TOML → rows of a written sketch ([`sketch_from_csv`]); URDF → the text of
//! a scene ([`scene_from_urdf`]); calibration files ([`Calibration`]), and scenes with them
//! ([`scene_calibrated`]); an object at hand or a mesh → the text of a scene ([`new_scene`]).
//!
//! `docs/scene.md` lists every key ([`scene_reference`]), [`scene_schema`] says the same to editors, and
//! [`check_scene`] says what a scene means.
//!
//! # The frame of a body
//!
//! A body is given in any frame: its shape, features, faces, mounts, joints, and the axes and points of its goals
//! are in that frame, and its poses are written in it. Centre of mass and principal axes are computed from shape and
//! mass, unless `moments_kg_m2` says that the axes are principal ones at the centre of mass, or `centre_mm` and
//! `inertia_kg_m2` say both. Quantities that are free are along the principal axes. A goal's position without a
//! point is that of the centre of mass. See `docs/scene_shapes.md`.
//!
//! Scenes are read in two steps. First the text is parsed into [`serde`] structs: every key that
//! may be left out is optional, unknown keys are refused, units are in the keys. Then a
//! [`Scene`](crate::motion::Scene) in SI units is made and checked; the stages do not check it
//! again. An error of either step is a [`SceneError`] that says where (line and column from 1) and
//! what was expected.
//!
//! `timing.stamps` says what the samples' stamps are: `"physical"` times; times of a performance
//! whose `"tempo"` is unknown; or `"edited"`, an edited sketch. In an edited sketch every body has
//! one stream per flight, on its topic with `/1`, `/2`, … after it, one more than it has
//! collisions. Each has physical times of its own, from any zero, and need not begin where another
//! ends: when a flight begins after the one before is estimated, as `<body>.clock.flight.2`, relative
//! to flights a sampling interval apart. An edited sketch needs no marks, and any that exist are not
//! read.
//!
//! A body's corners are in `features_mm`, its flat faces in `[[body.face]]` (`name`, `point_mm`,
//! `normal` out of the body).
//!
//! A body has, beside the features it declares, those of its shape (`corner +x -y +z`, `rim -z`,
//! [`features`](crate::physics::features)); of an obstacle these are surfaces, as in
//! `surface = "mug floor/end +z"`. What a collision does not name is inferred: among what may touch
//! are the features a body declares, or all of its shape's if it declares none, and every surface
//! and obstacle. `count = 6` or `count = [4, 8]` makes one entry stand for as many collisions as
//! there are marks: `bounce` becomes `bounce 1`, `bounce 2`, ….
//!
//! Restitution and friction belong to what touches. A body that has a `restitution` (and a
//! `friction`) has them at all its impacts, and they are free together, as `<body>.restitution`.
//! An event with a `restitution` has a law of its own, `<event>.restitution`; the bounces that a
//! `count` stands for share theirs. Where two bodies meet that both have one, the event has its own.
//! `tangential_restitution` beside a `friction` says how much of its velocity along the surface what
//! sticks springs back with, as a superball does. `bumper = true` beside an event's own `restitution` says that what is hit gives energy: it may
//! exceed 1 there, and only there.
//!
//! # What trackers see
//!
//! A body has one tracker that sees its pose, at `topic`, mounted as `tracker` says; or it lists what
//! trackers see of it as `[[body.track]]`, each with a `name` where there are several, a `topic`, and `sees`:
//! `"pose"`; `"point"`, the place of a feature (`point = "tip"`, or `"centre"`) or of where the `tracker` is;
//! `"orientation"`; or the `"direction"` of an `axis` of the body. `position_sd_mm` and `orientation_sd_deg`
//! are weights of its own, `weights = "messages"` those of covariances in its messages. Every key has its
//! example in `docs/tracks.md`.
//!
//! # Bodies in the hand
//!
//! `held = true` in a `[[body]]` says that somebody holds it: a racket, a paddle, a ramp that is
//! carried. It does not fly but moves as it was tracked, and what hits it bounces off without
//! deflecting it: the hand is stronger than the impact. It has a shape, features and a tracker, and no
//! mass. Its collisions are those of the bodies that it deflects, with `other = "racket"`. Its stream
//! is smoothed; `tracker_sd_mm` and `tracker_sd_deg` are the standard deviations of the tracker's noise
//! per axis, where they are known. See `docs/held.md`.
//!
//! # Times of events
//!
//! The time of an event is that of its mark, or it is estimated. `time = "fixed"` or `"free"` in an
//! `[[event]]` says which; left out, collisions and waypoints are free, a start is fixed, and an end is free only
//! where a goal holds there and the stamps are those of a tempo. The mark is a measurement of a free
//! time: `time_sd_ms` is its standard deviation if it is another than `timing.mark_sd_ms`.
//! `earliest_ms` and `latest_ms` are bounds that hold exactly, in acted time after the mark,
//! negative before it. Each of the three makes the time free.
//!
//! # Phases
//!
//! `[[phase]]` says that a body stays on a surface from one event to another: it slides, rolls or rests. `kind =
//! "change"` with a `body` is an event at which one phase follows another without an impact; its time is
//! estimated. See `docs/phases.md`.
//!
//! # Waypoints
//!
//! `kind = "waypoint"` with a `body` is a moment of that body's flight at which nothing touches: goals
//! hold there. It is marked as other events are, and comes in their order; the flight is not cut. Its time
//! is estimated: it stays within the flight and, with others of that body, in order. Without goals it is
//! where its mark is. See `docs/goals.md`.
//!
//! # Joints
//!
//! `[[joint]]` ties a body, its `child`, to a `parent`, which may be held, or to the world; what joints connect moves as one
//! mechanism. `docs/joints.md` has every key.
//!
//! # Goals
//!
//! What must hold at an event, for a body or for the time of the event: positions of points and contacts,
//! orientations, directions, velocities, spins and times, exactly or in boxes, balls, half-spaces, cones,
//! hard or with a weight, relative to the world or to another body. Every key has its example in
//! `docs/goals.md`.
//!
//! # Goals at rest
//!
//! A goal at rest is about what follows the last event, until all rests (`settle_s`): `event =
//! "rest"`, `body`, and `face_up`, the axis of the body (`"+z"`) or the face that is up then, in any
//! yaw, within `within_deg`; `direction` in place of up is any direction of the world. Where the
//! motion that fits best ends otherwise, the nearest that ends so is searched for, and the verdict is
//! `failed` where none is found. `labels = "free"` allows to turn the labels of the body's faces
//! instead, by a turn after which shape, moments and features are where they were: the motion is as
//! acted, its orientations are those of the relabelled body, and the account says so.
//!
//! # Free quantities
//!
//! `[[free]]` hands a `quantity` to the estimation. `initial` is where it begins, `lower` and `upper`
//! bound it, and a `prior_sd` draws it to where it begins, all in the unit of the
//! quantity. Values that correct the scene are 0 where it is right, factors are 1.
//!
//! | quantity | what it is | unit | initial | bounds |
//! |---|---|---|---|---|
//! | `gravity.x`, `gravity.y`, `gravity.z` | gravity | m/s² | the scene's | −∞, +∞ |
//! | `<body>.restitution`, `<event>.restitution` | coefficient of restitution | none | the scene's | 0, 1; of a bumper 0, 10 |
//! | `<body>.friction`, `<event>.friction` | coefficient of friction | none | the scene's | 0, +∞ |
//! | `<body>.tangential_restitution`, `<event>.tangential_restitution` | with how much of its velocity along the surface what sticks springs back | none | the scene's | 0, 1 |
//! | `<event>.tilt.0`, `<event>.tilt.1` | tilt of the normal that one impact sees | ° | 0 | −∞, +∞ |
//! | `<body>.force.x`, `<body>.force.y`, `<body>.force.z` | constant force per mass, world axes | m/s² | `force_m_s2` | −∞, +∞ |
//! | `<body>.drag.linear` | drag that grows with speed, per mass | 1/s | `drag_linear_per_s` | 0, +∞ |
//! | `<body>.drag.quadratic` | drag that grows with speed squared, per mass | 1/m | `drag_quadratic_per_m` | 0, +∞ |
//! | `<body>.lift` | lift of a ball that spins | none | `lift` | −∞, +∞ |
//! | `<body>.moment.x`, `<body>.moment.y`, `<body>.moment.z` | factor of a moment of inertia at fixed mass; equal ones have the first one's name | none | 1 | 0.01, +∞ |
//! | `<body>.mass` | factor of the mass, and of the moments with it | none | 1 | 0.01, +∞ |
//! | `<body>.centre.x`, `<body>.centre.y`, `<body>.centre.z` | centre of mass, from the origin of the body's shape | mm | 0 | −∞, +∞ |
//! | `<body>.tracker.x`, `<body>.tracker.y`, `<body>.tracker.z` | what to add to the tracker's position, body axes | mm | 0 | −∞, +∞ |
//! | `<body>.tracker.turn.x`, `<body>.tracker.turn.y`, `<body>.tracker.turn.z` | rotation of the tracker on the body, tracker axes | ° | 0 | −∞, +∞ |
//! | `<body>.clock.rate` | by how much the tracker's clock is slow: time is 1 + rate times what stamps say | % | 0 | −99, +∞ |
//! | `<body>.clock.offset` | what to add to the tracker's stamps | ms | 0 | −∞, +∞ |
//! | `<joint>.parent.x`, `<joint>.parent.y`, `<joint>.parent.z` | how far a joint is from where the scene has it, in the axes of what it hangs from | mm | 0 | −∞, +∞ |
//! | `<joint>.child.x`, `<joint>.child.y`, `<joint>.child.z` | the same in the axes of what hangs on it | mm | 0 | −∞, +∞ |
//! | `<event>.contact_duration` | how long the contact of a collision lasts, where stamps are physical times | ms | 0 | 0, +∞ |
//! | `<surface>.height` | how much higher the surface is, along its normal | mm | 0 | −∞, +∞ |
//! | `<surface>.tilt.0`, `<surface>.tilt.1` | rotation of the surface about its point | ° | 0 | −∞, +∞ |
//!
//! `quantity = "<event>.tilt"` or `"<surface>.tilt"` with `cone_deg` frees both tilts within a circle.
//!
//! What no performance can tell is refused with the reason: the mass of a body that meets no other
//! moving body, a clock's offset with no other clock, moments of a body that never collides as long
//! as all of them are free, a surface that nothing touches
//! ([`Untold`](crate::motion::Untold), [`Together`](crate::motion::Together)). A `prior_sd` on one of
//! those that count only together is enough.
//!
//! # Recording
//!
//! `[capture]` is how `enact capture` records: `folder`, `chunk_ms`, `sync_ms`, and for a tracker
//! whose stamps are not to be chosen by what its first sample has, `[[capture.tracker]]` with
//! `body`, `stamps` (`"sample"`, `"device"`, `"sequence"`, `"receipt"`) and, for `"sequence"`,
//! `rate_hz`: see [`CaptureSettings`] and [`StampSource`](crate::motion::StampSource). A process
//! that is killed loses at most what came in the last `chunk_ms`, a machine that fails what came
//! in the last `chunk_ms + sync_ms`. Takes begin and end on command; with
//! `pre_roll_s` a take begins with what came in so many seconds before its start. `viewer_port` serves
//! viewers, `metrics_port` the operator's page, health and metrics, both at the address `listen`;
//! pages in browsers from elsewhere may watch if they are among `origins`. Both answer who asks for `localhost`, for
//! an address in numbers, or for one of `hosts`.
#![doc = "\n"]
#![doc = include_str!("../../../docs/scene.md")]

mod board;
mod body;
mod calibration;
mod capture;
mod check;
mod counted;
mod error;
mod event;
mod frame;
mod free_flight;
mod goal;
mod held;
mod joint;
mod keyframes;
mod keys;
mod law;
mod material;
mod mesh;
mod new;
mod number;
mod parameter;
mod phase;
mod preset;
mod principal;
mod quantity;
mod raw;
mod reference;
mod rest;
mod scene;
mod shared;
mod solid;
mod spanned;
mod text;
mod track;
mod unit;
mod urdf;

pub use calibration::{
    BodyValues, CalibratedQuantity, CalibratedScene, Calibration, CalibrationError, EventValues,
    FreeValue, SceneValues, SourceLine, SurfaceValue, TrackValues, TrackerValue, body_axis,
    scene_calibrated,
};
pub use capture::CaptureSettings;
pub use check::{BodyCheck, EventCheck, SceneCheck, TopicCheck, check_scene};
pub use error::SceneError;
pub use keyframes::{sketch_from_csv, sketch_from_toml};
pub use material::{Coefficient, MATERIALS, Material};
pub use mesh::{MeshError, MeshFormat};
pub use new::{MadeScene, NewObject, NewScene, NewSceneError, new_scene};
pub use preset::{PRESETS, Preset};
pub use reference::{scene_reference, scene_schema};
pub use shared::share;
pub use text::{capture_from_toml, scene_from_toml};
pub use unit::Unit;
pub use urdf::{UrdfScene, scene_from_urdf};

#[cfg(test)]
mod tests;
