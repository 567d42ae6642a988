//! Speed against accuracy, charted, beside what a user would pick instead.
//!
//! ```text
//! cargo run --release --example chart             # everything, in minutes
//! cargo run --release --example chart -- --quick  # the same with few repeats
//! cargo run --release --example chart -- --only flow
//! ```
//!
//! Leaves raw numbers (JSON), drawings (SVG) and a page in `tools/charts`.

#[path = "../study/case.rs"]
mod case;
mod export;
mod figure;
mod peers;
#[path = "../perform/mod.rs"]
mod perform;
#[path = "../study/starts.rs"]
mod starts;
#[allow(dead_code)]
#[path = "../study/statistics.rs"]
mod statistics;
#[path = "../study/table.rs"]
mod table;

use std::fs;
use std::path::PathBuf;

use clap::Parser;
use figure::Figure;

/// What every part is told.
#[derive(Parser)]
pub struct Options {
    /// Few repeats and seeds: a check that everything runs, not a measurement.
    #[arg(long)]
    pub quick: bool,
    /// Only the parts whose name holds this.
    #[arg(long)]
    pub only: Option<String>,
    /// Where the charts go.
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/tools/charts"))]
    pub folder: PathBuf,
}

/// Where figures are kept.
pub struct Book {
    folder: PathBuf,
}

impl Book {
    /// Writes a figure as JSON.
    pub fn keep(&mut self, figure: Figure) -> anyhow::Result<()> {
        fs::create_dir_all(&self.folder)?;
        let path = self.folder.join(format!("{}.json", figure.name));
        fs::write(path, serde_json::to_string(&figure)?)?;
        Ok(())
    }
}

fn main() -> anyhow::Result<()> {
    let options = Options::parse();
    let mut book = Book {
        folder: options.folder.clone(),
    };
    let is_wanted = |part: &str| {
        options
            .only
            .as_deref()
            .is_none_or(|only| part.contains(only))
    };
    if is_wanted("peers") {
        peers::run(&options, &mut book)?;
    }
    Ok(())
}
