//! Where what is made goes.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;

use super::finish::beside;
use crate::write::atomic::AtomicFile;

/// Where what is made of a recording goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Destination {
    /// To the file beside the recording that has its own ending.
    Beside,
    /// To that file.
    File(PathBuf),
    /// To whoever called.
    Caller,
}

impl Destination {
    /// The file; `None` where the caller gets it. Fails where it would be named after stdin.
    pub(super) fn file(&self, input: &Path, ending: &str) -> anyhow::Result<Option<PathBuf>> {
        match self {
            Self::Beside => beside(input, ending).map(Some),
            Self::File(path) => Ok(Some(path.clone())),
            Self::Caller => Ok(None),
        }
    }
}

/// Writes a file, whole or not at all.
pub(super) fn write_file(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let mut file = AtomicFile::create(path)?;
    file.write_all(bytes)
        .with_context(|| format!("{}: cannot write", path.display()))?;
    file.commit()?;
    Ok(())
}
