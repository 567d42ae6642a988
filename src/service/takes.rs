//! Lists the takes in a folder, with what was said of them.

use std::path::Path;

use anyhow::Context;
use serde::Serialize;

use super::capture::METADATA;
use super::finish::output_path;
use super::words;
use crate::ingest::Recording;

/// A take in a folder.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct TakeEntry {
    /// Its file.
    pub recording: String,
    /// Its number, if it is noted.
    pub number: Option<u64>,
    /// Its name.
    pub name: Option<String>,
    /// A note.
    pub note: Option<String>,
    /// Its rating, 1 (bad) to 5 (good).
    pub rating: Option<u32>,
    /// Samples and marks in it, raw and used, and counts.
    pub messages: u64,
    /// The file with its estimate, if it is there.
    pub estimate: Option<String>,
    /// Why it cannot be read.
    pub error: Option<String>,
}

/// The takes in a folder, in order of their files' names; one at a time is read. Fails where the
/// folder cannot be listed.
pub fn takes(folder: &Path) -> anyhow::Result<Vec<TakeEntry>> {
    let cannot = || format!("{}: cannot list takes", folder.display());
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(cannot)? {
        let entry = entry.with_context(cannot)?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_take = name.starts_with("take-") && name.ends_with(".mcap");
        if is_take && !name.ends_with(".estimate.mcap") {
            paths.push(entry.path());
        }
    }
    paths.sort();
    Ok(paths.iter().map(|path| entry(path)).collect())
}

fn entry(path: &Path) -> TakeEntry {
    let recording = path.display().to_string();
    let estimate = output_path(path, None).ok();
    let estimate = estimate.filter(|estimate| estimate.exists());
    let found = TakeEntry {
        recording,
        estimate: estimate.map(|estimate| estimate.display().to_string()),
        ..TakeEntry::default()
    };
    let read = match Recording::open(path) {
        Ok(read) => read,
        Err(error) => {
            return TakeEntry {
                error: Some(words(&error.into())),
                ..found
            };
        }
    };
    let container = read.container();
    let metadata = container.metadata().iter().rfind(|of| of.name == METADATA);
    let text = |key: &str| metadata.and_then(|of| of.pairs.get(key)).cloned();
    TakeEntry {
        number: text("number").and_then(|number| number.parse().ok()),
        name: text("name"),
        note: text("note"),
        rating: text("rating").and_then(|rating| rating.parse().ok()),
        messages: container.channels().values().map(|of| of.messages).sum(),
        ..found
    }
}
