//! Stage 1: recordings and memory become takes.
//!
//! A [`Recording`] is an MCAP file held in memory. Opening it walks through it once and says
//! what it holds and what of it is damaged; [`Recording::take`] gives all that a scene wants of
//! it in file order, [`Recording::source`] the same one by one. [`Source`] is what a driver
//! replays from; [`MemorySource`] is one without a file. [`live`] is the door to trackers that
//! run now, [`clock`] says when what they send was measured.

pub mod clock;
mod error;
pub mod live;
mod recording;
mod report;
mod route;
mod source;

pub use error::IngestError;
pub use recording::{Recording, SCENE_NAME, Take};
pub use report::{TakeReport, TopicReport};
pub use source::{MemorySource, RecordingSource, Source};

#[cfg(test)]
mod tests;
