//! TSV of Qualisys Track Manager: trajectories of markers (3D) and poses of bodies (6D), with events.

use crate::ingest::table::layout::{
    Angles, BodyColumns, HeadMark, Orientation, SeenColumn, TableFault, TableLayout, TimeColumns,
    fault, points_are_taken,
};
use crate::ingest::table::text::{Line, Lines, number};
use crate::ingest::table::turn::Turn;
use crate::ingest::table::units::{AngleUnit, TimeUnit};

/// Columns of a body: its position, three angles, a residual, and a matrix column by column.
const BODY_COLUMNS: usize = 16;
/// The matrix in them.
const MATRIX_AT: usize = 7;

/// The layout of a TSV of Qualisys; `None` for others.
pub(super) fn layout(lines: &Lines) -> Option<Result<(TableLayout, usize), TableFault>> {
    let has = |key: &str| lines.head.iter().any(|line| line.cells[0] == key);
    (has("NO_OF_FRAMES") && (has("DATA_INCLUDED") || has("MARKER_NAMES") || has("BODY_NAMES")))
        .then(|| qualisys(lines).map(|layout| (layout, 0)))
}

fn qualisys(lines: &Lines) -> Result<TableLayout, TableFault> {
    let line_of = |key: &str| lines.head.iter().find(|line| line.cells[0] == key);
    let said = |key: &str| line_of(key)?.cells.get(1).map(String::as_str);
    let kind = said("DATA_INCLUDED").unwrap_or(match line_of("BODY_NAMES") {
        Some(_) => "6D",
        None => "3D",
    });
    let named_line = lines.head.iter().rfind(|line| is_named(line));
    // Frame and time are columns only where the export was asked for them.
    let named = named_line
        .map(|line| line.cells.as_slice())
        .unwrap_or_default();
    let listed = match kind {
        "6D" => line_of("BODY_NAMES"),
        "3D" => line_of("MARKER_NAMES"),
        _ => None,
    };
    let Some(listed) = listed else {
        return fault(
            lines.head[0].number,
            format!(
                "data of kind {kind} and no names of bodies or markers, expected 6D or 3D with its head: export it again"
            ),
        );
    };
    let (has_frame, has_time) = match named_line {
        Some(_) => (
            named.iter().any(|of| of == "Frame"),
            named.iter().any(|of| of == "Time"),
        ),
        None => beside(lines.rows[0].filled(), listed.cells.len() - 1, kind),
    };
    let first = usize::from(has_frame) + usize::from(has_time);
    let rate_hz = said("FREQUENCY")
        .and_then(number)
        .filter(|rate| *rate > 0.0);
    let time = match (has_frame, has_time, rate_hz) {
        (true, _, Some(_)) => TimeColumns::One(0, Some(TimeUnit::Frame)),
        (_, true, _) => TimeColumns::One(usize::from(has_frame), Some(TimeUnit::Second)),
        (_, false, _) => TimeColumns::Row,
    };
    let names = listed.cells[1..].iter();
    let (bodies, unread) = if kind == "6D" {
        let names: Vec<&String> = names.filter(|name| !name.is_empty()).collect();
        bodies(&names, named, first, &lines.rows[0])?
    } else {
        (markers(names, first, lines.rows[0].cells.len()), Vec::new())
    };
    let mut notes = Vec::new();
    if kind == "6D" {
        notes.push(
            "orientations are read from the matrix Rot[0] to Rot[8], column by column".to_owned(),
        );
    } else {
        notes.push(points_are_taken("markers, no bodies (export 6D for those)"));
    }
    let events = lines.head.iter().filter(|line| line.cells[0] == "EVENT");
    let marks = events.filter_map(|line| {
        let cell = |at: usize| line.cells.get(at).cloned();
        Some(HeadMark {
            name: cell(1)?,
            frame: cell(2)?,
            time: cell(3).unwrap_or_default(),
        })
    });
    Ok(TableLayout {
        rate_hz,
        preset: Some("qualisys"),
        unread,
        is_order_named: true,
        is_ragged: true,
        is_zero_unseen: true,
        notes: if bodies
            .iter()
            .any(|of| matches!(of.orientation, Orientation::Angles(_)))
        {
            Vec::new()
        } else {
            notes
        },
        marks: marks.collect(),
        ..TableLayout::plain(format!("Qualisys {kind}"), time, bodies)
    })
}

/// Whether a line names the columns of coordinates.
fn is_named(line: &Line) -> bool {
    let is_axis =
        |cell: &String| cell == "X" || cell.ends_with(" X") || cell == "Y" || cell.ends_with(" Y");
    line.cells.iter().filter(|cell| is_axis(cell)).count() >= 2
}

/// Whether frames and times stand before so many bodies or markers, by the number of columns.
fn beside(columns: usize, bodies: usize, kind: &str) -> (bool, bool) {
    let each = if kind == "6D" { BODY_COLUMNS } else { 3 };
    match columns.saturating_sub(each * bodies) {
        0 => (false, false),
        1 => (true, false),
        _ => (true, true),
    }
}

fn markers<'n>(
    names: impl Iterator<Item = &'n String>,
    first: usize,
    cells: usize,
) -> Vec<BodyColumns> {
    let marker = |(index, name): (usize, &String)| {
        let at = first + 3 * index;
        BodyColumns {
            name: Some(match name.as_str() {
                "" => format!("unlabeled {}", index + 1),
                name => name.to_owned(),
            }),
            position: [at, at + 1, at + 2],
            orientation: Orientation::Unseen,
            seen: Vec::new(),
        }
    };
    let all = names.enumerate().map(marker);
    // A name more than there are columns is an empty cell at the end of a line.
    all.filter(|of| of.position[2] < cells).collect()
}

/// The columns of bodies, and those that are not read.
fn bodies(
    names: &[&String],
    named: &[String],
    first: usize,
    row: &Line,
) -> Result<(Vec<BodyColumns>, Vec<String>), TableFault> {
    let begins: Vec<usize> = match named {
        [] => (0..names.len())
            .map(|index| first + BODY_COLUMNS * index)
            .collect(),
        named => {
            let is_first = |at: &usize| named[*at] == "X" || named[*at].ends_with(" X");
            (0..named.len()).filter(is_first).collect()
        }
    };
    if begins.len() != names.len() {
        return fault(
            row.number,
            format!(
                "{} names of bodies and the columns of {}, expected as many: export it again",
                names.len(),
                begins.len()
            ),
        );
    }
    let mut bodies = Vec::new();
    for (index, begin) in begins.iter().enumerate() {
        let end = begins
            .get(index + 1)
            .copied()
            .unwrap_or(row.cells.len().max(named.len()));
        let find =
            |name: &str| (*begin..end).find(|at| named.get(*at).is_some_and(|of| of == name));
        let matrix = match named {
            [] => Some(begin + MATRIX_AT),
            _ => find("Rot[0]"),
        };
        let residual = match named {
            [] => Some(begin + MATRIX_AT - 1),
            _ => find("Residual"),
        };
        let turn = [find("Roll"), find("Pitch"), find("Yaw")];
        let orientation = match (matrix.filter(|at| at + 9 <= end), turn) {
            // Written column by column.
            (Some(at), _) => {
                Orientation::Matrix(std::array::from_fn(|of| at + 3 * (of % 3) + of / 3))
            }
            (None, [Some(x), Some(y), Some(z)]) => Orientation::Angles(Angles {
                columns: [x, y, z],
                unit: Some(AngleUnit::Degree),
                turn: Some(Turn::RPY),
            }),
            _ => {
                return fault(
                    row.number,
                    format!(
                        "{:?} has neither Rot[0] to Rot[8] nor Roll, Pitch and Yaw, expected them: export it again",
                        names[index]
                    ),
                );
            }
        };
        bodies.push(BodyColumns {
            name: Some(names[index].clone()),
            position: [*begin, begin + 1, begin + 2],
            orientation,
            seen: residual.map(SeenColumn::Residual).into_iter().collect(),
        });
    }
    Ok((bodies, Vec::new()))
}
