//! Stage 5: motion becomes files.
//!
//! Every file is written under a temporary name beside its final one ([`atomic`]) and renamed
//! when it is whole: what bears the final name can be read. [`recording`] writes takes as the
//! trackers gave them. Bytes depend on what is written and on nothing else: no clock, no
//! thread count, no library version.

pub mod atomic;
pub mod error;
mod options;
pub mod recording;

pub use error::WriteError;
pub use recording::RecordingWriter;
