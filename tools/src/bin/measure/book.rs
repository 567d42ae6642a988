//! Where figures, tables and raw numbers go, and who measured them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::figure::{Figure, Sheet};
use crate::plot;
use crate::run::Run;

/// The folder that a run fills.
pub struct Book {
    folder: PathBuf,
}

/// Ends of the names of files.
const NUMBERS: &str = ".numbers.json";
const TABLE: &str = ".table.json";
const RUNS: &str = "runs.numbers.json";

impl Book {
    /// In that folder, which is made if need be.
    pub fn open(folder: &Path) -> Result<Self> {
        fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        Ok(Self {
            folder: folder.to_owned(),
        })
    }

    /// Keeps a figure: `<name>.json`, and `<name>.svg` drawn from that.
    pub fn keep(&mut self, figure: Figure) -> Result<()> {
        self.write(&format!("{}.json", figure.name), &json(&figure)?)?;
        self.draw(&figure.name)
    }

    /// Keeps a table for the page: `<name>.table.json`.
    pub fn tabulate(&mut self, sheet: Sheet) -> Result<()> {
        for row in &sheet.rows {
            assert_eq!(row.len(), sheet.header.len(), "{}: {row:?}", sheet.name);
        }
        self.write(&format!("{}{TABLE}", sheet.name), &json(&sheet)?)
    }

    /// Keeps raw numbers that are no figure, all digits of them: `<name>.numbers.json`.
    pub fn numbers(&mut self, name: &str, value: &impl Serialize) -> Result<()> {
        let text = serde_json::to_string(value)?;
        self.write(&format!("{name}{NUMBERS}"), &format!("{text}\n"))
    }

    /// Raw numbers that were kept, if they are there.
    pub fn read<T: DeserializeOwned>(&self, name: &str) -> Option<T> {
        let text = fs::read_to_string(self.folder.join(format!("{name}{NUMBERS}"))).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// Remembers on what a part was measured.
    pub fn ran(&mut self, part: &str, run: Run) -> Result<()> {
        let mut runs = self.runs();
        runs.insert(part.to_owned(), run);
        self.write(RUNS, &json(&runs)?)
    }

    /// On what each part was measured.
    pub fn runs(&self) -> BTreeMap<String, Run> {
        let text = fs::read_to_string(self.folder.join(RUNS)).unwrap_or_default();
        serde_json::from_str(&text).unwrap_or_default()
    }

    /// A figure, if it is there.
    pub fn figure(&self, name: &str) -> Option<Figure> {
        let text = fs::read_to_string(self.folder.join(format!("{name}.json"))).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// A table, if it is there.
    pub fn sheet(&self, name: &str) -> Option<Sheet> {
        let text = fs::read_to_string(self.folder.join(format!("{name}{TABLE}"))).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// Names of all figures, in order.
    pub fn figures(&self) -> Result<Vec<String>> {
        let mut names = Vec::new();
        for entry in fs::read_dir(&self.folder)? {
            let file = entry?.file_name().to_string_lossy().into_owned();
            let is_other = file.ends_with(NUMBERS) || file.ends_with(TABLE);
            if let Some(name) = file.strip_suffix(".json").filter(|_| !is_other)
                && self.figure(name).is_some()
            {
                names.push(name.to_owned());
            }
        }
        names.sort();
        Ok(names)
    }

    /// Draws a figure from its JSON alone.
    pub fn draw(&self, name: &str) -> Result<()> {
        let figure = self
            .figure(name)
            .with_context(|| format!("{name}.json is no figure"))?;
        self.write(&format!("{name}.svg"), &plot::svg(&figure)?)
    }

    /// Writes a file of the folder.
    pub fn write(&self, file: &str, text: &str) -> Result<()> {
        let path = self.folder.join(file);
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
    }
}

/// Numbers to six digits.
fn json(value: &impl Serialize) -> Result<String> {
    let mut value = serde_json::to_value(value)?;
    crate::results::round(&mut value);
    Ok(format!("{value}\n"))
}
