//! Speed against accuracy, charted, beside what a user would pick instead.
//!
//! ```text
//! cargo run --release --example chart             # everything, in minutes
//! cargo run --release --example chart -- --quick  # the same with few repeats
//! cargo run --release --example chart -- --only flow
//! ```
//!
//! Leaves raw numbers (JSON), drawings (SVG) and a page in `tools/charts`.

mod figure;
mod methods;

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

fn main() -> anyhow::Result<()> {
    let _options = Options::parse();
    Ok(())
}
