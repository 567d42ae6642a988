//! Topics and frames of the estimate.
//!
//! | topic | schema | what |
//! |---|---|---|
//! | `/estimate/<body>/pose` | `foxglove.PoseInFrame` | the motion, on a frame grid and exactly at events; after its end what was simulated |
//! | `/estimate/<body>/deviation` | `enact.Deviation` (JSON) | how certain pose and velocities of the motion are, at its poses; only of bodies that fly alone |
//! | `/sketch/<body>/pose` | `foxglove.PoseInFrame` | the performance, in body axes, at its physical times |
//! | `/tf` | `foxglove.FrameTransforms` | both, as frames `<body>_estimate` and `<body>_sketch`, and the frames of joints |
//! | `/estimate/joints` | `foxglove.JointStates` | angles and rates of joints, at the frames of the motion; only where bodies are joined |
//! | `/scene` | `foxglove.SceneUpdate` | bodies, as ghosts as they were acted, the ways of both, events, obstacles, surfaces, goals |
//! | `/robot_description` | `std_msgs/msg/String` | bodies, ghosts and what stands as URDF, for viewers that draw that |
//! | `/estimate/events` | `foxglove.Event` | the scene's events, when they happen, and from when the motion is simulated |
//! | `/estimate/time_map` | `enact.TimeMap` (JSON) | acted time against physical time |
//! | `/estimate/report` | `enact.EstimateReport` (JSON) | the whole estimate, and from what it was made |
//!
//! In an input of the `ros2` profile, whose readers know nothing else, they are
//! `geometry_msgs/msg/PoseStamped`, `tf2_msgs/msg/TFMessage`, `sensor_msgs/msg/JointState` on `/joint_states`,
//! `std_msgs/msg/Header` with the event's name as its frame, and the JSON as `std_msgs/msg/String`; there is no
//! `/scene`.
//!
//! Transforms, joints and URDF are of one robot (`docs/joints.md`).
//!
//! Where the input has a topic of that name already, ours begins with `/estimate`, as in
//! `/estimate/tf`.

use std::collections::BTreeMap;

/// What became of the samples of a live take.
pub const COUNTS: &str = "/capture/counts";
/// Name of the metadata record that a live take has at its end: its number, and what was said of it.
pub const TAKE_METADATA: &str = "take";
/// Frame transforms.
pub const TRANSFORMS: &str = "/tf";
/// Angles of joints.
pub const JOINTS: &str = "/estimate/joints";
/// The same in ROS 2, where nodes look for it.
pub const ROS_JOINTS: &str = "/joint_states";
/// What viewers draw.
pub const SCENE: &str = "/scene";
/// The same as URDF, where RViz looks for it.
pub const ROBOT_DESCRIPTION: &str = "/robot_description";
/// When the scene's events happen.
pub const EVENTS: &str = "/estimate/events";
/// Acted time against physical time.
pub const TIME_MAP: &str = "/estimate/time_map";
/// The whole estimate.
pub const REPORT: &str = "/estimate/report";

/// Before a topic of ours of which the input has another.
pub(super) const DISPUTED: &str = "/estimate";

/// Key and value in the metadata of every channel that an estimate adds; by them a later run
/// knows what to replace.
const OURS: (&str, &str) = ("enact", "estimate");

/// Topic of a body's estimated poses.
pub fn estimate_pose(body: &str) -> String {
    format!("/estimate/{body}/pose")
}

/// Topic of how certain a body's estimated poses are.
pub fn estimate_deviation(body: &str) -> String {
    format!("/estimate/{body}/deviation")
}

/// Topic of a body's performed poses.
pub fn sketch_pose(body: &str) -> String {
    format!("/sketch/{body}/pose")
}

/// The frame that moves with a body's estimate.
pub fn estimate_frame(body: &str) -> String {
    format!("{body}_estimate")
}

/// The frame that moves with a body's performance.
pub fn sketch_frame(body: &str) -> String {
    format!("{body}_sketch")
}

/// The frame that moves with a body's tracker, live.
pub fn live_frame(body: &str) -> String {
    format!("{body}_live")
}

/// The topic that a topic of ours has where the input has none of that name: without the `/estimate` before it, if that
/// stands there to tell the two apart.
pub(super) fn undisputed(topic: &str) -> &str {
    let plain = topic.strip_prefix(DISPUTED).unwrap_or_default();
    match [TRANSFORMS, ROBOT_DESCRIPTION, ROS_JOINTS].contains(&plain) {
        true => plain,
        false => topic,
    }
}

/// Metadata of every channel that an estimate adds.
pub(super) fn metadata() -> BTreeMap<String, String> {
    BTreeMap::from([(OURS.0.to_owned(), OURS.1.to_owned())])
}

/// Whether an estimate added a channel with such metadata.
pub(super) fn is_ours(metadata: &BTreeMap<String, String>) -> bool {
    metadata.get(OURS.0).is_some_and(|value| value == OURS.1)
}
