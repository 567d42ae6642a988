//! What a channel carries, and how to read it.

use nalgebra::Vector3;

use super::error::DecodeError;
use super::{cdr, json, protobuf};
use crate::motion::{Mark, PoseSample, Stamp};

/// A pose as a message gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct FramedPose {
    /// Frame in which the pose is given.
    pub parent: String,
    /// Name of what has this pose: the child frame, or the place in an array of poses. Empty
    /// where the message is about one nameless thing.
    pub child: String,
    /// When it was measured; `None` where the message does not say or says zero.
    pub stamp: Option<Stamp>,
    /// Position \[m\], as sent.
    pub position_m: Vector3<f64>,
    /// Quaternion, as sent.
    pub quaternion_xyzw: [f64; 4],
}

impl FramedPose {
    /// The sample, stamped `fallback` where the message has no stamp.
    pub fn sample(&self, fallback: Stamp) -> PoseSample {
        PoseSample {
            stamp: self.stamp.unwrap_or(fallback),
            position_m: self.position_m,
            quaternion_xyzw: self.quaternion_xyzw,
        }
    }
}

/// A mark as a message gives it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StampedMark {
    /// When it was made; `None` where the message does not say or says zero.
    pub stamp: Option<Stamp>,
    /// Name of the scene's event it stands for.
    pub event: Option<String>,
}

impl StampedMark {
    /// The mark, stamped `fallback` where the message has no stamp.
    pub fn mark(self, fallback: Stamp) -> Mark {
        Mark {
            stamp: self.stamp.unwrap_or(fallback),
            event: self.event,
        }
    }
}

/// Foxglove's messages that hold poses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FoxglovePose {
    PoseInFrame,
    PosesInFrame,
    FrameTransform,
    FrameTransforms,
}

/// ROS 2 messages that hold poses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RosPose {
    /// `PoseStamped`; `PoseWithCovarianceStamped` begins with the same bytes.
    PoseStamped,
    Odometry,
    TfMessage,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Poses {
    Protobuf(FoxglovePose),
    Json(FoxglovePose),
    Cdr(RosPose),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Marks {
    ProtobufEvent,
    JsonEvent,
    CdrHeader,
}

/// How to read the poses of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PoseFormat(Poses);

/// How to read the marks of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MarkFormat(Marks);

/// What [`PoseFormat::of`] knows, for people.
pub const POSE_SCHEMAS: &str = "foxglove.PoseInFrame, PosesInFrame, FrameTransform, \
     FrameTransforms (protobuf, json); geometry_msgs/msg/PoseStamped, \
     PoseWithCovarianceStamped, nav_msgs/msg/Odometry, tf2_msgs/msg/TFMessage (cdr)";

/// What [`MarkFormat::of`] knows, for people.
pub const MARK_SCHEMAS: &str = "foxglove.Event (protobuf, json); std_msgs/msg/Header (cdr)";

impl PoseFormat {
    /// The format of messages of this encoding with a schema of this name.
    pub fn of(schema_name: &str, message_encoding: &str) -> Option<Self> {
        let foxglove = match schema_name {
            "foxglove.PoseInFrame" => Some(FoxglovePose::PoseInFrame),
            "foxglove.PosesInFrame" => Some(FoxglovePose::PosesInFrame),
            "foxglove.FrameTransform" => Some(FoxglovePose::FrameTransform),
            "foxglove.FrameTransforms" => Some(FoxglovePose::FrameTransforms),
            _ => None,
        };
        let ros = match schema_name {
            "geometry_msgs/msg/PoseStamped" | "geometry_msgs/msg/PoseWithCovarianceStamped" => {
                Some(RosPose::PoseStamped)
            }
            "nav_msgs/msg/Odometry" => Some(RosPose::Odometry),
            "tf2_msgs/msg/TFMessage" => Some(RosPose::TfMessage),
            _ => None,
        };
        match message_encoding {
            "protobuf" => foxglove.map(Poses::Protobuf),
            "json" => foxglove.map(Poses::Json),
            "cdr" => ros.map(Poses::Cdr),
            _ => None,
        }
        .map(Self)
    }

    /// Appends the poses of a message to `poses`; none where the message is in error.
    pub fn decode(self, data: &[u8], poses: &mut Vec<FramedPose>) -> Result<(), DecodeError> {
        let before = poses.len();
        let result = match self.0 {
            Poses::Protobuf(message) => protobuf::poses(message, data, poses),
            Poses::Json(message) => json::poses(message, data, poses),
            Poses::Cdr(message) => cdr::poses(message, data, poses),
        };
        if result.is_err() {
            poses.truncate(before);
        }
        result
    }
}

impl MarkFormat {
    /// The format of messages of this encoding with a schema of this name.
    pub fn of(schema_name: &str, message_encoding: &str) -> Option<Self> {
        match (schema_name, message_encoding) {
            ("foxglove.Event", "protobuf") => Some(Self(Marks::ProtobufEvent)),
            ("foxglove.Event", "json") => Some(Self(Marks::JsonEvent)),
            ("std_msgs/msg/Header", "cdr") => Some(Self(Marks::CdrHeader)),
            _ => None,
        }
    }

    /// The mark of a message. A ROS header's frame id, if not empty, names the event.
    pub fn decode(self, data: &[u8]) -> Result<StampedMark, DecodeError> {
        match self.0 {
            Marks::ProtobufEvent => protobuf::mark(data),
            Marks::JsonEvent => json::mark(data),
            Marks::CdrHeader => cdr::mark(data),
        }
    }
}

/// A stamp from seconds and nanoseconds; zero is none.
pub(super) fn stamp(seconds: i64, nanoseconds: u32) -> Result<Option<Stamp>, DecodeError> {
    let total = seconds
        .checked_mul(1_000_000_000)
        .and_then(|whole| whole.checked_add(i64::from(nanoseconds)))
        .ok_or(DecodeError::Stamp(seconds))?;
    Ok((total != 0).then_some(Stamp(total)))
}
