//! Recovers journals that a crash left.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::working::Working;
use crate::write::{Recovered, abandoned, recover};

/// The result for one journal.
#[derive(Clone, Debug, Serialize)]
pub struct RecoveredLine {
    /// The journal.
    pub journal: String,
    /// The recording that was made from it.
    pub recording: String,
    /// Messages in it.
    pub messages: u64,
    /// Messages by topic.
    pub topics: Vec<(String, u64)>,
    /// From the first log time to the last.
    pub duration_s: f64,
    /// Bytes of the journal.
    pub bytes: u64,
    /// Number of bytes that were not read into the recording.
    pub unread_bytes: u64,
    /// Ranges of those bytes: offsets of the first, and of the one after the last.
    pub unread: Vec<(u64, u64)>,
    /// Damage of the journal by which data were lost.
    pub lost: Vec<String>,
    /// Damage without loss of data.
    pub notes: Vec<String>,
    /// Whether all data of the journal are in the recording.
    pub whole: bool,
    /// New name of the journal.
    pub kept: String,
}

/// Recovers journals, or all abandoned ones in a folder, and passes each result to `each`.
/// One that fails does not stop the others; fails where `each` does or a folder cannot be read.
pub fn recover_all(
    paths: &[PathBuf],
    mut each: impl FnMut(&Path, anyhow::Result<RecoveredLine>) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let working = Working::begin("recovering");
    for path in paths {
        let journals = if path.is_dir() {
            abandoned(path)?
        } else {
            vec![path.clone()]
        };
        for journal in journals {
            let result = recover(&journal);
            let line = result.map(|recovered| line(&journal, &recovered));
            working.around(|| each(&journal, line.map_err(Into::into)))?;
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
