//! What a subject leaves: tables, figures and raw numbers, and on what they were measured.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::figure::Figure;
use crate::run::Run;
use crate::table::Table;

/// The record of one subject: `<subject>.json`.
#[derive(Default, Deserialize, Serialize)]
pub struct Record {
    /// On what it was measured.
    pub run: Run,
    /// What matters most of it, in sentences made from its numbers.
    pub summary: Vec<String>,
    /// In the order in which they were made.
    pub tables: Vec<Table>,
    /// In the order in which they were made.
    pub figures: Vec<Figure>,
    /// What no table and no figure holds, by name.
    pub numbers: BTreeMap<String, Value>,
    /// Whether it is kept without being printed.
    #[serde(skip)]
    is_quiet: bool,
}

impl Record {
    /// What is not printed: of a run that goes on.
    pub fn quiet(run: Run) -> Self {
        Self {
            run,
            is_quiet: true,
            ..Self::default()
        }
    }

    /// Prints a table and keeps it.
    pub fn table(&mut self, table: Table) {
        if !self.is_quiet {
            println!("{table}");
        }
        self.tables.push(table);
    }

    /// Keeps a figure.
    pub fn figure(&mut self, figure: Figure) {
        self.figures.push(figure);
    }

    /// Keeps raw numbers.
    pub fn numbers(&mut self, name: &str, value: &impl Serialize) -> Result<()> {
        self.numbers
            .insert(name.to_owned(), serde_json::to_value(value)?);
        Ok(())
    }

    /// Prints a sentence of the summary and keeps it.
    pub fn say(&mut self, sentence: String) {
        if !self.is_quiet {
            println!("{sentence}\n");
        }
        self.summary.push(sentence);
    }

    /// The record of a subject, if there is one.
    pub fn load(folder: &Path, subject: &str) -> Result<Option<Self>> {
        let path = folder.join(format!("{subject}.json"));
        if !path.exists() {
            return Ok(None);
        }
        let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        let record = serde_json::from_str(&text).with_context(|| path.display().to_string())?;
        Ok(Some(record))
    }

    /// Writes it.
    pub fn save(&self, folder: &Path, subject: &str) -> Result<()> {
        let mut value = serde_json::to_value(self)?;
        round(&mut value);
        write(folder, &format!("{subject}.json"), &format!("{value}\n"))
    }
}

/// Writes a file of the folder, which is made if need be.
pub fn write(folder: &Path, file: &str, text: &str) -> Result<()> {
    let path = folder.join(file);
    fs::create_dir_all(folder)
        .and_then(|()| fs::write(&path, text))
        .with_context(|| format!("cannot write {}", path.display()))
}

/// Leaves eight digits of every number that is no integer.
fn round(value: &mut Value) {
    match value {
        Value::Array(values) => values.iter_mut().for_each(round),
        Value::Object(fields) => fields.iter_mut().for_each(|(_, value)| round(value)),
        Value::Number(number) if number.is_f64() => {
            let digits = number.as_f64().map(|number| format!("{number:.7e}"));
            let rounded = digits.and_then(|digits| digits.parse::<f64>().ok());
            *value = rounded.map_or(Value::Null, Value::from);
        }
        _ => {}
    }
}
