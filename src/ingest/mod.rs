//! Stage 1: recordings and memory become takes.
//!
//! A [`Recording`] is an MCAP file held in memory. Opening it walks through it once and lists its
//! channels and its damage; [`Recording::take`] returns all events of a scene's topics in file
//! order, [`Recording::source`] the same one by one. [`Source`] is the interface from which a
//! driver replays; [`MemorySource`] is one without a file. `live` receives samples from running
//! trackers, [`clock`] stamps them. [`table`] reads poses from tables of numbers, which are no recordings
//! yet; [`Recording::poses`] and [`Recording::marks_on`] tell what a recording has without a scene.

mod captured;
pub mod clock;
mod error;
mod frames;
#[cfg(feature = "live")]
pub mod live;
mod mark_list;
mod marks;
mod path;
mod poses;
mod recording;
mod report;
mod route;
mod source;
mod survey;
pub mod table;

pub use crate::wire::container::{Digest, digest};
pub use crate::wire::{is_pipe, read_text, read_whole, regular};
pub use captured::CapturedSession;
pub use error::{IngestError, listed};
pub use mark_list::{ListedMark, MarkTime, marks_of_file};
pub use marks::MarkMessage;
pub use poses::PoseExtent;
pub use recording::{Recording, SCENE_NAME, Take};
pub use report::{TakeReport, TopicReport};
pub use source::{MemorySource, RecordingSource, Source};

#[cfg(test)]
mod tests;
