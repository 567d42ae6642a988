//! Journals that a crash left → recordings.

use std::fs::File;
use std::path::{Path, PathBuf};

use super::error::WriteError;
use super::journal::PART_SUFFIX;
use super::merge::{self, Additions};
use crate::wire::Container;
use crate::wire::container::Damage;

/// What was saved.
#[derive(Clone, Debug, PartialEq)]
pub struct Recovered {
    /// The recording that was made.
    pub path: PathBuf,
    /// Messages by topic.
    pub topics: Vec<(String, u64)>,
    /// Log times of the first and the last message \[ns\].
    pub log_times: Option<(u64, u64)>,
    /// Bytes of the journal.
    pub bytes: u64,
    /// What of it could not be read, the first few.
    pub damages: Vec<Damage>,
    /// Whether the journal is gone: it is kept where it has damage beyond a missing end.
    pub is_removed: bool,
}

/// Writes the recording of what a journal holds, beside it and under its final name, and
/// removes the journal if nothing of it but an incomplete end is missing from the recording.
///
/// Fails, leaving everything as it is, where the journal is still being written, where there is
/// nothing in it, and where its final name is taken.
pub fn recover(part: &Path) -> Result<Recovered, WriteError> {
    let path = final_of(part).ok_or_else(|| WriteError::NoJournal {
        path: part.to_owned(),
    })?;
    let file = File::open(part).map_err(WriteError::io(part, "open"))?;
    if file.try_lock_shared().is_err() {
        return Err(WriteError::Busy {
            path: part.to_owned(),
        });
    }
    if path.exists() {
        return Err(WriteError::Exists { path });
    }
    let bytes = std::fs::read(part).map_err(WriteError::io(part, "read"))?;
    let length = bytes.len() as u64;
    let container = Container::new(bytes).map_err(|source| WriteError::Container {
        path: part.to_owned(),
        source,
    })?;
    merge::write(&path, &container, None, Additions::default())?;
    let damages = container.damages();
    let is_end = |damage: &Damage| matches!(damage, Damage::Cut { .. } | Damage::NoEnd);
    let is_whole = damages.count() == damages.first().len() && damages.first().iter().all(is_end);
    if is_whole {
        std::fs::remove_file(part).map_err(WriteError::io(part, "remove"))?;
    }
    let channels = container.channels().values();
    Ok(Recovered {
        path,
        topics: channels.map(|c| (c.topic.clone(), c.messages)).collect(),
        log_times: container.log_times(),
        bytes: length,
        damages: damages.first().to_vec(),
        is_removed: is_whole,
    })
}

/// The journals in a folder that nobody is writing, by name.
pub fn abandoned(folder: &Path) -> Result<Vec<PathBuf>, WriteError> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(WriteError::io(folder, "list")(error)),
    };
    let mut parts = Vec::new();
    for entry in entries {
        let path = entry.map_err(WriteError::io(folder, "list"))?.path();
        let is_free = || File::open(&path).is_ok_and(|file| file.try_lock_shared().is_ok());
        if final_of(&path).is_some() && is_free() {
            parts.push(path);
        }
    }
    parts.sort();
    Ok(parts)
}

/// `take.mcap.part` → `take.mcap`.
fn final_of(part: &Path) -> Option<PathBuf> {
    let name = part.file_name()?.to_str()?.strip_suffix(PART_SUFFIX)?;
    (name.ends_with(".mcap") && !name.starts_with('.')).then(|| part.with_file_name(name))
}
