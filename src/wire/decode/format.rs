//! The formats of channels that can be read, by schema name and message encoding.

use super::error::DecodeError;
use super::message::{FoxglovePose, FramedPose, RosPose, StampedMark};
use super::{json, protobuf, ros};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Poses {
    Protobuf(FoxglovePose),
    Json(FoxglovePose),
    Cdr(RosPose),
    Ros1(RosPose),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Marks {
    ProtobufEvent,
    JsonEvent,
    CdrHeader,
    Ros1Header,
}

/// How to read the poses of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PoseFormat(Poses);

/// How to read the marks of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MarkFormat(Marks);

/// The schemas that [`PoseFormat::of`] accepts, for error messages.
pub const POSE_SCHEMAS: &str = "foxglove.PoseInFrame, PosesInFrame, FrameTransform, \
     FrameTransforms, Point3InFrame, Odometry (protobuf, json); PoseStamped, Pose, PoseArray, \
     PoseWithCovarianceStamped, TransformStamped, PointStamped, QuaternionStamped, Vector3Stamped of \
     geometry_msgs, nav_msgs Odometry, tf2_msgs TFMessage, mocap4r2_msgs RigidBodies, \
     motion_capture_tracking_interfaces NamedPoseArray (cdr, ros1); enact.Keyframe (json)";

/// The schemas that [`MarkFormat::of`] accepts, for error messages.
pub const MARK_SCHEMAS: &str = "foxglove.Event (protobuf, json); std_msgs Header (cdr, ros1)";

/// Longest message of poses or marks that is read: two thousand transforms. Two bytes can stand for
/// a pose, which takes half a kilobyte in memory.
const MESSAGE_LIMIT_BYTES: usize = 256 << 10;

fn check_length(data: &[u8]) -> Result<(), DecodeError> {
    if data.len() > MESSAGE_LIMIT_BYTES {
        return Err(DecodeError::Long {
            length: data.len(),
            limit: MESSAGE_LIMIT_BYTES,
        });
    }
    Ok(())
}

impl PoseFormat {
    /// The format of messages of this encoding with a schema of this name.
    pub fn of(schema_name: &str, message_encoding: &str) -> Option<Self> {
        let foxglove = match schema_name {
            "foxglove.PoseInFrame" => Some(FoxglovePose::PoseInFrame),
            "foxglove.PosesInFrame" => Some(FoxglovePose::PosesInFrame),
            "foxglove.FrameTransform" => Some(FoxglovePose::FrameTransform),
            "foxglove.FrameTransforms" => Some(FoxglovePose::FrameTransforms),
            "foxglove.Point3InFrame" => Some(FoxglovePose::Point3InFrame),
            "foxglove.Odometry" => Some(FoxglovePose::Odometry),
            _ => None,
        };
        let named = |separator: &str| {
            let (package, message) = schema_name.split_once(separator)?;
            RosPose::named(package, message)
        };
        match message_encoding {
            "protobuf" => foxglove.map(Poses::Protobuf),
            "json" => foxglove.map(Poses::Json),
            "cdr" => named("/msg/").map(Poses::Cdr),
            "ros1" => named("/").map(Poses::Ros1),
            _ => None,
        }
        .map(Self)
    }

    /// Whether its messages say how frames lie in others.
    pub fn relates_frames(self) -> bool {
        match self.0 {
            Poses::Protobuf(of) | Poses::Json(of) => {
                matches!(
                    of,
                    FoxglovePose::FrameTransform | FoxglovePose::FrameTransforms
                )
            }
            Poses::Cdr(of) | Poses::Ros1(of) => {
                matches!(of, RosPose::TransformStamped | RosPose::TfMessage)
            }
        }
    }

    /// Appends the poses of a message to `poses`; appends none where it fails.
    pub fn decode(self, data: &[u8], poses: &mut Vec<FramedPose>) -> Result<(), DecodeError> {
        let before = poses.len();
        let result = check_length(data).and_then(|()| match self.0 {
            Poses::Protobuf(message) => protobuf::poses(message, data, poses),
            Poses::Json(message) => json::poses(message, data, poses),
            Poses::Cdr(message) => ros::cdr_poses(message, data, poses),
            Poses::Ros1(message) => ros::ros1_poses(message, data, poses),
        });
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
            ("std_msgs/Header", "ros1") => Some(Self(Marks::Ros1Header)),
            _ => None,
        }
    }

    /// The mark of a message. A ROS header's frame id, if not empty, names the event.
    pub fn decode(self, data: &[u8]) -> Result<StampedMark, DecodeError> {
        check_length(data)?;
        match self.0 {
            Marks::ProtobufEvent => protobuf::mark(data),
            Marks::JsonEvent => json::mark(data),
            Marks::CdrHeader => ros::cdr_mark(data),
            Marks::Ros1Header => ros::ros1_mark(data),
        }
    }
}
