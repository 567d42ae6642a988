//! Bytes ↔ motion, shared by ingest and write; no files.
//!
//! [`encode`] makes messages of what we hold. Whatever is a foxglove message comes from the
//! `foxglove` crate, whose types stop at this room's door.

pub mod encode;

pub use encode::{EncodeError, Encoded, Transform};
