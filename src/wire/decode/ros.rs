//! Decodes messages of ROS 2 and ROS 1 that hold poses or marks: the same fields, laid out in another way.

use nalgebra::Vector3;

use super::error::DecodeError;
use super::message::{FramedPose, RosPose, StampedMark};
use super::ros_reader::RosReader;
use crate::motion::Holds;

/// A pose or transform: seven doubles.
const POSE_BYTES: usize = 7 * 8;
/// The smallest `TransformStamped`: stamp, two empty strings, seven doubles.
const TRANSFORM_BYTES: usize = 8 + 4 + 4 + POSE_BYTES;
/// The smallest named pose: an empty string, seven doubles.
const NAMED_BYTES: usize = 4 + POSE_BYTES;
/// The smallest rigid body: that, and how many markers.
const BODY_BYTES: usize = 4 + NAMED_BYTES;
/// The smallest marker: kind, index, an empty string, three doubles.
const MARKER_BYTES: usize = 1 + 4 + 4 + 3 * 8;

/// Appends the poses of a message of ROS 2.
pub(super) fn cdr_poses(
    message: RosPose,
    data: &[u8],
    poses: &mut Vec<FramedPose>,
) -> Result<(), DecodeError> {
    read(message, RosReader::cdr(data)?, poses)
}

/// Appends the poses of a message of ROS 1.
pub(super) fn ros1_poses(
    message: RosPose,
    data: &[u8],
    poses: &mut Vec<FramedPose>,
) -> Result<(), DecodeError> {
    read(message, RosReader::ros1(data), poses)
}

fn read(
    message: RosPose,
    mut reader: RosReader,
    poses: &mut Vec<FramedPose>,
) -> Result<(), DecodeError> {
    match message {
        RosPose::PoseStamped => {
            let header = reader.header()?;
            poses.push(reader.pose(header, String::new())?);
        }
        RosPose::Pose => poses.push(reader.pose((None, String::new()), String::new())?),
        RosPose::PoseWithCovarianceStamped => {
            let header = reader.header()?;
            let pose = reader.pose(header, String::new())?;
            poses.push(pose.with_covariance(&reader.covariance()?));
        }
        RosPose::Odometry => {
            let header = reader.header()?;
            let child = reader.name("child_frame_id")?;
            let pose = reader.pose(header, child)?;
            poses.push(pose.with_covariance(&reader.covariance()?));
        }
        RosPose::PointStamped | RosPose::Vector3Stamped => {
            let (stamp, parent) = reader.header()?;
            let vector = reader.vector("point")?;
            let holds = match message {
                RosPose::PointStamped => Holds::Position,
                _ => Holds::Direction,
            };
            poses.push(FramedPose::vector(parent, stamp, vector, holds));
        }
        RosPose::QuaternionStamped => {
            let (stamp, parent) = reader.header()?;
            let quaternion_xyzw = reader.quaternion()?;
            poses.push(FramedPose {
                holds: Holds::Orientation,
                ..FramedPose::new(
                    parent,
                    String::new(),
                    stamp,
                    Vector3::zeros(),
                    quaternion_xyzw,
                )
            });
        }
        RosPose::TransformStamped => {
            let header = reader.header()?;
            let child = reader.name("child_frame_id")?;
            poses.push(reader.pose(header, child)?);
        }
        RosPose::TfMessage => {
            for _ in 0..reader.count(TRANSFORM_BYTES, "transforms")? {
                let header = reader.header()?;
                let child = reader.name("child_frame_id")?;
                poses.push(reader.pose(header, child)?);
            }
        }
        RosPose::PoseArray => {
            let header = reader.header()?;
            for index in 0..reader.count(POSE_BYTES, "poses")? {
                poses.push(reader.pose(header.clone(), index.to_string())?);
            }
        }
        RosPose::NamedPoseArray => {
            let header = reader.header()?;
            for _ in 0..reader.count(NAMED_BYTES, "poses")? {
                let name = reader.name("name")?;
                poses.push(reader.pose(header.clone(), name)?);
            }
        }
        RosPose::RigidBodies => {
            let header = reader.header()?;
            reader.u32("frame_number")?;
            for _ in 0..reader.count(BODY_BYTES, "rigidbodies")? {
                let name = reader.name("rigid_body_name")?;
                for _ in 0..reader.count(MARKER_BYTES, "markers")? {
                    reader.u8("id_type")?;
                    reader.u32("marker_index")?;
                    reader.name("marker_name")?;
                    reader.vector("translation")?;
                }
                poses.push(reader.pose(header.clone(), name)?);
            }
        }
    }
    Ok(())
}

/// The mark that a header of ROS 2 is.
pub(super) fn cdr_mark(data: &[u8]) -> Result<StampedMark, DecodeError> {
    mark(RosReader::cdr(data)?)
}

/// The mark that a header of ROS 1 is.
pub(super) fn ros1_mark(data: &[u8]) -> Result<StampedMark, DecodeError> {
    mark(RosReader::ros1(data))
}

fn mark(mut reader: RosReader) -> Result<StampedMark, DecodeError> {
    let (stamp, event) = reader.header()?;
    Ok(StampedMark {
        stamp,
        event: (!event.is_empty()).then_some(event),
    })
}

/// The text of a `std_msgs/msg/String`.
pub fn text(data: &[u8]) -> Result<String, DecodeError> {
    RosReader::cdr(data)?.text("data")
}

#[cfg(test)]
mod tests;
