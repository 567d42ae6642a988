//! The content of messages of trackers and of marks, independent of their encoding.

use nalgebra::Vector3;

use super::error::DecodeError;
use crate::motion::{Covariance, Holds, Mark, PoseSample, SampleSource, Stamp};

/// A pose, or a part of one, as a message gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct FramedPose {
    /// Frame in which the pose is given.
    pub parent: String,
    /// Name of the child frame, or the index in an array of poses. Empty where the message holds a
    /// single pose without a name.
    pub child: String,
    /// When it was measured; `None` where the message has no stamp or a zero one.
    pub stamp: Option<Stamp>,
    /// Position \[m\], as sent; a direction in its place; zero where neither is held.
    pub position_m: Vector3<f64>,
    /// Quaternion, as sent; the identity where none is held.
    pub quaternion_xyzw: [f64; 4],
    /// Which of them it holds.
    pub holds: Holds,
    /// Covariance, where it has one that is not all zero.
    pub covariance: Option<Covariance>,
}

impl FramedPose {
    /// A pose without a covariance.
    pub(super) fn new(
        parent: String,
        child: String,
        stamp: Option<Stamp>,
        position_m: Vector3<f64>,
        quaternion_xyzw: [f64; 4],
    ) -> Self {
        Self {
            parent,
            child,
            stamp,
            position_m,
            quaternion_xyzw,
            holds: Holds::Pose,
            covariance: None,
        }
    }

    /// A position or a direction alone.
    pub(super) fn vector(
        parent: String,
        stamp: Option<Stamp>,
        vector: Vector3<f64>,
        holds: Holds,
    ) -> Self {
        Self {
            holds,
            ..Self::new(parent, String::new(), stamp, vector, [0.0, 0.0, 0.0, 1.0])
        }
    }

    /// With a covariance, row by row; all zeros mean that it is unknown.
    pub(super) fn with_covariance(self, rows: &[f64]) -> Self {
        let known = rows.iter().any(|entry| *entry != 0.0);
        let rows: Option<&[f64; 36]> = rows.try_into().ok().filter(|_| known);
        Self {
            covariance: rows.map(Covariance::of_rows),
            ..self
        }
    }

    /// The sample, stamped `fallback` where the message has no stamp.
    pub fn sample(&self, fallback: Stamp) -> PoseSample {
        PoseSample {
            stamp: self.stamp.unwrap_or(fallback),
            position_m: self.position_m,
            quaternion_xyzw: self.quaternion_xyzw,
            holds: self.holds,
            covariance: self.covariance,
            open: None,
            from: SampleSource::Tracker,
        }
    }
}

/// A mark as a message gives it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StampedMark {
    /// When it was made; `None` where the message has no stamp or a zero one.
    pub stamp: Option<Stamp>,
    /// Name of the scene's event that it marks; `None` for the next one in order.
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
    Point3InFrame,
    Odometry,
}

/// ROS messages that hold poses, of ROS 2 or of ROS 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RosPose {
    PoseStamped,
    /// It has neither a stamp nor a frame.
    Pose,
    PoseArray,
    PoseWithCovarianceStamped,
    Odometry,
    TransformStamped,
    TfMessage,
    PointStamped,
    QuaternionStamped,
    Vector3Stamped,
    /// Of mocap4r2's drivers.
    RigidBodies,
    /// Of motion_capture_tracking, which Crazyswarm2 uses.
    NamedPoseArray,
}

impl RosPose {
    /// The message of a name as ROS 1 has it, `package/Message`; ROS 2 has `package/msg/Message`.
    pub(super) fn named(package: &str, message: &str) -> Option<Self> {
        match (package, message) {
            ("geometry_msgs", "PoseStamped") => Some(Self::PoseStamped),
            ("geometry_msgs", "Pose") => Some(Self::Pose),
            ("geometry_msgs", "PoseArray") => Some(Self::PoseArray),
            ("geometry_msgs", "PoseWithCovarianceStamped") => Some(Self::PoseWithCovarianceStamped),
            ("geometry_msgs", "TransformStamped") => Some(Self::TransformStamped),
            ("geometry_msgs", "PointStamped") => Some(Self::PointStamped),
            ("geometry_msgs", "QuaternionStamped") => Some(Self::QuaternionStamped),
            ("geometry_msgs", "Vector3Stamped") => Some(Self::Vector3Stamped),
            ("nav_msgs", "Odometry") => Some(Self::Odometry),
            ("tf2_msgs", "TFMessage") | ("tf", "tfMessage") => Some(Self::TfMessage),
            // The package had another name before.
            ("mocap4r2_msgs" | "mocap_msgs", "RigidBodies") => Some(Self::RigidBodies),
            ("motion_capture_tracking_interfaces", "NamedPoseArray") => Some(Self::NamedPoseArray),
            _ => None,
        }
    }
}

/// A stamp from seconds and nanoseconds; `None` where both are zero. Fails where it does not fit in
/// 64 bits of nanoseconds.
pub(super) fn stamp(seconds: i64, nanoseconds: u32) -> Result<Option<Stamp>, DecodeError> {
    let total = seconds
        .checked_mul(1_000_000_000)
        .and_then(|whole| whole.checked_add(i64::from(nanoseconds)))
        .ok_or(DecodeError::Stamp(seconds))?;
    Ok((total != 0).then_some(Stamp(total)))
}
