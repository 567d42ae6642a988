//! TOML → checked scenes; CSV and TOML → rows of a written sketch ([`sketch_from_csv`]); URDF → the text of
//! a scene ([`scene_from_urdf`]).
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
//! bound it, and a `prior_sd` draws it to where it begins. The unit is a suffix of these keys:
//! `lower_mm`. Values that correct the scene are 0 where it is right, factors are 1.
//!
//! | quantity | what it is | suffix | initial | bounds |
//! |---|---|---|---|---|
//! | `gravity.x`, `gravity.y`, `gravity.z` | gravity | `_m_s2` | the scene's | −∞, +∞ |
//! | `<body>.restitution`, `<event>.restitution` | coefficient of restitution | none | the scene's | 0, 1 |
//! | `<body>.friction`, `<event>.friction` | coefficient of friction | none | the scene's | 0, +∞ |
//! | `<event>.tilt.0`, `<event>.tilt.1` | tilt of the normal that one impact sees | `_deg` | 0 | −∞, +∞ |
//! | `<body>.force.x`, `<body>.force.y`, `<body>.force.z` | constant force per mass, world axes | `_m_s2` | `force_m_s2` | −∞, +∞ |
//! | `<body>.drag.linear` | drag that grows with speed, per mass | `_per_s` | `drag_linear_per_s` | 0, +∞ |
//! | `<body>.drag.quadratic` | drag that grows with speed squared, per mass | `_per_m` | `drag_quadratic_per_m` | 0, +∞ |
//! | `<body>.moment.x`, `<body>.moment.y`, `<body>.moment.z` | factor of a moment of inertia at fixed mass; equal ones have the first one's name | none | 1 | 0.01, +∞ |
//! | `<body>.mass` | factor of the mass, and of the moments with it | none | 1 | 0.01, +∞ |
//! | `<body>.centre.x`, `<body>.centre.y`, `<body>.centre.z` | centre of mass, from the origin of the body's shape | `_mm` | 0 | −∞, +∞ |
//! | `<body>.tracker.x`, `<body>.tracker.y`, `<body>.tracker.z` | what to add to the tracker's position, body axes | `_mm` | 0 | −∞, +∞ |
//! | `<body>.tracker.turn.x`, `<body>.tracker.turn.y`, `<body>.tracker.turn.z` | rotation of the tracker on the body, tracker axes | `_deg` | 0 | −∞, +∞ |
//! | `<body>.clock.rate` | by how much the tracker's clock is slow: time is 1 + rate times what stamps say | `_percent` | 0 | −99, +∞ |
//! | `<body>.clock.offset` | what to add to the tracker's stamps | `_ms` | 0 | −∞, +∞ |
//! | `<surface>.height` | how much higher the surface is, along its normal | `_mm` | 0 | −∞, +∞ |
//! | `<surface>.tilt.0`, `<surface>.tilt.1` | rotation of the surface about its point | `_deg` | 0 | −∞, +∞ |
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
//! pages in browsers from elsewhere may watch if they are among `origins`.
//!
//! # Defaults
//!
//!
//! | key | default |
//! |---|---|
//! | `gravity_m_s2` | `[0, 0, -9.80665]` |
//! | `marks_topic` | `"/marks"` |
//! | `capture.folder` | `"takes"` |
//! | `capture.chunk_ms`, `capture.sync_ms` | 100 ms, 1000 ms |
//! | `capture.viewer_port`, `capture.metrics_port` | not served |
//! | `capture.listen` | `"127.0.0.1"` |
//! | `capture.origins` | none: pages of this machine and of known viewers may watch |
//! | `capture.pre_roll_s` | 0: a take begins at its start |
//! | `capture.tracker.stamps` | `"sample"` if the first valid sample has that time, else `"device"` if it has that, else `"receipt"` |
//! | `settle_s` | the motion ends where the performance does |
//! | `timing.tempo_sd_per_sqrt_s` | 0.5 |
//! | `timing.mark_sd_ms`, the standard deviation of marks | half a sample's interval where stamps are physical times, as annotators mark; 50 ms where they are not, as people press a button |
//! | `weights.position_mm`, `weights.orientation_deg` | 10 mm, 0.1 rad |
//! | `body.topic` | `"/tracker/<name>/pose"` |
//! | `body.track.topic`, `body.track.sees` | `"/tracker/<body>/<name>"`, `"pose"` |
//! | `body.track.position_sd_mm`, `body.track.orientation_sd_deg` | the scene's weights |
//! | `body.held` | `false` |
//! | `body.tracked` | `true` |
//! | `joint.parent` | the world |
//! | `joint.parent_at_mm`, `joint.child_at_mm` | the centre of mass, the world's origin |
//! | `joint.child_orientation_wxyz` | the parent's axes |
//! | `joint.damping_n_m_s`, `joint.stiffness_n_m` | none |
//! | `body.tracker_sd_mm`, `body.tracker_sd_deg`, of a held body | as its stream shows, at least 0.01 mm and 0.003° |
//! | `velocity_gaps` | `"when needed"` |
//! | `body.tracker`, `obstacle.orientation_wxyz` | identity |
//! | `event.feature`, `event.surface`, `event.other_feature` | inferred from the performance |
//! | `event.restitution`, `event.friction` | the body's |
//! | `body.restitution`, `body.friction` | each event has its own; no friction |
//! | `event.count` | one collision |
//! | `goal.point_mm`, `goal.feature`, `goal.contact` | the centre of mass |
//! | `goal.relative_to`, `goal.axes` | the world's axes |
//! | `goal.direction` of an `axis` | against gravity |
//! | `goal.after` | just before the event |
//! | `goal.within_mm`, `goal.within_deg`, `goal.within_m_s`, `goal.within_rad_s`, `goal.normal` | exactly |
//! | `goal.sd_mm`, `goal.sd_deg`, `goal.sd_m_s`, `goal.sd_rad_s`, `goal.sd_ms` | hard |
//! | `goal.since` | the first sample |
//! | `goal.within_deg`, `goal.direction`, `goal.labels`, at rest | 10, against gravity, `"fixed"` |
//! | `event.time` | `"free"` for collisions and waypoints, and for an end with a goal where stamps are a tempo; else `"fixed"` |
//! | `event.time_sd_ms` | `timing.mark_sd_ms`; of a waypoint 50 ms where that is not given |
//! | `event.earliest_ms`, `event.latest_ms` | −∞, +∞ |
//! | `body.force_m_s2`, `body.drag_linear_per_s`, `body.drag_quadratic_per_m` | none |
//! | `free.initial…`, `free.lower…`, `free.upper…` | see above |
//! | `free.prior_sd…` | no prior |

mod body;
mod capture;
mod error;
mod event;
mod free_flight;
mod goal;
mod held;
mod joint;
mod keyframes;
mod keys;
mod law;
mod number;
mod parameter;
mod quantity;
mod raw;
mod rest;
mod scene;
mod solid;
mod text;
mod track;
mod unit;
mod urdf;

pub use capture::CaptureSettings;
pub use error::SceneError;
pub use keyframes::{sketch_from_csv, sketch_from_toml};
pub use text::{capture_from_toml, scene_from_toml};
pub use urdf::{UrdfScene, scene_from_urdf};

#[cfg(test)]
mod tests;
