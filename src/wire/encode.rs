//! Motion → messages: foxglove protobufs with their schemas.

use foxglove::Encode;
use foxglove::messages::{
    Event, FrameTransform, FrameTransforms, JointStates, KeyValuePair, Point3, Point3InFrame, Pose,
    PoseInFrame, Quaternion, Timestamp, Vector3,
};
use thiserror::Error;

use super::keyframe;
use crate::motion::{Mark, PoseSample, Stamp};

/// Key of the metadata pair of a `foxglove.Event` that names the scene's event.
pub const MARK_EVENT_KEY: &str = "event";

const NANOSECONDS_PER_SECOND: i64 = 1_000_000_000;

/// Why a value cannot be written in a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum EncodeError {
    /// Foxglove's stamps count whole seconds from 0 to 2³² − 1.
    #[error("stamp {0} ns cannot be written: message stamps reach from 0 to 2^32 s")]
    Stamp(i64),
    /// ROS 2 counts whole seconds in 32 bits with a sign.
    #[error("stamp {0} ns cannot be written: ROS 2 stamps reach to 2^31 s")]
    RosStamp(i64),
}

/// A message schema as MCAP stores it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SchemaRecord {
    /// Such as `foxglove.PoseInFrame`.
    pub name: String,
    /// Such as `protobuf`.
    pub encoding: String,
    /// The definition in that encoding.
    pub data: Vec<u8>,
}

/// The kinds of messages that are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Encoded {
    /// `foxglove.PoseInFrame`.
    PoseInFrame,
    /// `foxglove.Point3InFrame`.
    Point3InFrame,
    /// `foxglove.FrameTransforms`.
    FrameTransforms,
    /// `foxglove.JointStates`.
    JointStates,
    /// `foxglove.SceneUpdate`.
    SceneUpdate,
    /// `foxglove.Event`.
    Event,
    /// `enact.Keyframe`.
    Keyframe,
}

impl Encoded {
    /// How its messages are encoded.
    pub fn message_encoding(self) -> &'static str {
        match self {
            Encoded::Keyframe => "json",
            _ => "protobuf",
        }
    }

    /// The schema of the messages of this kind.
    pub fn schema(self) -> SchemaRecord {
        let schema = match self {
            Encoded::Keyframe => {
                return SchemaRecord {
                    name: keyframe::KEYFRAME_SCHEMA.to_owned(),
                    encoding: "jsonschema".to_owned(),
                    data: keyframe::SCHEMA.as_bytes().to_vec(),
                };
            }
            Encoded::PoseInFrame => PoseInFrame::get_schema(),
            Encoded::Point3InFrame => Point3InFrame::get_schema(),
            Encoded::FrameTransforms => FrameTransforms::get_schema(),
            Encoded::JointStates => JointStates::get_schema(),
            Encoded::SceneUpdate => foxglove::messages::SceneUpdate::get_schema(),
            Encoded::Event => Event::get_schema(),
        }
        .expect("foxglove's own messages have schemas");
        SchemaRecord {
            name: schema.name,
            encoding: schema.encoding,
            data: schema.data.into_owned(),
        }
    }
}

/// The pose of a child frame in its parent frame at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform<'a> {
    /// Name of the parent frame.
    pub parent: &'a str,
    /// Name of the child frame.
    pub child: &'a str,
    /// Stamp and pose, parent from child.
    pub sample: PoseSample,
}

/// A joint that turns about one axis, at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointState<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its angle \[rad\].
    pub angle_rad: f64,
    /// Its rate [rad/s], where it is known.
    pub rate_rad_s: Option<f64>,
}

/// A `foxglove.PoseInFrame`.
pub fn pose_in_frame(frame_id: &str, sample: &PoseSample) -> Result<Vec<u8>, EncodeError> {
    Ok(bytes_of(&PoseInFrame {
        timestamp: Some(timestamp(sample.stamp)?),
        frame_id: frame_id.to_owned(),
        pose: Some(Pose {
            position: Some(translation(sample)),
            orientation: Some(rotation(sample)),
        }),
    }))
}

/// A `foxglove.Point3InFrame` of the reading's position.
pub fn point_in_frame(frame_id: &str, sample: &PoseSample) -> Result<Vec<u8>, EncodeError> {
    let [x, y, z] = sample.position_m.into();
    Ok(bytes_of(&Point3InFrame {
        timestamp: Some(timestamp(sample.stamp)?),
        frame_id: frame_id.to_owned(),
        point: Some(Point3 { x, y, z }),
    }))
}

/// A `foxglove.FrameTransforms` of any number of transforms.
pub fn frame_transforms(transforms: &[Transform]) -> Result<Vec<u8>, EncodeError> {
    let transforms = transforms
        .iter()
        .map(|transform| {
            Ok(FrameTransform {
                timestamp: Some(timestamp(transform.sample.stamp)?),
                parent_frame_id: transform.parent.to_owned(),
                child_frame_id: transform.child.to_owned(),
                translation: Some(translation(&transform.sample)),
                rotation: Some(rotation(&transform.sample)),
            })
        })
        .collect::<Result<_, EncodeError>>()?;
    Ok(bytes_of(&FrameTransforms { transforms }))
}

/// A `foxglove.JointStates` of any number of joints.
pub fn joint_states(at: Stamp, joints: &[JointState]) -> Result<Vec<u8>, EncodeError> {
    let joints = joints.iter().map(|joint| foxglove::messages::JointState {
        name: joint.name.to_owned(),
        position: Some(joint.angle_rad),
        velocity: joint.rate_rad_s,
        ..foxglove::messages::JointState::default()
    });
    Ok(bytes_of(&JointStates {
        timestamp: Some(timestamp(at)?),
        joints: joints.collect(),
    }))
}

/// A `foxglove.Event` at the mark's instant; the scene's event, if named, is its metadata
/// under [`MARK_EVENT_KEY`].
pub fn event(mark: &Mark) -> Result<Vec<u8>, EncodeError> {
    let name = mark.event.as_deref();
    let pairs: Vec<_> = name
        .map(|name| (MARK_EVENT_KEY, name))
        .into_iter()
        .collect();
    event_with(mark.stamp, &pairs)
}

/// A `foxglove.Event` at one instant with the given metadata.
pub fn event_with(stamp: Stamp, pairs: &[(&str, &str)]) -> Result<Vec<u8>, EncodeError> {
    let at = timestamp(stamp)?;
    Ok(bytes_of(&Event {
        start_time: Some(at),
        end_time: Some(at),
        metadata: pairs
            .iter()
            .map(|&(key, value)| KeyValuePair {
                key: key.to_owned(),
                value: value.to_owned(),
            })
            .collect(),
    }))
}

/// The stamp as a foxglove message holds it.
pub(crate) fn timestamp(stamp: Stamp) -> Result<Timestamp, EncodeError> {
    let seconds = u32::try_from(stamp.0.div_euclid(NANOSECONDS_PER_SECOND))
        .map_err(|_| EncodeError::Stamp(stamp.0))?;
    let nanoseconds = stamp.0.rem_euclid(NANOSECONDS_PER_SECOND);
    Ok(Timestamp::new(
        seconds,
        u32::try_from(nanoseconds).expect("a remainder below 10^9 fits"),
    ))
}

/// Encodes any foxglove message.
pub(crate) fn bytes_of<M: Encode>(message: &M) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(message.encoded_len().unwrap_or(0));
    message
        .encode(&mut bytes)
        .unwrap_or_else(|error| unreachable!("a growing vector has room: {error}"));
    bytes
}

fn translation(sample: &PoseSample) -> Vector3 {
    Vector3 {
        x: sample.position_m.x,
        y: sample.position_m.y,
        z: sample.position_m.z,
    }
}

fn rotation(sample: &PoseSample) -> Quaternion {
    let [x, y, z, w] = sample.quaternion_xyzw;
    Quaternion { x, y, z, w }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_outside_what_messages_can_say_are_refused_by_value() {
        assert_eq!(timestamp(Stamp(-1)), Err(EncodeError::Stamp(-1)));
        let past = (1i64 << 32) * NANOSECONDS_PER_SECOND;
        assert_eq!(timestamp(Stamp(past)), Err(EncodeError::Stamp(past)));
        assert_eq!(
            timestamp(Stamp(past - 1)),
            Ok(Timestamp::new(u32::MAX, 999_999_999))
        );
    }

    #[test]
    fn every_kind_has_a_protobuf_schema_of_its_name() {
        for (kind, name) in [
            (Encoded::PoseInFrame, "foxglove.PoseInFrame"),
            (Encoded::FrameTransforms, "foxglove.FrameTransforms"),
            (Encoded::JointStates, "foxglove.JointStates"),
            (Encoded::SceneUpdate, "foxglove.SceneUpdate"),
            (Encoded::Event, "foxglove.Event"),
        ] {
            let schema = kind.schema();
            assert_eq!(
                (schema.name.as_str(), schema.encoding.as_str()),
                (name, "protobuf")
            );
            assert!(!schema.data.is_empty());
        }
    }
}
