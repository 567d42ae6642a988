//! Stage 2: clean the streams, correct marks that are off their collision by reaction time, and cut
//! the streams at the marks. The segments of an edited sketch are joined instead.
//!
//! [`clean`](clean::clean) sorts the trackers' readings by stamp, leaves out unusable ones and
//! counts them by reason, transforms poses from the tracker to the body, and matches the
//! performer's marks to the scene's events. Its result does not depend on the order in which
//! readings arrived. Where marks are absent, [`propose()`] finds collisions in the stream,
//! in a whole toss (`toss`) where a flight ends.
//! [`refine()`] moves each mark to the kink of the motion near it, [`relocate_marks()`] moves marks
//! that are far from any kink, [`regrip()`] those at which a hand lets go of something, [`press()`] those of contacts that last, and [`cut()`] makes the segments.
//! [`seen_phases()`] finds what is no flight.
//! [`hold()`] smooths the streams of bodies in the hand, which have no flights.

pub mod clean;
mod complete;
pub mod cut;
mod edited;
pub mod error;
pub mod hold;
mod marks;
mod outliers;
mod prefix;
mod press;
pub mod propose;
mod reading;
pub mod refine;
mod regrip;
pub mod relocate;
mod seen;
pub mod smooth;
mod stays;
mod stick;
mod toss;
mod units;

pub use cut::cut;
pub use error::SegmentError;
pub use hold::{grip, hold};
pub use press::press;
pub use propose::{Proposal, ends_of_motion_s, propose};
pub use refine::{loosen, refine};
pub use regrip::regrip;
pub use relocate::relocate_marks;
pub use stays::{said, seen_phases};
pub use stick::stuck;
