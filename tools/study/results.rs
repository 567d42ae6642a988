//! Where the raw numbers go.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use serde::Serialize;

/// What every study is told.
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// Performances per row of a table.
    #[arg(long, global = true, default_value_t = 200)]
    pub seeds: u64,
    /// Folder for the raw numbers.
    #[arg(long, global = true, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/tools/study/results"))]
    pub results: PathBuf,
}

impl Options {
    /// Writes `<name>.json`.
    pub fn write_json(&self, name: &str, value: &impl Serialize) -> Result<()> {
        let mut text = serde_json::to_string_pretty(value)?;
        text.push('\n');
        self.write(&format!("{name}.json"), &text)
    }

    /// Writes `<name>.csv`.
    pub fn write_csv(&self, name: &str, header: &str, lines: &[String]) -> Result<()> {
        self.write(
            &format!("{name}.csv"),
            &format!("{header}\n{}\n", lines.join("\n")),
        )
    }

    fn write(&self, file: &str, text: &str) -> Result<()> {
        let path = self.results.join(file);
        fs::create_dir_all(&self.results)
            .and_then(|()| fs::write(&path, text))
            .with_context(|| format!("cannot write {}", path.display()))
    }
}
