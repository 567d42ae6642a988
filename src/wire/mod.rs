//! Bytes ↔ motion, shared by ingest and write; no files.
//!
//! [`container`] finds the messages in an MCAP file held in memory, [`decode`] turns them into
//! motion, [`encode`] turns motion into foxglove messages, [`mod@keyframe`] has our own for written sketches, [`ros2`] into ROS 2 messages, [`translate`] the former into the latter. `live`
//! is the contract over iceoryx2, [`pipe`] the name of stdin and stdout, [`regular`] the door to all other files that are read. Foxglove's message types come from the `foxglove` crate and are
//! used in this room only.

pub mod container;
pub mod decode;
pub mod encode;
pub mod keyframe;
#[cfg(feature = "live")]
pub mod live;
pub mod pipe;
pub mod regular;
pub mod ros2;
pub mod translate;

pub use container::{Container, ContainerError};
pub use decode::{DecodeError, FramedPose, MarkFormat, PoseFormat, decode_text};
pub use encode::{EncodeError, Encoded, JointState, Transform};
pub use keyframe::{KEYFRAME_SCHEMA, decode_keyframe, encode_keyframe};
pub use pipe::{is_pipe, read_text, read_whole};
