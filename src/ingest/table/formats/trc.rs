//! TRC, tables of markers by Motion Analysis, OpenSim and others.

use crate::ingest::table::layout::{
    BodyColumns, Orientation, TableFault, TableLayout, TimeColumns, fault, points_are_taken,
};
use crate::ingest::table::text::{Lines, number};
use crate::ingest::table::units::{TimeUnit, length_unit};

/// The layout of a TRC; `None` for other tables.
pub(super) fn layout(lines: &Lines) -> Option<Result<(TableLayout, usize), TableFault>> {
    let first = lines.head.first()?.cells.first()?;
    (first == "PathFileType").then(|| trc(lines).map(|layout| (layout, 0)))
}

/// A line of its kind, one of keys, one of values, one of names above the first of three columns each, one of axes.
fn trc(lines: &Lines) -> Result<TableLayout, TableFault> {
    let keys = lines
        .head
        .iter()
        .position(|line| line.cells[0] == "DataRate");
    let names = lines
        .head
        .iter()
        .find(|line| line.cells[0].starts_with("Frame#"));
    let values = keys.and_then(|keys| lines.head.get(keys + 1));
    let (Some(keys), Some(values), Some(names)) = (keys, values, names) else {
        return fault(
            lines.head[0].number,
            "no line DataRate, CameraRate, … or no line Frame#, Time, … in this head of TRC, expected both: export it again",
        );
    };
    let said = |key: &str| {
        let at = lines.head[keys].cells.iter().position(|cell| cell == key)?;
        values.cells.get(at)
    };
    let length = match said("Units") {
        None => None,
        Some(named) => match length_unit(&named.to_lowercase()) {
            Some(unit) => Some(unit),
            None => {
                return fault(
                    values.number,
                    format!(
                        "Units are {named}, expected m, cm or mm: export it again with one of them"
                    ),
                );
            }
        },
    };
    let marker = |(place, name): (usize, &String)| {
        let at = 2 + 3 * place;
        BodyColumns {
            name: Some(name.clone()),
            position: [at, at + 1, at + 2],
            orientation: Orientation::Unseen,
            seen: Vec::new(),
        }
    };
    let named = names.cells.iter().skip(2).filter(|name| !name.is_empty());
    let bodies: Vec<BodyColumns> = named.enumerate().map(marker).collect();
    if bodies.is_empty() {
        return fault(
            names.number,
            "no names of markers after Frame#, Time, expected some: export it again with markers",
        );
    }
    Ok(TableLayout {
        length,
        rate_hz: said("DataRate")
            .and_then(|cell| number(cell))
            .filter(|rate| *rate > 0.0),
        preset: Some("trc"),
        notes: vec![points_are_taken("markers, no rigid bodies")],
        is_ragged: true,
        is_zero_unseen: true,
        ..TableLayout::plain("TRC", TimeColumns::One(1, Some(TimeUnit::Second)), bodies)
    })
}
