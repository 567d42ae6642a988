//! What can go wrong when a file is written.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::sampling::SamplingError;
#[cfg(feature = "live")]
use crate::wire::live::LiveError;
use crate::wire::translate::TranslateError;
use crate::wire::{ContainerError, DecodeError, EncodeError};

/// Why a file was not written. Nothing is left under its final name.
#[derive(Debug, Error)]
pub enum WriteError {
    /// The file or its temporary cannot be made, written or renamed.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// The final name.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// What the system says.
        source: io::Error,
    },
    /// The MCAP writer refuses a record.
    #[error("{}: {source}", path.display())]
    Mcap {
        /// The final name.
        path: PathBuf,
        /// What the writer says.
        source: mcap::McapError,
    },
    /// A message cannot be encoded.
    #[error("{}: topic {topic}: {source}", path.display())]
    Encode {
        /// The final name.
        path: PathBuf,
        /// Topic of the message.
        topic: String,
        /// The cause.
        source: EncodeError,
    },
    /// A message of an estimate cannot be read back.
    #[error("{}: topic {topic}: {source}; make the estimate again with `enact replay`", path.display())]
    Decode {
        /// The recording.
        path: PathBuf,
        /// Topic of the message.
        topic: String,
        /// The cause.
        source: DecodeError,
    },
    /// A message of an estimate cannot be said in ROS 2's terms.
    #[error("{}: topic {topic}: {source}; make the estimate again with `enact replay`", path.display())]
    Translate {
        /// The recording.
        path: PathBuf,
        /// Topic of the message.
        topic: String,
        /// The cause.
        source: TranslateError,
    },
    /// There is no estimate in a recording.
    #[error("{}: has no estimate, expected what `enact replay` writes of it", path.display())]
    NoEstimate {
        /// The recording.
        path: PathBuf,
    },
    /// The log time of a message is before 1970.
    #[error("{}: topic {topic}: log time {log_time} ns is negative", path.display())]
    LogTime {
        /// The final name.
        path: PathBuf,
        /// Topic of the message.
        topic: String,
        /// As given.
        log_time: i64,
    },
    /// The output is the input.
    #[error("{}: is the input; write to another file", path.display())]
    IsInput {
        /// The final name.
        path: PathBuf,
    },
    /// What has the name of an output is not a file.
    #[error("{}: is {what}, expected the name of a file or a new one", path.display())]
    NotAFile {
        /// The final name.
        path: PathBuf,
        /// The kind of what is there: a device, a pipe, a folder.
        what: &'static str,
    },
    /// A name is taken that must not be.
    #[error("{}: is there already and is not replaced; move it away first", path.display())]
    Exists {
        /// The name.
        path: PathBuf,
    },
    /// What is to be recovered is no journal by its name.
    #[error("{}: is no journal, expected a name that ends in .mcap.part", path.display())]
    NoJournal {
        /// As given.
        path: PathBuf,
    },
    /// A journal is still being written.
    #[error("{}: is being written", path.display())]
    Busy {
        /// The journal.
        path: PathBuf,
    },
    /// There is nothing in a journal.
    #[error("{}: {source}", path.display())]
    Container {
        /// The journal.
        path: PathBuf,
        /// In what way.
        source: ContainerError,
    },
    /// Recordings that are put together promise different things of their channels.
    #[error(
        "{}: has the profile {profile:?}, and {} has {expected:?}; expected recordings of one bag",
        path.display(), other.display()
    )]
    Profiles {
        /// A recording.
        path: PathBuf,
        /// Its profile.
        profile: String,
        /// Another recording.
        other: PathBuf,
        /// The profile of that.
        expected: String,
    },
    /// Something live cannot be had or sent.
    #[cfg(feature = "live")]
    #[error(transparent)]
    Live(#[from] LiveError),
    /// The motion cannot be sampled.
    #[error("{}: {source}", path.display())]
    Sampling {
        /// The final name.
        path: PathBuf,
        /// The cause.
        source: SamplingError,
    },
}

impl WriteError {
    /// For `map_err`: an I/O error while doing `action` to `path`.
    pub(super) fn io(path: &Path, action: &'static str) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| WriteError::Io {
            path,
            action,
            source,
        }
    }

    /// For `map_err`: the motion cannot be sampled.
    pub(super) fn sampling(path: &Path) -> impl FnOnce(SamplingError) -> Self {
        let path = path.to_owned();
        move |source| WriteError::Sampling { path, source }
    }

    /// For `map_err`: a message on `topic` cannot be encoded.
    pub(super) fn encode(path: &Path, topic: &str) -> impl FnOnce(EncodeError) -> Self {
        let (path, topic) = (path.to_owned(), topic.to_owned());
        move |source| WriteError::Encode {
            path,
            topic,
            source,
        }
    }

    /// For `map_err`: a message on `topic` cannot be read back.
    pub(super) fn decode(path: &Path, topic: &str) -> impl FnOnce(DecodeError) -> Self {
        let (path, topic) = (path.to_owned(), topic.to_owned());
        move |source| WriteError::Decode {
            path,
            topic,
            source,
        }
    }

    /// For `map_err`.
    pub(super) fn translate(path: &Path, topic: &str) -> impl FnOnce(TranslateError) -> Self {
        let (path, topic) = (path.to_owned(), topic.to_owned());
        move |source| WriteError::Translate {
            path,
            topic,
            source,
        }
    }

    /// For `map_err`: an error of the MCAP writer, which may be one of I/O.
    pub(super) fn mcap(path: &Path) -> impl FnOnce(mcap::McapError) -> Self {
        let path = path.to_owned();
        move |source| match source {
            mcap::McapError::Io(source) => WriteError::Io {
                path,
                action: "write",
                source,
            },
            source => WriteError::Mcap { path, source },
        }
    }
}
