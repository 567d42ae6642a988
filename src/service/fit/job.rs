//! What is asked for.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::ingest::Recording;
use crate::service::deadline::Deadline;
use crate::service::finish::{Opened, opened};
use crate::service::memory::{SceneInMemory, opened_with};

/// A recording.
#[derive(Clone, Debug)]
pub enum FitInput {
    /// A file.
    File(PathBuf),
    /// The bytes of one.
    Bytes {
        /// What it is called.
        name: PathBuf,
        /// What is in it.
        bytes: Vec<u8>,
        /// Another scene than its own.
        scene: Option<Box<SceneInMemory>>,
    },
}

impl FitInput {
    pub(super) fn name(&self) -> &Path {
        match self {
            Self::File(path) => path,
            Self::Bytes { name, .. } => name,
        }
    }

    /// Opens it with the scene of a file, or its own.
    pub(super) fn opened(&self, scene_file: Option<&Path>) -> anyhow::Result<Opened> {
        let (recording, own) = match self {
            Self::File(path) => (Recording::open_until(path, None)?, None),
            Self::Bytes { name, bytes, scene } => (
                Recording::from_bytes(name, bytes.clone())?,
                scene.as_deref(),
            ),
        };
        match own {
            Some(scene) if scene_file.is_none() => Ok(opened_with(recording, scene)),
            _ => opened(recording, scene_file, Deadline::begin(None)),
        }
    }
}

/// Which takes are held out.
#[derive(Clone, Debug, PartialEq)]
pub enum HoldOut {
    /// A share of them, by their contents.
    Share(f64),
    /// These files.
    Files(Vec<PathBuf>),
}

/// The input of [`fit`](super::fit).
#[derive(Clone, Debug)]
pub struct FitJob {
    /// The recordings.
    pub inputs: Vec<FitInput>,
    /// Scene file for all; each recording's own scene by default.
    pub scene: Option<PathBuf>,
    /// Names of quantities that have one value in all takes,
    pub shared: Vec<String>,
    /// and of those that each take draws about a mean.
    pub drawn: Vec<String>,
    /// Takes by which the answer is tried and not made.
    pub hold_out: Option<HoldOut>,
    /// Where the answer goes as a calibration; by default it is only returned.
    pub output: Option<PathBuf>,
    /// Where a page of it goes, if anywhere; a page that is there is replaced.
    pub page: Option<PathBuf>,
    /// Ends it between takes once it is set.
    pub stop: FitStop,
}

/// Tells a fit to end.
#[derive(Clone, Debug, Default)]
pub struct FitStop(Arc<AtomicBool>);

impl FitStop {
    /// From now on.
    pub fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    pub(super) fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
