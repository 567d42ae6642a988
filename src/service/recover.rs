//! Journals that a crash left.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::write::{Recovered, abandoned, recover};

/// What was saved of a journal.
#[derive(Clone, Debug, Serialize)]
pub struct RecoveredLine {
    /// The journal.
    pub journal: String,
    /// The recording that was made of it.
    pub recording: String,
    /// Messages in it.
    pub messages: u64,
    /// Messages by topic.
    pub topics: Vec<(String, u64)>,
    /// From the first log time to the last.
    pub duration_s: f64,
    /// Bytes of the journal.
    pub bytes: u64,
    /// How many of them were not read into the recording.
    pub unread_bytes: u64,
    /// Where those are: offsets of the first, and of the one after the last.
    pub unread: Vec<(u64, u64)>,
    /// What is wrong with the journal, where it cost something.
    pub lost: Vec<String>,
    /// What is wrong with it where it cost nothing.
    pub notes: Vec<String>,
    /// Whether everything in it is in the recording.
    pub whole: bool,
    /// What the journal is called now.
    pub kept: String,
}

/// Recovers journals, or all abandoned ones in a folder, and hands over what became of each.
/// One that fails does not stop the others; fails where `each` does or a folder cannot be read.
pub fn recover_all(
    paths: &[PathBuf],
    mut each: impl FnMut(&Path, anyhow::Result<RecoveredLine>) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    for path in paths {
        let journals = if path.is_dir() {
            abandoned(path)?
        } else {
            vec![path.clone()]
        };
        for journal in journals {
            let result = recover(&journal);
            let line = result.map(|recovered| line(&journal, &recovered));
            each(&journal, line.map_err(Into::into))?;
        }
    }
    Ok(())
}

fn line(journal: &Path, recovered: &Recovered) -> RecoveredLine {
    let span = recovered.log_times.map(|(first, last)| last - first);
    let unread = recovered.unread.iter();
    let damages = recovered.damages.iter();
    let (notes, lost): (Vec<_>, Vec<_>) = damages.partition(|damage| damage.is_harmless());
    RecoveredLine {
        journal: journal.display().to_string(),
        recording: recovered.path.display().to_string(),
        messages: recovered.topics.iter().map(|(_, messages)| messages).sum(),
        topics: recovered.topics.clone(),
        duration_s: span.unwrap_or(0) as f64 * 1e-9,
        bytes: recovered.bytes,
        unread_bytes: recovered.unread.iter().map(|r| r.len() as u64).sum(),
        unread: unread.map(|r| (r.start as u64, r.end as u64)).collect(),
        lost: lost.iter().map(ToString::to_string).collect(),
        notes: notes.iter().map(ToString::to_string).collect(),
        whole: recovered.is_whole,
        kept: recovered.journal.display().to_string(),
    }
}
