//! Where the raw numbers go.

use std::cell::RefCell;
use std::fmt::Display;
use std::fs;
use std::ops::Range;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use serde::Serialize;
use serde_json::Value;

use crate::run::Run;

/// What every study is told, and what it has shown.
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// Performances per row of a table.
    #[arg(long, global = true, default_value_t = 200)]
    pub seeds: u64,
    /// Seed of the first of them. Constants were chosen on seeds below 5000.
    #[arg(long, global = true, default_value_t = 5000)]
    pub first_seed: u64,
    /// Only the rows of `stress` whose description (`theme: name, timing`) holds this, while the
    /// others stay as they were measured; only those of `scenes` (`hat and box`), and of `sequences` and
    /// `proposals` (`6 bounces, known, 1`), and then no raw numbers. No page.
    #[arg(long, global = true)]
    pub only: Option<String>,
    /// Folder for the raw numbers.
    #[arg(long, global = true, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/study/results"))]
    pub results: PathBuf,
    /// Tables that were shown since the last page.
    #[arg(skip)]
    shown: RefCell<String>,
}

impl Options {
    /// Seeds of the performances of a row.
    pub fn range(&self) -> Range<u64> {
        self.first_seed..self.first_seed + self.seeds
    }

    /// Whether a row of that description is to be made.
    pub fn wants(&self, row: &str) -> bool {
        self.only
            .as_ref()
            .is_none_or(|only| row.contains(only.as_str()))
    }

    /// Prints a table and keeps it for the page.
    pub fn show(&self, table: impl Display) {
        println!("{table}");
        *self.shown.borrow_mut() += &format!("\n{table}");
    }

    /// Writes `<name>.md`: what was studied, who measured it when, and the tables that were shown. Not
    /// with `only`, which leaves rows out.
    pub fn write_page(&self, name: &str, about: &str, run: &Run) -> Result<()> {
        let tables = self.shown.take();
        if self.only.is_some() || tables.is_empty() {
            return Ok(());
        }
        let Run {
            processor,
            cores,
            rustc,
            revision,
            date,
            seconds,
            ..
        } = run;
        let (seeds, first) = (self.seeds, self.first_seed);
        let text = format!(
            "{about}\n\nMade by `cargo run --release -p enact-tools --bin measure -- study {name} --seeds {seeds} --first-seed \
             {first}` at revision {revision}, {date}, in {seconds:.0} s on one of {cores} cores of \
             {processor}; {rustc}.\n{tables}",
        );
        self.write(&format!("{name}.md"), &text)
    }

    /// Writes `<name>.json`, numbers to six digits.
    pub fn write_json(&self, name: &str, value: &impl Serialize) -> Result<()> {
        let mut value = serde_json::to_value(value)?;
        round(&mut value);
        self.write(&format!("{name}.json"), &format!("{value}\n"))
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

/// Leaves six digits of every number that is no integer.
pub fn round(value: &mut Value) {
    match value {
        Value::Array(values) => values.iter_mut().for_each(round),
        Value::Object(fields) => fields.iter_mut().for_each(|(_, value)| round(value)),
        Value::Number(number) if number.is_f64() => {
            let digits = number.as_f64().map(|number| format!("{number:.5e}"));
            let rounded = digits.and_then(|digits| digits.parse::<f64>().ok());
            *value = rounded.map_or(Value::Null, Value::from);
        }
        _ => {}
    }
}
