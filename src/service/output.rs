//! Where what is made goes.

use std::io::Write;
use std::path::Path;

use anyhow::{Context, bail};

use crate::write::WriteError;
use crate::write::atomic::AtomicFile;

/// Writes a file, whole or not at all.
pub fn write_file(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    write_file_of(path, bytes, &[])
}

/// [`write_file`] of what is made of other files: nobody may read it who may not read them.
pub(super) fn write_file_of(path: &Path, bytes: &[u8], made_of: &[&Path]) -> anyhow::Result<()> {
    write_to(AtomicFile::create_of(path, made_of)?, bytes)
}

/// [`write_file_of`] one that people work on by hand: it replaces none, not even one that came since it
/// was looked for ([`refuse_present`]).
pub(super) fn write_new_file(path: &Path, bytes: &[u8], made_of: &[&Path]) -> anyhow::Result<()> {
    let written = write_to(AtomicFile::create_fresh_of(path, made_of)?, bytes);
    written.or_else(|error| match error.downcast_ref() {
        Some(WriteError::Exists { .. }) => is_present(path),
        _ => Err(error),
    })
}

/// Fails where something has the name, before the work is done.
pub(super) fn refuse_present(path: &Path) -> anyhow::Result<()> {
    match std::fs::symlink_metadata(path) {
        Ok(_) if !crate::ingest::is_pipe(path) => is_present(path),
        _ => Ok(()),
    }
}

fn is_present(path: &Path) -> anyhow::Result<()> {
    bail!(
        "{}: is there already, expected another name: -o FILE",
        path.display()
    )
}

fn write_to(mut file: AtomicFile, bytes: &[u8]) -> anyhow::Result<()> {
    if let Err(error) = file.write_all(bytes) {
        return Err(error).with_context(|| format!("{}: cannot write", file.path().display()));
    }
    Ok(file.commit()?)
}
