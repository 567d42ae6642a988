//! The table of formats: who wrote a table decides what its numbers are.

mod motive;
mod qualisys;
mod trc;
mod unnamed;
mod vicon;

use super::columns::meaning;
use super::head;
use super::layout::{Fault, Layout, QuaternionOrder, TimeColumns, fault};
use super::text::{Line, Lines, Separator};
use super::units::TimeUnit;

/// A layout, and how many rows are before its own.
type Found = Result<(Layout, usize), Fault>;

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
        return Ok((unnamed::layout(lines, order)?, 0));
    };
    let (names, numbers) = (line.cells.len(), row.cells.len());
    let commas = match lines.separator == Separator::Byte(b',') && numbers > names {
        true => "; are these decimal commas? Export with points, or with semicolons between numbers",
        false => "",
    };
    fault(
        line.number,
        format!("{names} column names, and {numbers} numbers in line {}; expected as many{commas}", row.number),
    )
}

/// Whether a line names the columns that points need.
fn has_names(line: &Line) -> bool {
    let known = line.cells.iter().filter(|name| meaning(name).is_some());
    known.count() >= 3
}

fn of_names(lines: &Lines, line: &Line, order: Option<QuaternionOrder>) -> Result<Layout, Fault> {
    let names = grouped(&line.cells, lines);
    let mut layout = head::layout(line.number, &names, order)?;
    if names.iter().any(|name| name.contains("p_RS_R")) {
        layout.kind = "EuRoC".to_owned();
    }
    let tum = ["tx", "ty", "tz", "qx", "qy", "qz", "qw"];
    let is_tum = lines.separator == Separator::Blanks
        && names.len() == 1 + tum.len()
        && names[1..].iter().zip(tum).all(|(name, of)| name.eq_ignore_ascii_case(of));
    if let (true, TimeColumns::One(0, unit)) = (is_tum, layout.time) {
        layout.kind = "TUM".to_owned();
        layout.time = TimeColumns::One(0, unit.or(Some(TimeUnit::Second)));
    }
    Ok(layout)
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
