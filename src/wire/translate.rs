//! Our messages of an estimate, in foxglove's schemas or ROS 2's, as ROS 2 messages.

use super::decode::{DecodeError, FramedPose, MarkFormat, PoseFormat, joint_states};
use super::encode::{EncodeError, JointState, Transform};
use super::ros2::{self, RosMessage};
use crate::motion::Stamp;
use thiserror::Error;

/// Why a message has no translation.
#[derive(Debug, Error)]
pub enum TranslateError {
    /// It cannot be read.
    #[error(transparent)]
    Decode(#[from] DecodeError),
    /// It cannot be said.
    #[error(transparent)]
    Encode(#[from] EncodeError),
}

/// What ROS 2 message the messages of a channel become, by the name of its schema and the encoding of its messages;
/// `None` where ROS 2 has none for them: what viewers draw.
pub fn ros_message(schema: &str, encoding: &str) -> Option<RosMessage> {
    match (schema, encoding) {
        ("foxglove.PoseInFrame", "protobuf") => Some(RosMessage::PoseStamped),
        ("foxglove.FrameTransforms", "protobuf") => Some(RosMessage::TfMessage),
        ("foxglove.JointStates", "protobuf") => Some(RosMessage::JointState),
        ("foxglove.Event", "protobuf") => Some(RosMessage::Header),
        (_, "json") => Some(RosMessage::String),
        (name, "cdr") => RosMessage::named(name),
        _ => None,
    }
}

/// The bytes of the ROS 2 message that a message of such a channel becomes.
pub fn translated(
    schema: &str,
    encoding: &str,
    to: RosMessage,
    data: &[u8],
) -> Result<Vec<u8>, TranslateError> {
    if encoding == "cdr" {
        return Ok(data.to_vec());
    }
    match to {
        RosMessage::PoseStamped => {
            let poses = poses(schema, encoding, data)?;
            let [pose] = poses.as_slice() else {
                return Err(DecodeError::Missing("pose").into());
            };
            Ok(ros2::pose_stamped(&pose.parent, &pose.sample(Stamp(0)))?)
        }
        RosMessage::TfMessage => {
            let poses = poses(schema, encoding, data)?;
            let transforms = poses.iter().map(|pose| Transform {
                parent: &pose.parent,
                child: &pose.child,
                sample: pose.sample(Stamp(0)),
            });
            Ok(ros2::tf_message(&transforms.collect::<Vec<_>>())?)
        }
        RosMessage::JointState => {
            let (at, joints) = joint_states(data)?;
            let joints = joints
                .iter()
                .map(|(name, angle_rad, rate_rad_s)| JointState {
                    name,
                    angle_rad: *angle_rad,
                    rate_rad_s: *rate_rad_s,
                });
            Ok(ros2::joint_state(at, &joints.collect::<Vec<_>>())?)
        }
        RosMessage::Header => {
            let format = MarkFormat::of(schema, encoding).ok_or(DecodeError::Missing("event"))?;
            let mark = format.decode(data)?.mark(Stamp(0));
            Ok(ros2::header(
                mark.stamp,
                mark.event.as_deref().unwrap_or_default(),
            )?)
        }
        RosMessage::String => Ok(ros2::string(&String::from_utf8_lossy(data))),
    }
}

fn poses(schema: &str, encoding: &str, data: &[u8]) -> Result<Vec<FramedPose>, DecodeError> {
    let format = PoseFormat::of(schema, encoding).ok_or(DecodeError::Missing("pose"))?;
    let mut poses = Vec::new();
    format.decode(data, &mut poses)?;
    Ok(poses)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::motion::PoseSample;
    use crate::wire::encode::{self, MARK_EVENT_KEY};

    fn sample() -> PoseSample {
        let position_m = Vector3::new(0.1, -0.2, 0.3);
        PoseSample::new(
            Stamp(1_700_000_000_123_456_789),
            position_m,
            [0.5, -0.5, 0.5, 0.5],
        )
    }

    #[test]
    fn a_translation_is_what_ros_2_would_have_been_told() {
        let (at, sample) = (sample().stamp, sample());
        let transforms = [Transform {
            parent: "world",
            child: "pencil",
            sample,
        }];
        let joints = [
            JointState {
                name: "elbow",
                angle_rad: 0.25,
                rate_rad_s: Some(-3.0),
            },
            JointState {
                name: "wrist",
                angle_rad: -1.5,
                rate_rad_s: Some(0.0),
            },
        ];
        let encoded = "encoded";
        for (schema, given, expected) in [
            (
                "foxglove.PoseInFrame",
                encode::pose_in_frame("world", &sample),
                ros2::pose_stamped("world", &sample),
            ),
            (
                "foxglove.FrameTransforms",
                encode::frame_transforms(&transforms),
                ros2::tf_message(&transforms),
            ),
            (
                "foxglove.JointStates",
                encode::joint_states(at, &joints),
                ros2::joint_state(at, &joints),
            ),
            (
                "foxglove.Event",
                encode::event_with(at, &[(MARK_EVENT_KEY, "bounce")]),
                ros2::header(at, "bounce"),
            ),
        ] {
            let to = ros_message(schema, "protobuf").expect(schema);
            let found = translated(schema, "protobuf", to, &given.expect(encoded));
            assert_eq!(found.expect(schema), expected.expect(encoded), "{schema}");
        }
        assert_eq!(ros_message("foxglove.SceneUpdate", "protobuf"), None);
    }

    #[test]
    fn what_is_no_message_is_an_error() {
        for schema in [
            "foxglove.PoseInFrame",
            "foxglove.JointStates",
            "foxglove.Event",
        ] {
            let to = ros_message(schema, "protobuf").expect(schema);
            assert!(
                translated(schema, "protobuf", to, b"\xff\xff\xff").is_err(),
                "{schema}"
            );
        }
    }
}
