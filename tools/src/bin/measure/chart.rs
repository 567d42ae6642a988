//! Speed against accuracy, charted, beside what a user would pick instead.
//!
//! ```text
//! cargo run --release -p enact-tools --bin measure -- chart             # everything, in minutes
//! cargo run --release -p enact-tools --bin measure -- chart --quick  # the same with few repeats
//! cargo run --release -p enact-tools --bin measure -- chart --only flow
//! cargo run --release -p enact-tools --bin measure -- chart --draw   # page and drawings from the numbers there are
//! ```
//!
//! Leaves raw numbers (JSON), drawings (SVG) and a page in `tools/charts`. Run it on a machine
//! that does nothing else: times are measured.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use clap::Args;

use crate::book::Book;
use crate::run::Run;
use crate::*;

/// What every part is told.
#[derive(Args)]
pub struct Options {
    /// Few repeats and seeds: a check that everything runs, not a measurement.
    #[arg(long)]
    pub quick: bool,
    /// Only the parts whose name holds this.
    #[arg(long)]
    pub only: Option<String>,
    /// Measures nothing: draws the figures and makes the page from the numbers that are there.
    #[arg(long)]
    pub draw: bool,
    /// Says how much memory one estimate takes, for the part that asks it of another process.
    #[arg(long, hide = true)]
    pub memory: Option<String>,
    /// Where the charts go.
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/charts"))]
    pub folder: PathBuf,
}

/// A part: its name, and what makes it.
type Part = (&'static str, fn(&Options, &mut Book) -> Result<()>);

/// In the order of the page.
const PARTS: &[Part] = &[
    ("flow", flow::run),
    ("estimation", estimation::run),
    ("peers", peers::run),
    ("failure", failure::run),
    ("data", data::run),
    ("growth", growth::run),
    ("real", real::run),
];

pub fn run(options: Options) -> Result<()> {
    if let Some(size) = &options.memory {
        let bytes = growth::peak_bytes(size);
        println!("{}", bytes.map_or(String::new(), |bytes| bytes.to_string()));
        return Ok(());
    }
    let mut book = Book::open(&options.folder)?;
    for (name, run) in PARTS {
        let is_wanted = options.only.as_ref().is_none_or(|only| name.contains(only));
        if options.draw || !is_wanted {
            continue;
        }
        eprintln!("{name}");
        let begin = Instant::now();
        run(&options, &mut book)?;
        let seconds = begin.elapsed().as_secs_f64();
        eprintln!("{name}: {seconds:.1} s");
        let here = Run::here(options.quick);
        book.ran(name, Run { seconds, ..here })?;
    }
    if options.draw {
        peers::redraw(&mut book)?;
    }
    for name in book.figures()? {
        book.draw(&name)?;
    }
    page::write(&book)
}
