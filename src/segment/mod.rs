//! Stage 2: clean the streams and cut them at the marks.
//!
//! [`clean`](clean::clean) sorts what the trackers said by stamp, leaves out what cannot be
//! used and counts it by reason, moves poses from the tracker to the body, and matches the
//! performer's marks to the scene's events. Its result does not depend on the order in which
//! readings arrived.

pub mod clean;
pub mod error;
mod marks;

pub use error::SegmentError;
