//! Journals that a crash left → recordings.

use std::fs::File;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::atomic::sync_directory_of;
use super::error::WriteError;
use super::merge::{self, Additions};
use crate::wire::Container;
use crate::wire::container::Damage;

/// What is appended to the name of a journal that is not closed.
pub const PART_SUFFIX: &str = ".part";

/// What is appended to the name of a journal that was recovered; a number after it if that is
/// taken.
pub const RECOVERED_SUFFIX: &str = ".recovered";

/// What was saved.
#[derive(Clone, Debug, PartialEq)]
pub struct Recovered {
    /// The recording that was made.
    pub path: PathBuf,
    /// What the journal is called now.
    pub journal: PathBuf,
    /// Messages by topic.
    pub topics: Vec<(String, u64)>,
    /// Log times of the first and the last message \[ns\].
    pub log_times: Option<(u64, u64)>,
    /// Bytes of the journal.
    pub bytes: u64,
    /// Which of them were not read.
    pub unread: Vec<Range<usize>>,
    /// What is wrong with it, the first few.
    pub damages: Vec<Damage>,
    /// Whether everything in it is in the recording: only its end may be missing.
    pub is_whole: bool,
}

/// Writes the recording of all that can be read in a journal, beside it and under its final name.
/// When that is durable the journal is renamed to `….mcap.part.recovered`: it is never removed,
/// and not found by [`abandoned`] again.
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
    if is_taken(&path) {
        return Err(WriteError::Exists { path });
    }
    let bytes = std::fs::read(part).map_err(WriteError::io(part, "read"))?;
    let length = bytes.len() as u64;
    let container = Container::new(bytes).map_err(|source| WriteError::Container {
        path: part.to_owned(),
        source,
    })?;
    merge::write(&path, &container, None, Additions::default())?;
    let journal = put_aside(part)?;
    let damages = container.damages();
    let channels = container.channels().values();
    Ok(Recovered {
        path,
        journal,
        topics: channels.map(|c| (c.topic.clone(), c.messages)).collect(),
        log_times: container.log_times(),
        bytes: length,
        unread: damages.unread().to_vec(),
        damages: damages.first().to_vec(),
        is_whole: !damages.is_loss(),
    })
}

/// Gives a journal whose recording is there the name of one that was recovered.
fn put_aside(part: &Path) -> Result<PathBuf, WriteError> {
    let named = |end: &str| {
        let mut name = part.as_os_str().to_owned();
        name.push(RECOVERED_SUFFIX);
        name.push(end);
        PathBuf::from(name)
    };
    let names = std::iter::once(named("")).chain((2..).map(|n: u64| named(&format!(".{n}"))));
    let free = names.into_iter().find(|name| !is_taken(name));
    let journal = free.expect("there are names without end");
    std::fs::rename(part, &journal).map_err(WriteError::io(part, "rename"))?;
    sync_directory_of(&journal);
    Ok(journal)
}

/// Whether anything has that name, a link that leads nowhere too.
fn is_taken(path: &Path) -> bool {
    std::fs::symlink_metadata(path).is_ok()
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
