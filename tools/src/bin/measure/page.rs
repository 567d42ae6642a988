//! The page: a text written by hand, with figures and tables put in where it says so.

use anyhow::Result;

use crate::book::Book;
use crate::figure::Sheet;

/// The text. `{{figure NAME}}`, `{{table NAME}}` and `{{runs}}` stand on lines of their own.
const TEXT: &str = include_str!("page.md");

/// Writes it as the folder's README.
pub fn write(book: &Book) -> Result<()> {
    let mut page = String::new();
    for line in TEXT.lines() {
        let inside = line
            .strip_prefix("{{")
            .and_then(|line| line.strip_suffix("}}"));
        match inside.map(|inside| inside.split_once(' ').unwrap_or((inside, ""))) {
            None => page += line,
            Some(("figure", name)) => page += &figure(book, name),
            Some(("table", name)) => page += &book.sheet(name).map_or_else(|| absent(name), table),
            Some(("runs", _)) => page += &table(runs(book)),
            Some((what, _)) => anyhow::bail!("page.md asks for {what:?}"),
        }
        page += "\n";
    }
    book.write("README.md", &page)
}

fn figure(book: &Book, name: &str) -> String {
    match book.figure(name) {
        Some(figure) => format!("![{}]({name}.svg)", figure.title),
        None => absent(name),
    }
}

fn absent(name: &str) -> String {
    format!("*(`{name}` was not measured in this run.)*")
}

fn table(sheet: Sheet) -> String {
    let mut text = String::new();
    if !sheet.title.is_empty() {
        text += &format!("{}\n\n", sheet.title);
    }
    let row = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    text += &row(&sheet.header);
    text += &format!("|{}\n", "---|".repeat(sheet.header.len()));
    for cells in &sheet.rows {
        text += &row(cells);
    }
    text.trim_end().to_owned()
}

fn runs(book: &Book) -> Sheet {
    let header = [
        "part",
        "processor",
        "cores",
        "compiler",
        "revision",
        "date",
        "took",
    ];
    let rows = book.runs().into_iter().map(|(part, run)| {
        let took = format!("{:.0} s", run.seconds);
        vec![
            part,
            run.processor,
            run.cores.to_string(),
            run.rustc,
            run.revision,
            run.date,
            if run.quick {
                format!("{took}, a quick check and no measurement")
            } else {
                took
            },
        ]
    });
    Sheet {
        header: header.map(str::to_owned).to_vec(),
        rows: rows.collect(),
        ..Sheet::default()
    }
}
