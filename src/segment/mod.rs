//! Stage 2: clean the streams, cut them at the marks, and move marks that reaction time has put
//! beside their collision. The segments of an edited sketch are joined instead.
//!
//! [`clean`](clean::clean) sorts what the trackers said by stamp, leaves out what cannot be
//! used and counts it by reason, moves poses from the tracker to the body, and matches the
//! performer's marks to the scene's events. Its result does not depend on the order in which
//! readings arrived. [`refine()`] looks for the kink that each mark stands for, and [`cut()`] makes
//! the segments.

pub mod clean;
pub mod cut;
mod edited;
pub mod error;
mod marks;
pub mod refine;

pub use cut::cut;
pub use error::SegmentError;
pub use refine::refine;
