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
mod estimation;
mod failure;
mod figure;
mod methods;
#[path = "../perform/mod.rs"]
mod perform;
mod scenes;
#[path = "../study/starts.rs"]
mod starts;
#[path = "../study/statistics.rs"]
#[allow(dead_code, reason = "studies use the rest of it")]
mod statistics;
#[path = "../study/stress/mod.rs"]
mod stress;
mod tasks;
mod troubles;

use std::path::PathBuf;

use clap::Parser;

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

/// Where figures go.
pub struct Book {
    folder: PathBuf,
}

impl Book {
    /// Keeps a figure as JSON.
    fn keep(&mut self, figure: figure::Figure) -> anyhow::Result<()> {
        std::fs::create_dir_all(&self.folder)?;
        let path = self.folder.join(format!("{}.json", figure.name));
        std::fs::write(path, serde_json::to_string_pretty(&figure)?)?;
        Ok(())
    }
}

fn main() -> anyhow::Result<()> {
    let options = Options::parse();
    let mut book = Book {
        folder: options.folder.clone(),
    };
    let wants = |part: &str| options.only.as_ref().is_none_or(|only| part.contains(only));
    if wants("estimation") {
        estimation::run(&options, &mut book)?;
    }
    if wants("failure") {
        failure::run(&options, &mut book)?;
    }
    Ok(())
}
