//! Stage 2: clean the streams, cut them at the marks, and move marks that reaction time has put
//! beside their collision. The segments of an edited sketch are joined instead.
//!
//! [`clean`](clean::clean) sorts what the trackers said by stamp, leaves out what cannot be
//! used and counts it by reason, moves poses from the tracker to the body, and matches the
//! performer's marks to the scene's events. Its result does not depend on the order in which
//! readings arrived. Where marks are absent, [`propose()`] says where the stream has kinks.
//! [`refine()`] looks for the kink that each mark stands for, [`relocate_marks()`] moves marks that are far
//! from any, and [`cut()`] makes the segments.

pub mod clean;
mod complete;
pub mod cut;
mod edited;
pub mod error;
mod marks;
mod outliers;
mod prefix;
pub mod propose;
pub mod refine;
pub mod relocate;
mod units;

pub use cut::cut;
pub use error::SegmentError;
pub use propose::{Proposal, propose};
pub use refine::{loosen, refine};
pub use relocate::relocate_marks;
