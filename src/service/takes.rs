//! Lists the takes in a folder, with what was said of them and what was found.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use serde::Serialize;

use super::finish::output_path;
use super::inspect::CUT_SHORT;
use super::words;
use crate::ingest::{Digest, Recording, digest, regular};
use crate::write::export::WrittenVerdict;
use crate::write::is_cut_short;
use crate::write::topics::{REPORT, TAKE_METADATA};

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
    /// The estimate's verdict: `physical`, `plausible` or `failed`.
    pub verdict: Option<String>,
    /// Whether nothing speaks against the motion.
    pub is_good: Option<bool>,
    /// What speaks against it most, else why its estimation ended.
    pub why: Option<String>,
    /// Why the take, or its estimate, cannot be read.
    pub error: Option<String>,
}

/// The takes in a folder, in order of their files' names. Of files that were written to their ends only these are
/// read, of others all. Fails where the folder cannot be listed.
pub fn takes(folder: &Path) -> anyhow::Result<Vec<TakeEntry>> {
    let paths = take_files(folder)?;
    Ok(paths.iter().map(|path| entry(path)).collect())
}

/// The files of the takes in a folder, in order of their names.
pub(super) fn take_files(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
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
    Ok(paths)
}

/// What is known of a take.
pub(super) fn entry(path: &Path) -> TakeEntry {
    let estimate = output_path(path, None).ok();
    let estimate = estimate.filter(|estimate| estimate.exists());
    let mut found = TakeEntry {
        recording: path.display().to_string(),
        estimate: estimate.as_ref().map(|of| of.display().to_string()),
        ..TakeEntry::default()
    };
    let take = read_take(path, &mut found);
    let verdict = match &estimate {
        Some(estimate) => read_verdict(estimate, &mut found),
        None => Ok(()),
    };
    found.error = take.and(verdict).err().map(|error| words(&error));
    found
}

fn read_take(path: &Path, found: &mut TakeEntry) -> anyhow::Result<()> {
    let Digest {
        messages,
        container,
    } = read(path)?;
    let metadata = container
        .metadata()
        .iter()
        .rfind(|of| of.name == TAKE_METADATA);
    let text = |key: &str| metadata.and_then(|of| of.pairs.get(key)).cloned();
    found.number = text("number").and_then(|number| number.parse().ok());
    found.name = text("name");
    found.note = text("note");
    found.rating = text("rating").and_then(|rating| rating.parse().ok());
    found.messages = messages;
    if is_cut_short(&container) {
        bail!("{}: {CUT_SHORT}", path.display());
    }
    Ok(())
}

fn read_verdict(estimate: &Path, found: &mut TakeEntry) -> anyhow::Result<()> {
    let read = read(estimate)?;
    let verdict = WrittenVerdict::read(&read.container)
        .with_context(|| format!("{}: has no report that can be read", estimate.display()))?;
    found.verdict = Some(verdict.verdict);
    found.is_good = Some(verdict.is_good);
    found.why = Some(verdict.why);
    Ok(())
}

/// What a file says at its end; of one that does not, what all of it says.
fn read(path: &Path) -> anyhow::Result<Digest> {
    let cannot = || format!("{}: cannot read", path.display());
    let mut file = regular::open(path).with_context(cannot)?;
    if let Some(digest) = digest(&mut file, REPORT).with_context(cannot)? {
        return Ok(digest);
    }
    let container = Recording::open(path)?.container().clone();
    Ok(Digest {
        messages: container.message_count(),
        container,
    })
}
