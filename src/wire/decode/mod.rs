//! Messages → motion. The name of a channel's schema and the encoding of its messages determine how
//! they are read ([`PoseFormat::of`], [`MarkFormat::of`]); one file per encoding.

mod error;
mod format;
mod json;
mod message;
mod protobuf;
mod ros;
mod ros_reader;

pub use error::DecodeError;
pub use format::{MARK_SCHEMAS, MarkFormat, POSE_SCHEMAS, PoseFormat};
pub use message::{FramedPose, StampedMark};
pub use protobuf::joint_states;
pub use ros::text as decode_text;
