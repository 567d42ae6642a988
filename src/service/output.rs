//! Where what is made goes.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;

use crate::write::atomic::AtomicFile;

/// Where a file goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Destination {
    /// To that file.
    File(PathBuf),
    /// To whoever called.
    Caller,
}

/// Writes a file, whole or not at all.
pub(super) fn write_file(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let mut file = AtomicFile::create(path)?;
    file.write_all(bytes)
        .with_context(|| format!("{}: cannot write", path.display()))?;
    file.commit()?;
    Ok(())
}
