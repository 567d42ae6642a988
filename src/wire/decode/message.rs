//! The content of pose and mark messages, independent of their encoding.

use nalgebra::Vector3;

use super::error::DecodeError;
use crate::motion::{Mark, PoseSample, Stamp};

/// A pose as a message gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct FramedPose {
    /// Frame in which the pose is given.
    pub parent: String,
    /// Name of the child frame, or the index in an array of poses. Empty where the message holds a
    /// single pose without a name.
    pub child: String,
    /// When it was measured; `None` where the message has no stamp or a zero one.
    pub stamp: Option<Stamp>,
    /// Position \[m\], as sent.
    pub position_m: Vector3<f64>,
    /// Quaternion, as sent.
    pub quaternion_xyzw: [f64; 4],
}

impl FramedPose {
    /// The sample, stamped `fallback` where the message has no stamp.
    pub fn sample(&self, fallback: Stamp) -> PoseSample {
        PoseSample::new(
            self.stamp.unwrap_or(fallback),
            self.position_m,
            self.quaternion_xyzw,
        )
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
}

/// ROS 2 messages that hold poses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RosPose {
    /// `PoseStamped`; `PoseWithCovarianceStamped` begins with the same bytes.
    PoseStamped,
    Odometry,
    TfMessage,
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
