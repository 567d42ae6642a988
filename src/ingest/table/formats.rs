//! The table of formats: who wrote a table decides what its numbers are.

mod motive;
mod qualisys;
mod trc;
mod unnamed;
mod vicon;

use std::collections::BTreeSet;

use super::columns::{Meaning, meaning};
use super::head;
use super::layout::{QuaternionOrder, TableFault, TableLayout, TimeColumns, fault};
use super::said::listed;
use super::text::{Line, Lines, Separator, number};
use super::units::{AngleUnit, TimeUnit, length_unit};
use crate::motion::LengthUnit;

/// A layout, and how many rows are before its own.
type Found = Result<(TableLayout, usize), TableFault>;

/// Formats with heads of their own; each answers `None` for a table that is another's.
const FORMATS: [fn(&Lines) -> Option<Found>; 4] =
    [motive::layout, vicon::layout, qualisys::layout, trc::layout];

/// Words that stand above the parts of a message, as rosbag_to_csv writes them.
const GROUPS: [&str; 13] = [
    "header",
    "stamp",
    "pose",
    "position",
    "orientation",
    "translation",
    "rotation",
    "transform",
    "twist",
    "linear",
    "angular",
    "covariance",
    "point",
];

/// The layout of a table: that of the program that wrote it, of its line of names, or by the number of its columns
/// where it has none.
pub(super) fn layout(lines: &Lines, order: Option<QuaternionOrder>) -> Found {
    if let Some(found) = FORMATS.iter().find_map(|format| format(lines)) {
        return found;
    }
    let row = &lines.rows[0];
    let lengths = [row.cells.len(), row.filled()];
    let is_as_long = |line: &&Line| {
        let length = line.filled();
        lengths.contains(&length) || lengths.contains(&line.cells.len())
    };
    let named = lines.head.iter().rev().filter(|line| has_names(line));
    let named: Vec<&Line> = named.collect();
    if let Some(line) = named.iter().copied().find(is_as_long) {
        return Ok((of_names(lines, line, order)?, 0));
    }
    let Some(line) = named.first() else {
        let is_text = |cell: &&String| number(cell).is_none() && !cell.is_empty();
        let are_names = |line: &&Line| {
            is_as_long(line) && 2 * line.cells.iter().filter(is_text).count() > line.cells.len()
        };
        if let Some(line) = lines.head.iter().rev().find(are_names) {
            return fault(
                line.number,
                format!(
                    "names of columns that are not known: {}; expected t, x, y, z, qx, qy, qz, qw in their places of --columns, \
                     and - for others",
                    listed(&line.cells)
                ),
            );
        }
        return Ok((unnamed::layout(lines, order)?, 0));
    };
    let (names, numbers) = (line.cells.len(), row.cells.len());
    let commas = match lines.separator == Separator::Byte(b',') && numbers > names {
        true => {
            "; are these decimal commas? Export with points, or with semicolons between numbers"
        }
        false => "",
    };
    fault(
        line.number,
        format!(
            "{names} column names, and {numbers} numbers in line {}; expected as many{commas}",
            row.number
        ),
    )
}

/// Whether a line names the columns that points need.
fn has_names(line: &Line) -> bool {
    let known = line.cells.iter().filter(|name| meaning(name).is_some());
    known.count() >= 3
}

fn of_names(
    lines: &Lines,
    line: &Line,
    order: Option<QuaternionOrder>,
) -> Result<TableLayout, TableFault> {
    let names = without_counts(&line.cells);
    let names = grouped(&with_units(&names, lines, line.number), lines);
    let mut layout = match head::layout(line.number, &names, order) {
        Ok(layout) => layout,
        // Whose columns are may be said in the line above.
        Err(fault) => match under_owners(&names, lines, line.number) {
            Some(names) => head::layout(line.number, &names, order)?,
            None => return Err(fault),
        },
    };
    if names.iter().any(|name| name.contains("p_RS_R")) {
        layout.kind = "EuRoC".to_owned();
    }
    let tum = ["tx", "ty", "tz", "qx", "qy", "qz", "qw"];
    let is_tum = lines.separator == Separator::Blanks
        && names.len() == 1 + tum.len()
        && names[1..]
            .iter()
            .zip(tum)
            .all(|(name, of)| name.eq_ignore_ascii_case(of));
    if let (true, TimeColumns::One(0, unit)) = (is_tum, layout.time) {
        layout.kind = "TUM".to_owned();
        layout.time = TimeColumns::One(0, unit.or(Some(TimeUnit::Second)));
    }
    layout.length = layout.length.or(unit_in_remarks(lines));
    several_bodies(&mut layout, lines);
    Ok(layout)
}

/// The names without the counts that pandas puts behind a name that comes again: `x.1`.
fn without_counts(names: &[String]) -> Vec<String> {
    let plain = |name: &String| match name.rsplit_once('.') {
        Some((base, count)) if !count.is_empty() && count.bytes().all(|of| of.is_ascii_digit()) => {
            let is_there = names.iter().any(|name| name == base);
            if is_there {
                base.to_owned()
            } else {
                name.clone()
            }
        }
        _ => name.clone(),
    };
    names.iter().map(plain).collect()
}

/// A name of bodies is one where they come again: a number of its own for each row is none.
fn several_bodies(layout: &mut TableLayout, lines: &Lines) {
    let Some(column) = layout.body_name else {
        return;
    };
    let names: BTreeSet<&String> = lines
        .rows
        .iter()
        .filter_map(|row| row.cells.get(column))
        .collect();
    if names.len() > 2 && 2 * names.len() > lines.rows.len() {
        layout.body_name = None;
        layout.notes.push(format!(
            "column {} is another in nearly each row: it is not taken for names of bodies",
            column + 1
        ));
    }
}

/// The names with the units of a line of units below them.
fn with_units(names: &[String], lines: &Lines, number: usize) -> Vec<String> {
    let plain = |cell: &str| cell.trim_matches(['[', ']', '(', ')', ' ']).to_lowercase();
    let is_unit = |cell: &str| {
        let unit = plain(cell);
        TimeUnit::of(&unit).is_some()
            || length_unit(&unit).is_some()
            || AngleUnit::of(&unit).is_some()
    };
    let is_nothing =
        |cell: &str| ["", "-", "1", "none", "unitless", "#"].contains(&plain(cell).as_str());
    let are_units = |line: &&Line| {
        let units = line.cells.iter().filter(|cell| is_unit(cell)).count();
        line.number > number
            && units >= 3
            && line
                .cells
                .iter()
                .all(|cell| is_unit(cell) || is_nothing(cell))
    };
    let units = lines.head.iter().find(are_units);
    let named = names.iter().enumerate().map(|(column, name)| {
        let unit = units
            .and_then(|line| line.cells.get(column))
            .filter(|cell| is_unit(cell));
        match unit {
            Some(unit) if !name.contains(['[', '(']) => format!("{name} [{}]", plain(unit)),
            _ => name.clone(),
        }
    });
    named.collect()
}

/// The unit of lengths that a remark above the columns has: `Units: mm`.
fn unit_in_remarks(lines: &Lines) -> Option<LengthUnit> {
    let remarks = lines
        .head
        .iter()
        .map(|line| line.cells.join(" ").to_lowercase());
    { remarks }
        .filter(|line| line.contains("unit"))
        .find_map(|line| {
            let words = line.split(|of: char| !of.is_alphanumeric());
            { words }
                .filter(|word| word.len() > 1 && *word != "in")
                .find_map(length_unit)
        })
}

/// The names with those in the line above, each of which goes on to the right until the next; `None` where there is no
/// such line.
fn under_owners(names: &[String], lines: &Lines, number: usize) -> Option<Vec<String>> {
    let above = lines.head.iter().rfind(|line| line.number < number)?;
    let is_wide = above.cells.len() == names.len() || above.filled() > names.len() / 2;
    let count = above.cells.iter().filter(|cell| !cell.is_empty()).count();
    if !is_wide || count < 2 {
        return None;
    }
    let mut owner = "";
    let named = names.iter().enumerate().map(|(column, name)| {
        if let Some(cell) = above.cells.get(column).filter(|cell| !cell.is_empty()) {
            owner = cell;
        }
        // Times are nobody's.
        match meaning(name) {
            Some(Meaning::Time { .. } | Meaning::Frame) | None => name.clone(),
            Some(_) => format!("{owner}.{name}"),
        }
    });
    Some(named.collect())
}

/// The names of columns with those of their groups, which stand above nothing: `position,x,y,z`.
fn grouped(names: &[String], lines: &Lines) -> Vec<String> {
    // So many rows tell that a column is empty.
    const ROWS: usize = 20;
    let is_empty = |column: usize| {
        let mut rows = lines.rows.iter().take(ROWS);
        rows.all(|row| row.cells.get(column).is_none_or(String::is_empty))
    };
    let mut group: Option<&str> = None;
    let named = names.iter().enumerate().map(|(column, name)| {
        if GROUPS.contains(&name.as_str()) && is_empty(column) {
            group = Some(name);
            return "-".to_owned();
        }
        match group {
            Some(group) if !name.is_empty() => format!("{group}.{name}"),
            _ => name.clone(),
        }
    });
    named.collect()
}
