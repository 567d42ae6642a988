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
    /// What of it could not be read.
    pub lost: Vec<String>,
    /// Whether the journal is gone.
    pub removed: bool,
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
    RecoveredLine {
        journal: journal.display().to_string(),
        recording: recovered.path.display().to_string(),
        messages: recovered.topics.iter().map(|(_, messages)| messages).sum(),
        topics: recovered.topics.clone(),
        duration_s: span.unwrap_or(0) as f64 * 1e-9,
        bytes: recovered.bytes,
        lost: recovered.damages.iter().map(ToString::to_string).collect(),
        removed: recovered.is_removed,
    }
}
