//! Decodes foxglove's protobuf messages.

use foxglove::Decode;
use foxglove::messages::{
    Event, FrameTransform, FrameTransforms, JointStates, Odometry, Point3InFrame, Pose,
    PoseInFrame, PosesInFrame, Quaternion, Timestamp, Vector3,
};

use super::error::DecodeError;
use super::message::{FoxglovePose, FramedPose, StampedMark, stamp};
use crate::motion::{Holds, Stamp};
use crate::wire::encode::MARK_EVENT_KEY;

/// A joint's name, angle \[rad\] and rate [rad/s].
type JointReading = (String, f64, Option<f64>);

pub(super) fn poses(
    message: FoxglovePose,
    data: &[u8],
    poses: &mut Vec<FramedPose>,
) -> Result<(), DecodeError> {
    match message {
        FoxglovePose::PoseInFrame => {
            let message: PoseInFrame = decoded(data)?;
            let at = time(message.timestamp)?;
            let pose = message.pose.ok_or(DecodeError::Missing("pose"))?;
            poses.push(framed(message.frame_id, String::new(), at, pose)?);
        }
        FoxglovePose::PosesInFrame => {
            let message: PosesInFrame = decoded(data)?;
            let at = time(message.timestamp)?;
            for (index, pose) in message.poses.into_iter().enumerate() {
                poses.push(framed(
                    message.frame_id.clone(),
                    index.to_string(),
                    at,
                    pose,
                )?);
            }
        }
        FoxglovePose::Point3InFrame => {
            let message: Point3InFrame = decoded(data)?;
            let at = time(message.timestamp)?;
            let point = message.point.ok_or(DecodeError::Missing("point"))?;
            let position_m = nalgebra::Vector3::new(point.x, point.y, point.z);
            let holds = Holds::Position;
            poses.push(FramedPose::vector(message.frame_id, at, position_m, holds));
        }
        FoxglovePose::Odometry => {
            let message: Odometry = decoded(data)?;
            let at = time(message.timestamp)?;
            let pose = message.pose.ok_or(DecodeError::Missing("pose"))?;
            let pose = framed(message.frame_id, message.body_frame_id, at, pose)?;
            poses.push(pose.with_covariance(&message.pose_covariance));
        }
        FoxglovePose::FrameTransform => poses.push(transform(decoded(data)?)?),
        FoxglovePose::FrameTransforms => {
            let message: FrameTransforms = decoded(data)?;
            for child in message.transforms {
                poses.push(transform(child)?);
            }
        }
    }
    Ok(())
}

pub(super) fn mark(data: &[u8]) -> Result<StampedMark, DecodeError> {
    let message: Event = decoded(data)?;
    Ok(StampedMark {
        stamp: time(message.start_time)?,
        event: message
            .metadata
            .into_iter()
            .find(|pair| pair.key == MARK_EVENT_KEY && !pair.value.is_empty())
            .map(|pair| pair.value),
    })
}

/// Instant, and names, angles \[rad\] and rates [rad/s] of joints, of a `foxglove.JointStates`.
pub fn joint_states(data: &[u8]) -> Result<(Stamp, Vec<JointReading>), DecodeError> {
    let message: JointStates = decoded(data)?;
    let at = time(message.timestamp)?.unwrap_or(Stamp(0));
    let joints = message.joints.into_iter().map(|joint| {
        let angle_rad = joint.position.ok_or(DecodeError::Missing("position"))?;
        Ok((joint.name, angle_rad, joint.velocity))
    });
    Ok((at, joints.collect::<Result<_, DecodeError>>()?))
}

fn decoded<M: Decode>(data: &[u8]) -> Result<M, DecodeError> {
    M::decode(data).map_err(|error| DecodeError::Protobuf(error.to_string()))
}

fn transform(message: FrameTransform) -> Result<FramedPose, DecodeError> {
    let at = time(message.timestamp)?;
    let pose = Pose {
        position: message.translation,
        orientation: message.rotation,
    };
    framed(message.parent_frame_id, message.child_frame_id, at, pose)
}

fn framed(
    parent: String,
    child: String,
    stamp: Option<Stamp>,
    pose: Pose,
) -> Result<FramedPose, DecodeError> {
    let Vector3 { x, y, z } = pose.position.ok_or(DecodeError::Missing("position"))?;
    let position_m = nalgebra::Vector3::new(x, y, z);
    let Quaternion { x, y, z, w } = pose
        .orientation
        .ok_or(DecodeError::Missing("orientation"))?;
    Ok(FramedPose::new(
        parent,
        child,
        stamp,
        position_m,
        [x, y, z, w],
    ))
}

fn time(timestamp: Option<Timestamp>) -> Result<Option<Stamp>, DecodeError> {
    timestamp.map_or(Ok(None), |at| stamp(i64::from(at.sec()), at.nsec()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::{Mark, PoseSample};
    use crate::wire::encode::{self, Transform};

    fn sample() -> PoseSample {
        PoseSample::new(
            Stamp(1_700_000_000_123_456_789),
            nalgebra::Vector3::new(0.1, -0.2, 0.3),
            [0.5, -0.5, 0.5, 0.5],
        )
    }

    #[test]
    fn what_is_encoded_is_decoded() {
        let mut found = Vec::new();
        let bytes = encode::pose_in_frame("world", &sample()).expect("encode");
        poses(FoxglovePose::PoseInFrame, &bytes, &mut found).expect("decode");
        let transforms = ["pencil", "hat"].map(|child| Transform {
            parent: "world",
            child,
            sample: sample(),
        });
        let bytes = encode::frame_transforms(&transforms).expect("encode");
        poses(FoxglovePose::FrameTransforms, &bytes, &mut found).expect("decode");
        let children: Vec<_> = found.iter().map(|pose| pose.child.as_str()).collect();
        assert_eq!(children, ["", "pencil", "hat"]);
        for pose in &found {
            assert_eq!(pose.parent, "world");
            assert_eq!(pose.sample(Stamp(7)), sample());
        }
    }

    #[test]
    fn marks_come_back_with_and_without_a_name() {
        for event in [None, Some("bounce".to_owned())] {
            let given = Mark {
                stamp: Stamp(1_000_000_000),
                event,
            };
            let bytes = encode::event(&given).expect("encode");
            assert_eq!(mark(&bytes).expect("decode").mark(Stamp(7)), given);
        }
    }

    #[test]
    fn a_zero_stamp_is_none() {
        let bytes = encode::pose_in_frame(
            "world",
            &PoseSample {
                stamp: Stamp(0),
                ..sample()
            },
        )
        .expect("encode");
        let mut found = Vec::new();
        poses(FoxglovePose::PoseInFrame, &bytes, &mut found).expect("decode");
        assert_eq!(found[0].stamp, None);
        assert_eq!(found[0].sample(Stamp(7)).stamp, Stamp(7));
    }

    #[test]
    fn a_message_without_a_pose_is_said_to_have_none() {
        let mut found = Vec::new();
        // An empty protobuf is a valid message with every field absent.
        assert_eq!(
            poses(FoxglovePose::PoseInFrame, &[], &mut found),
            Err(DecodeError::Missing("pose"))
        );
        assert_eq!(
            poses(FoxglovePose::FrameTransform, &[], &mut found),
            Err(DecodeError::Missing("position"))
        );
        assert!(found.is_empty());
    }
}
