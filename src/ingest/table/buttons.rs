//! Columns of buttons: where one goes down, an event happens.

use std::collections::BTreeMap;

use super::layout::{TableFault, TableLayout, fault, shown};
use super::missing::is_absent;
use super::order::Days;
use super::poses::{MarkColumn, TableOptions};
use super::said::{Said, listed};
use super::text::{Line, number};
use super::time::Clock;
use crate::motion::Stamp;

/// Share of the greatest value above which a button is down.
const DOWN: f64 = 0.5;

/// The column of a button.
struct ButtonColumn<'o> {
    of: &'o MarkColumn,
    column: usize,
    /// The value above which it is down.
    level: f64,
}

/// When the buttons went down that are asked for. Fails where there is no such column, or a cell of it is no number.
pub(super) fn presses(
    layout: &TableLayout,
    head: &[Line],
    rows: &[Line],
    options: &TableOptions,
    clock: Clock,
    said: &mut Said,
) -> Result<Vec<Stamp>, TableFault> {
    let mut all = Vec::new();
    for of in &options.mark_columns {
        let button = button(of, head, rows, options)?;
        let found = button.presses(layout, rows, clock)?;
        said.note(format!(
            "{} goes above {} {} times: a mark each",
            of.name,
            button.level,
            found.len()
        ));
        all.extend(found);
    }
    all.sort_unstable();
    Ok(all)
}

/// The column of that name: in what is said of columns, else in the last line of the head that has it.
fn button<'o>(
    of: &'o MarkColumn,
    head: &[Line],
    rows: &[Line],
    options: &TableOptions,
) -> Result<ButtonColumn<'o>, TableFault> {
    let is_it = |name: &str| of.is_named(name);
    let given = options.columns.as_deref();
    let column = match given {
        Some(names) => names.split(',').position(is_it),
        None => {
            let heads = head.iter().rev();
            heads
                .filter_map(|line| line.cells.iter().position(|cell| is_it(cell)))
                .next()
        }
    };
    let Some(column) = column else {
        let names = match (given, head.last()) {
            (Some(names), _) => names.split(',').map(str::to_owned).collect(),
            (None, Some(head)) => head.cells.clone(),
            (None, None) => Vec::new(),
        };
        return fault(
            head.last().map_or(0, |line| line.number),
            format!(
                "no column {:?} among {}, expected the button's in --mark-column",
                of.name,
                listed(&names)
            ),
        );
    };
    let values = rows.iter().filter_map(|row| value(row.cells.get(column)?));
    let greatest = values.fold(1.0, f64::max);
    Ok(ButtonColumn {
        of,
        column,
        level: of.level.unwrap_or(DOWN * greatest),
    })
}

impl ButtonColumn<'_> {
    /// When it went down: of each body by itself, where rows are of several in turn. What is down in the first row has
    /// gone down before.
    fn presses(
        &self,
        layout: &TableLayout,
        rows: &[Line],
        clock: Clock,
    ) -> Result<Vec<Stamp>, TableFault> {
        let mut bodies: BTreeMap<Option<&String>, PressedRows> = BTreeMap::new();
        let mut found = Vec::new();
        for row in rows {
            let name = layout.body_name.and_then(|column| row.cells.get(column));
            let body = bodies.entry(name).or_default();
            let place = body.rows;
            body.rows += 1;
            let Some(cell) = row.cells.get(self.column).filter(|cell| !is_absent(cell)) else {
                continue;
            };
            let Some(value) = value(cell) else {
                return fault(
                    row.number,
                    format!(
                        "column {}: {} is no number, expected one in the column of --mark-column {}",
                        self.column + 1,
                        shown(cell),
                        self.of.name
                    ),
                );
            };
            let is_down = value > self.level;
            let Ok(ns) = clock.of(row, place) else {
                continue;
            };
            let ns = body.days.of(ns, clock.wraps());
            if is_down && body.is_down == Some(false) {
                found.push(Stamp(ns));
            }
            body.is_down = Some(is_down);
        }
        Ok(found)
    }
}

/// The rows of a body, as far as they were looked at.
#[derive(Default)]
struct PressedRows {
    rows: usize,
    days: Days,
    is_down: Option<bool>,
}

/// How far a button is down.
fn value(cell: &str) -> Option<f64> {
    match cell.to_ascii_lowercase().as_str() {
        "true" | "yes" | "t" | "down" | "pressed" => Some(1.0),
        "false" | "no" | "f" | "up" | "released" => Some(0.0),
        _ => number(cell),
    }
}
