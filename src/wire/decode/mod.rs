//! Messages → motion. What a channel carries is told by the name of its schema and the
//! encoding of its messages ([`PoseFormat::of`], [`MarkFormat::of`]); one file per encoding.

mod cdr;
mod error;
mod format;
mod json;
mod message;
mod protobuf;

pub use error::DecodeError;
pub use format::{MARK_SCHEMAS, MarkFormat, POSE_SCHEMAS, PoseFormat};
pub use message::{FramedPose, StampedMark};
