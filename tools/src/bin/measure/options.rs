//! What every subject is told.

use std::ops::Range;
use std::path::PathBuf;

use clap::Parser;

/// Measurements of the program.
#[derive(Parser)]
pub struct Options {
    /// Few seeds and repeats: a check that everything runs, and no measurement
    #[arg(long)]
    pub quick: bool,
    /// Only these subjects
    #[arg(long, num_args = 1..)]
    pub only: Vec<String>,
    /// Measure nothing: make pages and drawings from the numbers that are there
    #[arg(long)]
    pub draw: bool,
    /// Performances of each row [default: as many as the subject says]
    #[arg(long)]
    seeds: Option<u64>,
    /// Seed of the first of them; constants of the program were chosen on seeds below 8000
    #[arg(long, default_value_t = 8000)]
    first_seed: u64,
    /// Only rows whose description holds this, where a subject has such; nothing is kept
    #[arg(long)]
    pub rows: Option<String>,
    /// Where results go
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/results"))]
    pub folder: PathBuf,
    /// Says how much memory one estimate takes, for the subject that asks it of another process
    #[arg(long, hide = true)]
    pub memory: Option<String>,
}

/// Seeds of a quick run.
const QUICK: u64 = 1;

impl Options {
    /// Seeds of the performances of a row, of which a measurement has `most`.
    pub fn seeds(&self, most: u64) -> Range<u64> {
        let quick = if self.quick { QUICK } else { most };
        self.first_seed..self.first_seed + self.seeds.unwrap_or(quick)
    }

    /// One of two numbers: of a quick run, or of a measurement.
    pub fn either<T>(&self, quick: T, full: T) -> T {
        if self.quick { quick } else { full }
    }

    /// Whether a row of that description is to be made.
    pub fn wants(&self, row: &str) -> bool {
        self.rows
            .as_ref()
            .is_none_or(|rows| row.contains(rows.as_str()))
    }
}
