//! Temporaries of files that are being written, so that a process that is told to end leaves none.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

static PATHS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Stands for a temporary until it has its final name or is gone.
#[derive(Debug)]
pub(super) struct Unfinished(PathBuf);

impl Unfinished {
    /// Creates a temporary in a directory.
    pub(super) fn create(
        builder: &tempfile::Builder,
        directory: &Path,
    ) -> io::Result<(NamedTempFile, Self)> {
        let mut paths = paths();
        let temporary = builder.tempfile_in(directory)?;
        let path = temporary.path().to_owned();
        paths.insert(path.clone());
        Ok((temporary, Self(path)))
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        paths().remove(&self.0);
    }
}

/// Removes the temporaries of all files that are being written, then ends the process as `end` does: meanwhile
/// none is created. Journals of live takes are no temporaries.
pub fn remove_unfinished(end: impl FnOnce()) {
    let paths = paths();
    for path in paths.iter() {
        // One that has just got its final name is not there.
        let _ = std::fs::remove_file(path);
    }
    end();
}

fn paths() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    PATHS.lock().unwrap_or_else(PoisonError::into_inner)
}
