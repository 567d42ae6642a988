//! A table's text becomes the samples of its bodies.

use std::path::Path;

use super::axes::{PRESETS, Preset};
use super::buttons::presses;
use super::columns::looks_turned;
use super::formats;
use super::head;
use super::layout::{TableFault, TableLayout, TimeColumns, fault, shown};
use super::missing::is_absent;
use super::poses::{PoseTable, TableOptions};
use super::said::Said;
use super::sample::{Reader, angle_unit, bodies};
use super::stamp::is_text_time;
use super::text::{Line, Lines, lines, number};
use super::time::clock;
use crate::ingest::error::IngestError;
use crate::motion::Stamp;

/// Most lines at the end of a table that are no rows of it.
const FOOTER_LINES: usize = 50;

/// Reads the text of a table; `path` is its name in errors. Fails, with the line and what is wrong there,
/// where cells are no numbers or the columns of a pose are not found.
pub fn read_table(
    path: &Path,
    text: &str,
    options: &TableOptions,
) -> Result<PoseTable, IngestError> {
    read(text, options).map_err(|fault| IngestError::Table {
        path: path.to_owned(),
        line: fault.line,
        message: fault.message,
    })
}

fn read(text: &str, options: &TableOptions) -> Result<PoseTable, TableFault> {
    let lines = lines(text)?;
    let (layout, begin) = layout(&lines, options)?;
    let mut said = Said {
        notes: [lines.notes.clone(), layout.notes.clone()].concat(),
        against: layout.against.clone(),
    };
    said.order(&layout);
    said.bodies(&layout.bodies);
    said.unread(&layout, options, looks_turned);
    let preset = options
        .preset
        .or(layout.preset.and_then(Preset::named))
        .unwrap_or(&PRESETS[0]);
    said.axes(&layout, options, preset);
    let length = options
        .length_unit
        .or(layout.length)
        .unwrap_or(preset.length);
    said.length(length, &layout, options, preset);
    let rows = &lines.rows[begin.min(lines.rows.len())..];
    let rows = without_footer(&layout, section(&layout, rows, &mut said), &mut said)?;
    decimal_commas(&layout, rows, &lines, &mut said);
    let unit = options.time_unit;
    let unit = unit.or(match layout.time {
        TimeColumns::One(_, None) => preset.time,
        _ => None,
    });
    let clock = clock(&layout, rows, unit, options.rate_hz, &mut said)?;
    let reader = Reader {
        preset,
        per_metre: 1.0 / length.length_m(),
        turn: options.turn,
        angle_unit: angle_unit(&layout, rows, options, preset, &mut said),
        clock,
        is_ragged: layout.is_ragged,
        is_zero_unseen: layout.is_zero_unseen,
    };
    let mut lost = Vec::new();
    let bodies = bodies(&layout, rows, &reader, lines.is_open, &mut lost)?;
    let presses = presses(&layout, &lines.head, rows, options, clock, &mut said)?;
    let marks = layout.marks.iter().filter_map(|mark| {
        let ns = clock.of_mark(mark)?;
        Some((mark.name.clone(), Stamp(ns)))
    });
    let zero = rows.first().filter(|_| clock.counts());
    let zero = zero.and_then(|row| clock.of(row, 0).ok());
    Ok(PoseTable {
        kind: format!("{}, {}", layout.kind, lines.separator.name()),
        preset,
        length,
        bodies,
        marks: marks.collect(),
        presses,
        zero: zero.map(Stamp),
        notes: said.notes,
        against: said.against,
        lost,
    })
}

fn layout(lines: &Lines, options: &TableOptions) -> Result<(TableLayout, usize), TableFault> {
    let of_preset = options.preset.and_then(|preset| preset.columns);
    let has_names = || lines.head.iter().any(|line| line.cells.len() >= 4);
    let given = options
        .columns
        .as_deref()
        .or(of_preset.filter(|_| !has_names()));
    let Some(given) = given else {
        return formats::layout(lines, options.quaternion);
    };
    let mut names: Vec<String> = given
        .split(',')
        .map(|name| name.trim().to_owned())
        .collect();
    let count = lines.rows[0].cells.len();
    if names.len() > count {
        return fault(
            lines.rows[0].number,
            format!(
                "{count} columns, and {} names are given for them, expected at most as many in --columns",
                names.len()
            ),
        );
    }
    names.resize(count, "-".to_owned());
    let layout = head::layout(0, &names, options.quaternion)?;
    let kind = "a table with columns as given".to_owned();
    Ok((TableLayout { kind, ..layout }, 0))
}

/// The rows up to one that is of another section.
fn section<'l>(layout: &TableLayout, rows: &'l [Line], said: &mut Said) -> &'l [Line] {
    let ends = |row: &Line| layout.is_section && number(&row.cells[0]).is_none();
    let Some(end) = rows.iter().position(ends) else {
        return rows;
    };
    said.note(format!(
        "not read from line {} on: section {}",
        rows[end].number, rows[end].cells[0]
    ));
    &rows[..end]
}

/// The rows without lines at the end that begin with a word where all others begin with a number or a time; such a
/// line among the rows is refused.
fn without_footer<'l>(
    layout: &TableLayout,
    rows: &'l [Line],
    said: &mut Said,
) -> Result<&'l [Line], TableFault> {
    let is_first = layout.time.first() == Some(0);
    let is_word = |row: &Line| {
        let cell = row.cells[0].as_str();
        number(cell).is_none() && !is_absent(cell) && !is_text_time(cell)
    };
    let Some(first) = rows
        .iter()
        .position(is_word)
        .filter(|first| is_first && *first > 0)
    else {
        return Ok(rows);
    };
    let rest = &rows[first..];
    if rest.len() <= FOOTER_LINES && rest.iter().all(is_word) {
        said.note(format!(
            "not read: {} lines at the end that begin with no number, the first is line {}",
            rest.len(),
            rest[0].number
        ));
        return Ok(&rows[..first]);
    }
    fault(
        rest[0].number,
        format!(
            "{} begins a line among the rows, where a number was expected: two tables in one file? Part the file there",
            shown(&rest[0].cells[0])
        ),
    )
}

/// Says where numbers have decimal commas.
fn decimal_commas(layout: &TableLayout, rows: &[Line], lines: &Lines, said: &mut Said) {
    let Some(body) = layout.bodies.first() else {
        return;
    };
    let has_comma = |row: &Line| {
        let mut cells = body
            .position
            .iter()
            .filter_map(|column| row.cells.get(*column));
        cells.any(|cell| cell.contains(',') && number(cell).is_some())
    };
    if rows.iter().take(20).any(has_comma) {
        said.note(format!(
            "numbers have decimal commas, parted by {}",
            lines.separator.name()
        ));
    }
}
