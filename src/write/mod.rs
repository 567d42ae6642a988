//! Stage 5: motion becomes files.
//!
//! Every file is written under a temporary name beside its final one ([`atomic`]) and renamed
//! when it is whole: what bears the final name can be read. [`recording`] writes takes as the
//! trackers gave them; [`estimate`] writes what came in, unchanged, and the estimated motion
//! beside it, on the topics that [`topics`] lists; [`marks`] changes the marks of a recording, [`part`] cuts a take out of one, [`join`] puts several together, [`keyframes`]
//! writes sketches as text that people edit, [`export`] the motion for programs that do not read recordings.
//! `journal` keeps a live take as it comes, and [`mod@recover`] makes a recording of what a crash
//! left of it; `live` publishes on iceoryx2, and `show` has the messages for viewers. Poses are those of
//! [`sampling`](crate::sampling), drawings those of [`visual`](crate::visual), words and numbers those of
//! [`report`](crate::report). The bytes of a file depend on its content only: no clock, no thread
//! count, no library version.

pub mod atomic;
mod dialect;
mod drawing;
pub mod error;
pub mod estimate;
pub mod export;
pub mod join;
#[cfg(feature = "live")]
pub mod journal;
pub mod keyframes;
#[cfg(feature = "live")]
pub mod live;
pub mod marks;
mod merge;
mod options;
pub mod part;
pub mod recording;
pub mod recover;
#[cfg(feature = "live")]
pub mod show;
mod skeleton;
pub mod topics;
mod trails;
mod unfinished;
mod urdf;

pub use error::WriteError;
pub use estimate::{
    DEFAULT_FRAME_RATE_HZ, DEFAULT_WORLD_FRAME, EstimateFile, Written, write_estimate,
};
pub use join::{Joined, joined};
#[cfg(feature = "live")]
pub use journal::Journal;
pub use keyframes::{csv_of_sketch, toml_of_sketch};
#[cfg(feature = "live")]
pub use live::{EstimatePublisher, LabelPublisher, TakePublisher, TrackerPublisher};
pub use marks::write_marks;
pub use merge::has_estimate;
pub use part::write_part;
pub use recording::RecordingWriter;
pub use recover::{Recovered, abandoned, is_cut_short, recover};
pub use unfinished::remove_unfinished;
