//! Tables in markdown.

use std::fmt;

use serde::{Deserialize, Serialize};

/// A table under a heading.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct Table {
    /// By which a page names it.
    pub name: String,
    title: String,
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty one.
    pub fn new(name: &str, title: &str, header: &[&str]) -> Self {
        Self {
            name: name.to_owned(),
            title: title.to_owned(),
            header: header.iter().map(|cell| (*cell).to_owned()).collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row; it has as many cells as the header.
    pub fn row<T: Into<String>>(&mut self, cells: impl IntoIterator<Item = T>) {
        let cells: Vec<String> = cells.into_iter().map(Into::into).collect();
        assert_eq!(cells.len(), self.header.len(), "{cells:?}");
        self.rows.push(cells);
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if !self.title.is_empty() {
            writeln!(f, "### {}\n", self.title)?;
        }
        writeln!(f, "| {} |", self.header.join(" | "))?;
        writeln!(f, "|{}", "---|".repeat(self.header.len()))?;
        for row in &self.rows {
            writeln!(f, "| {} |", row.join(" | "))?;
        }
        Ok(())
    }
}

/// `98.5 %`, or a dash for a share of nothing.
pub fn percent(part: usize, whole: usize) -> String {
    if whole == 0 {
        return "–".to_owned();
    }
    format!("{:.1} %", 100.0 * part as f64 / whole as f64)
}

/// The share of those for which something holds, as [`percent`].
pub fn share<T>(all: &[T], holds: impl Fn(&T) -> bool) -> String {
    percent(all.iter().filter(|one| holds(one)).count(), all.len())
}

/// Three digits, by powers of ten where the number is far from one; a dash for what is none.
pub fn number(value: f64) -> String {
    if value.is_nan() {
        "–".to_owned()
    } else if value == 0.0 || (1e-2..1e4).contains(&value.abs()) {
        let decimals = (2 - value.abs().max(1e-2).log10().floor() as i32).clamp(0, 4) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.1e}")
    }
}
