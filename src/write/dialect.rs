//! In whose messages we say what we add.
//!
//! Readers of the `ros2` profile read ROS 2 messages and nothing else: one channel of another
//! encoding and they refuse the file. A recording of that profile keeps it, and what we add is in
//! ROS 2 messages too; any other is added to in foxglove's, which viewers draw.

use crate::motion::{PoseSample, Stamp};
use crate::wire::encode::{self, MARK_EVENT_KEY, SchemaRecord};
use crate::wire::ros2::{self, RosMessage};
use crate::wire::{Container, EncodeError, Encoded, JointState, Transform};

use super::topics;

/// What ROS 2 recordings name as their profile.
pub(super) const ROS2: &str = "ros2";

/// Whose messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dialect {
    /// Protobuf with foxglove's schemas, JSON for what they have none for.
    Foxglove,
    /// CDR with ROS 2 definitions; JSON as text.
    Ros2,
}

/// How a topic's messages are encoded, and what they are.
pub(super) type Format = (SchemaRecord, &'static str);

impl Dialect {
    /// That of a file that is added to.
    pub(super) fn of(input: &Container) -> Self {
        match input.profile() {
            ROS2 => Dialect::Ros2,
            _ => Dialect::Foxglove,
        }
    }

    /// The profile of the output. A profile promises what every channel is, so that others than
    /// ROS 2 are not kept.
    pub(super) fn profile(self) -> &'static str {
        match self {
            Dialect::Foxglove => "",
            Dialect::Ros2 => ROS2,
        }
    }

    fn format(self, foxglove: Encoded, ros: RosMessage) -> Format {
        match self {
            Dialect::Foxglove => (foxglove.schema(), "protobuf"),
            Dialect::Ros2 => (ros.schema(), "cdr"),
        }
    }

    /// Poses of one frame.
    pub(super) fn poses(self) -> Format {
        self.format(Encoded::PoseInFrame, RosMessage::PoseStamped)
    }

    /// Its message.
    pub(super) fn pose(self, frame_id: &str, sample: &PoseSample) -> Result<Vec<u8>, EncodeError> {
        match self {
            Dialect::Foxglove => encode::pose_in_frame(frame_id, sample),
            Dialect::Ros2 => ros2::pose_stamped(frame_id, sample),
        }
    }

    /// Transforms of frames.
    pub(super) fn transforms(self) -> Format {
        self.format(Encoded::FrameTransforms, RosMessage::TfMessage)
    }

    /// Their message.
    pub(super) fn transforms_of(self, all: &[Transform]) -> Result<Vec<u8>, EncodeError> {
        match self {
            Dialect::Foxglove => encode::frame_transforms(all),
            Dialect::Ros2 => ros2::tf_message(all),
        }
    }

    /// Topic of the angles of joints.
    pub(super) fn joints_topic(self) -> &'static str {
        match self {
            Dialect::Foxglove => topics::JOINTS,
            Dialect::Ros2 => topics::ROS_JOINTS,
        }
    }

    /// Angles of joints.
    pub(super) fn joints(self) -> Format {
        self.format(Encoded::JointStates, RosMessage::JointState)
    }

    /// Their message.
    pub(super) fn joints_of(self, at: Stamp, all: &[JointState]) -> Result<Vec<u8>, EncodeError> {
        match self {
            Dialect::Foxglove => encode::joint_states(at, all),
            Dialect::Ros2 => ros2::joint_state(at, all),
        }
    }

    /// Instants with a name.
    pub(super) fn events(self) -> Format {
        self.format(Encoded::Event, RosMessage::Header)
    }

    /// Their message: the event's name, if it has one, and of what kind it is.
    pub(super) fn event(
        self,
        at: Stamp,
        name: Option<&str>,
        kind: Option<&str>,
    ) -> Result<Vec<u8>, EncodeError> {
        match self {
            Dialect::Foxglove => {
                let name = name.map(|name| (MARK_EVENT_KEY, name));
                let kind = kind.map(|kind| ("kind", kind));
                let pairs: Vec<_> = name.into_iter().chain(kind).collect();
                encode::event_with(at, &pairs)
            }
            // There is room for a name only; the report says the rest.
            Dialect::Ros2 => ros2::header(at, name.unwrap_or_default()),
        }
    }

    /// What viewers draw. ROS 2's draw the URDF that is written in any case.
    pub(super) fn drawings(self) -> Option<Format> {
        match self {
            Dialect::Foxglove => Some((Encoded::SceneUpdate.schema(), "protobuf")),
            Dialect::Ros2 => None,
        }
    }

    /// JSON of that schema.
    pub(super) fn json(self, name: &str, schema: &str) -> Format {
        match self {
            Dialect::Foxglove => {
                let schema = SchemaRecord {
                    name: name.to_owned(),
                    encoding: "jsonschema".to_owned(),
                    data: schema.as_bytes().to_vec(),
                };
                (schema, "json")
            }
            Dialect::Ros2 => text(),
        }
    }

    /// Its message.
    pub(super) fn json_of(self, json: Vec<u8>) -> Vec<u8> {
        match self {
            Dialect::Foxglove => json,
            Dialect::Ros2 => ros2::string(&String::from_utf8_lossy(&json)),
        }
    }
}

/// A ROS 2 string, in either dialect.
pub(super) fn text() -> Format {
    (RosMessage::String.schema(), "cdr")
}
