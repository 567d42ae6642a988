//! Journals that a crash left → recordings.

use std::fs::{File, OpenOptions};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::atomic::{AtomicFile, is_one_file, rename_to_new};
use super::error::WriteError;
use super::merge::{self, Additions};
use super::topics::{COUNTS, TAKE_METADATA};
use crate::wire::container::Damage;
use crate::wire::{Container, regular};

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
/// A process may be killed at any point of this: the next run ends as one that is not killed.
///
/// Fails, leaving everything as it is, where the journal is still being written or recovered, where
/// there is nothing in it, and where its final name is taken by another file.
pub fn recover(part: &Path) -> Result<Recovered, WriteError> {
    let path = final_of(part).ok_or_else(|| WriteError::NoJournal {
        path: part.to_owned(),
    })?;
    let file = open(part).map_err(WriteError::io(part, "open"))?;
    if !locks(&file) {
        return Err(WriteError::Busy {
            path: part.to_owned(),
        });
    }
    let bytes = regular::read(part).map_err(WriteError::io(part, "read"))?;
    let length = bytes.len() as u64;
    let container = Container::of_journal(bytes).map_err(|source| WriteError::Container {
        path: part.to_owned(),
        source,
    })?;
    let journal = if is_one_file(part, &path) {
        // Its recorder was killed as it renamed it: the recording is the journal, whole.
        rename_to_new(part, &path)?;
        path.clone()
    } else {
        let recording = AtomicFile::create_new(&path, part)?;
        merge::write(recording, &container, None, Additions::default())?;
        put_aside(part)?
    };
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

/// Locks a journal. Who only looks whether it is being written, and a process that is just being started from
/// one that does, hold it for a moment: it is tried for half a second.
fn locks(file: &File) -> bool {
    (0..50).any(|attempt| {
        if attempt > 0 {
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        file.try_lock().is_ok()
    })
}

/// Opens a journal so that it can be locked: over a network that takes the right to write.
fn open(part: &Path) -> io::Result<File> {
    match regular::open_with(OpenOptions::new().read(true).write(true), part) {
        Err(error) if error.kind() == io::ErrorKind::PermissionDenied => regular::open(part),
        opened => opened,
    }
}

/// Gives a journal whose recording is there the name of one that was recovered.
fn put_aside(part: &Path) -> Result<PathBuf, WriteError> {
    let mut count = 1_u64;
    loop {
        let mut name = part.as_os_str().to_owned();
        name.push(RECOVERED_SUFFIX);
        if count > 1 {
            name.push(format!(".{count}"));
        }
        let journal = PathBuf::from(name);
        match rename_to_new(part, &journal) {
            Err(WriteError::Exists { .. }) => count += 1,
            renamed => return renamed.map(|()| journal),
        }
    }
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
        let is_free = || regular::open(&path).is_ok_and(|file| file.try_lock_shared().is_ok());
        if final_of(&path).is_some() && is_free() {
            parts.push(path);
        }
    }
    parts.sort();
    Ok(parts)
}

/// Whether a recording is of a live take that was not closed: its recording was stopped, by a full disk for
/// example, or its recorder was killed, so that its end is missing.
pub fn is_cut_short(recording: &Container) -> bool {
    let mut channels = recording.channels().values();
    let is_live = channels.any(|channel| channel.topic == COUNTS);
    is_live
        && !recording
            .metadata()
            .iter()
            .any(|of| of.name == TAKE_METADATA)
}

/// `take.mcap.part` → `take.mcap`.
fn final_of(part: &Path) -> Option<PathBuf> {
    let name = part.file_name()?.to_str()?.strip_suffix(PART_SUFFIX)?;
    (name.ends_with(".mcap") && !name.starts_with('.')).then(|| part.with_file_name(name))
}
