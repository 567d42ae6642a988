//! Pages: texts written by hand, with figures and tables put in where they say so.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use anyhow::Result;

use crate::Subject;
use crate::draw;
use crate::record::{Record, write};
use crate::run::Run;

/// The list of pages, with places for `{{summary}}`, `{{pages}}` and `{{runs}}`.
const LIST: &str = include_str!("pages/README.md");

/// Makes every page and drawing of which there are numbers, and the list of them.
pub fn write_all(folder: &Path, subjects: &[Subject]) -> Result<()> {
    let (mut summary, mut pages) = (
        String::new(),
        "| page | what it says |\n|---|---|\n".to_owned(),
    );
    let mut runs = Vec::new();
    for subject in subjects {
        let Some(record) = Record::load(folder, subject.name)? else {
            continue;
        };
        draw(folder, subject.name, &record)?;
        write(
            folder,
            &format!("{}.md", subject.name),
            &page(subject, &record),
        )?;
        for sentence in &record.summary {
            summary += &format!("- {sentence} ([{0}]({0}.md))\n", subject.name);
        }
        pages += &format!("| [{0}]({0}.md) | {1} |\n", subject.name, subject.title);
        runs.push(record.run);
    }
    let list = LIST
        .replace("{{summary}}\n", &summary)
        .replace("{{pages}}\n", &pages)
        .replace("{{runs}}", &measured_on(&runs));
    write(folder, "README.md", &list)
}

/// Draws all figures of a subject; drawings of figures that are no more go.
fn draw(folder: &Path, subject: &str, record: &Record) -> Result<()> {
    let mut drawn = BTreeSet::new();
    for figure in &record.figures {
        let file = format!("{}.svg", figure.name);
        write(folder, &file, &draw::svg(figure)?)?;
        drawn.insert(file);
    }
    for entry in fs::read_dir(folder)? {
        let file = entry?.file_name().to_string_lossy().into_owned();
        let is_own = file.starts_with(&format!("{subject}_")) && file.ends_with(".svg");
        if is_own && !drawn.contains(&file) {
            fs::remove_file(folder.join(file))?;
        }
    }
    Ok(())
}

/// A subject's page. Tables and figures for which the text has no place stand at its end.
fn page(subject: &Subject, record: &Record) -> String {
    let mut page = String::new();
    let mut placed = BTreeSet::new();
    for line in subject.text.lines() {
        let place = line
            .strip_prefix("{{")
            .and_then(|line| line.strip_suffix("}}"));
        match place.and_then(|place| place.split_once(' ')) {
            None if place == Some("run") => page += &made_by(subject, &record.run),
            None => page += line,
            Some((kind, name)) => {
                let absent = || format!("*(`{name}` was not measured in this run.)*");
                page += &shown(record, kind, name).unwrap_or_else(absent);
                placed.insert((kind.to_owned(), name.to_owned()));
            }
        }
        page += "\n";
    }
    let tables = record.tables.iter().map(|table| ("table", &table.name));
    let figures = record.figures.iter().map(|figure| ("figure", &figure.name));
    for (kind, name) in tables.chain(figures) {
        if !placed.contains(&(kind.to_owned(), name.clone())) {
            page += &format!("\n{}\n", shown(record, kind, name).unwrap_or_default());
        }
    }
    page
}

fn shown(record: &Record, kind: &str, name: &str) -> Option<String> {
    match kind {
        "table" => {
            let table = record.tables.iter().find(|table| table.name == name)?;
            Some(table.to_string().trim_end().to_owned())
        }
        "figure" => {
            let figure = record.figures.iter().find(|figure| figure.name == name)?;
            Some(format!("![{}]({name}.svg)", figure.title))
        }
        _ => None,
    }
}

fn made_by(subject: &Subject, run: &Run) -> String {
    let check = if run.quick {
        " A quick check, and no measurement."
    } else {
        ""
    };
    format!(
        "Made by `cargo run --release -p enact-tools --bin measure -- --only {}` at revision {}, {}, in {:.0} s on {} cores of \
         {}; {}.{check}",
        subject.name, run.revision, run.date, run.seconds, run.cores, run.processor, run.rustc
    )
}

/// One line where all subjects have one revision and one machine.
fn measured_on(runs: &[Run]) -> String {
    let distinct = |of: fn(&Run) -> String| {
        let all: BTreeSet<String> = runs.iter().map(of).collect();
        all.into_iter().collect::<Vec<_>>().join(", ")
    };
    format!(
        "Measured at revision {} ({}), on {} cores of {}, with {}.",
        distinct(|run| run.revision.clone()),
        distinct(|run| run.date.clone()),
        distinct(|run| run.cores.to_string()),
        distinct(|run| run.processor.clone()),
        distinct(|run| run.rustc.clone()),
    )
}
