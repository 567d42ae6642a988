//! Bytes ↔ motion, shared by ingest and write; no files.
//!
//! [`container`] finds the messages in an MCAP file held in memory, [`decode`] makes motion of
//! them, [`encode`] makes messages of motion, [`ros2`] those of ROS 2. [`live`] is what goes over iceoryx2. Whatever is a foxglove message comes from the
//! `foxglove` crate, whose types stop at this room's door.

pub mod container;
pub mod decode;
pub mod encode;
pub mod live;
pub mod ros2;

pub use container::{Container, ContainerError};
pub use decode::{DecodeError, FramedPose, MarkFormat, PoseFormat};
pub use encode::{EncodeError, Encoded, Transform};
