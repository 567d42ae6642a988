//! Tables of OptiTrack's Motive.

use crate::ingest::table::layout::{
    Angles, BodyColumns, Orientation, TableFault, TableLayout, TimeColumns, fault, points_are_taken,
};
use crate::ingest::table::text::{Line, Lines, number};
use crate::ingest::table::turn::Turn;
use crate::ingest::table::units::{AngleUnit, TimeUnit, length_unit};

/// What poses are of,
const POSES: [&str; 2] = ["Rigid Body", "Bone"];
/// and what points are of.
const POINTS: &str = "Marker";
/// Names that Motive makes up for what nobody named.
const UNLABELED: &str = "Unlabeled";

/// The layout of a table of Motive; `None` for others.
pub(super) fn layout(lines: &Lines) -> Option<Result<(TableLayout, usize), TableFault>> {
    let first = lines.head.first()?.cells.first()?;
    (first == "Format Version").then(|| motive(lines).map(|layout| (layout, 0)))
}

/// Columns of a body or a marker, as far as they are found.
struct MotiveBody {
    kind: String,
    name: String,
    position: [Option<usize>; 3],
    rotation: [Option<usize>; 4],
}

/// A line of keys and values; then, above the columns, what they are of, whose, an identifier, perhaps a
/// parent, rotation or position, and the axis.
fn motive(lines: &Lines) -> Result<TableLayout, TableFault> {
    let first = &lines.head[0];
    let said = |key: &str| {
        let at = first.cells.iter().position(|cell| cell == key)?;
        first.cells.get(at + 1).map(String::as_str)
    };
    let head = &lines.head[1..];
    let is_kind = |cell: &String| POSES.contains(&cell.as_str()) || cell == POINTS;
    let kinds = head.iter().position(|line| line.cells.iter().any(is_kind));
    let axes = head.iter().position(|line| line.cells[0] == "Frame");
    let (Some(kinds), Some(axes)) = (kinds, axes.filter(|axes| *axes > 0)) else {
        return fault(
            head.last().map_or(first.number, |line| line.number),
            "no rigid bodies with rotations and no markers in this head of Motive, expected some above a line of axes \
             (Frame, Time (Seconds), X, Y, …): export it again with Rigid Bodies",
        );
    };
    let (parts, axes) = (&head[axes - 1], &head[axes]);
    let (all, others) = found(&head[kinds], head.get(kinds + 1), parts, axes);
    let turn = angles_of(said("Rotation Type"), first, &all)?;
    let bodies: Vec<&str> = all
        .iter()
        .filter(|of| of.kind != POINTS)
        .map(|of| of.name.as_str())
        .collect();
    // Markers of a body are named after it, and say no more than it does.
    let is_of_body = |of: &MotiveBody| {
        of.kind == POINTS
            && bodies.iter().any(|body| {
                of.name
                    .strip_prefix(body)
                    .is_some_and(|rest| rest.starts_with([':', '_']))
            })
    };
    let is_unnamed = |of: &MotiveBody| {
        of.kind == POINTS && (of.name.is_empty() || of.name.starts_with(UNLABELED))
    };
    let mut left = others;
    let mut columns = Vec::new();
    let mut unlabeled = 0;
    for body in &all {
        if is_unnamed(body) {
            unlabeled += 1;
        } else if is_of_body(body) {
            left += 3;
        } else {
            columns.push(body_columns(body, turn, axes.number)?);
        }
    }
    let mut notes: Vec<String> = Vec::new();
    if columns.is_empty()
        || columns
            .iter()
            .all(|of| of.orientation == Orientation::Unseen)
    {
        notes.push(points_are_taken("markers, no rigid bodies"));
    }
    if columns.is_empty() {
        return fault(
            axes.number,
            format!(
                "nothing but {unlabeled} unlabeled markers, expected rigid bodies or labeled markers: label them, and export again"
            ),
        );
    }
    if unlabeled > 0 {
        notes.push(format!("{unlabeled} unlabeled markers are not read"));
    }
    let mut against = Vec::new();
    if said("Coordinate Space").is_some_and(|space| space != "Global") {
        against.push(
            "Coordinate Space is not Global: poses are relative to another body; expected an export with Global".to_owned(),
        );
    }
    Ok(TableLayout {
        length: length(said("Length Units"), first)?,
        rate_hz: said("Export Frame Rate").and_then(number),
        preset: Some("motive-y-up"),
        unread: match left {
            0 => Vec::new(),
            left => vec![format!("{left} of markers, errors and the like")],
        },
        is_order_named: true,
        notes,
        against,
        is_ragged: true,
        ..TableLayout::plain(
            format!("Motive {}", said("Format Version").unwrap_or_default()),
            TimeColumns::One(1, Some(TimeUnit::Second)),
            columns,
        )
    })
}

/// What stands in the columns, in their order, and how many are of nothing that is read.
fn found(
    kinds: &Line,
    names: Option<&Line>,
    parts: &Line,
    axes: &Line,
) -> (Vec<MotiveBody>, usize) {
    let cell = |line: &Line, column: usize| line.cells.get(column).cloned().unwrap_or_default();
    let mut all: Vec<MotiveBody> = Vec::new();
    let mut others = 0;
    for column in 2..axes.cells.len() {
        let (kind, part) = (cell(kinds, column), cell(parts, column));
        if kind != POINTS && !POSES.contains(&kind.as_str()) {
            others += usize::from(!part.is_empty());
            continue;
        }
        let name = names.map_or(String::new(), |line| cell(line, column));
        if all
            .last()
            .is_none_or(|last| last.name != name || last.kind != kind)
        {
            all.push(MotiveBody {
                kind,
                name,
                position: [None; 3],
                rotation: [None; 4],
            });
        }
        let Some(body) = all.last_mut() else {
            continue;
        };
        let axis = cell(axes, column);
        let axis = (axis.len() == 1).then(|| "XYZW".find(&axis)).flatten();
        match (part.as_str(), axis) {
            ("Rotation", Some(axis)) => body.rotation[axis] = Some(column),
            ("Position", Some(axis)) if axis < 3 => body.position[axis] = Some(column),
            _ => others += 1,
        }
    }
    (all, others)
}

/// What the angles of its rotations mean; `None` for quaternions.
fn angles_of(
    named: Option<&str>,
    line: &Line,
    all: &[MotiveBody],
) -> Result<Option<&'static Turn>, TableFault> {
    let has_poses = all.iter().any(|of| of.kind != POINTS);
    let Some(named) = named.filter(|named| has_poses && *named != "Quaternion") else {
        return Ok(None);
    };
    // XYZ: about the body's x, then y, then z.
    match Turn::named(&format!("euler-{}", named.to_lowercase())) {
        Some(turn) => Ok(Some(turn)),
        None => fault(
            line.number,
            format!(
                "Rotation Type is {named}, expected Quaternion or XYZ: export it again with that rotation type"
            ),
        ),
    }
}

fn body_columns(
    body: &MotiveBody,
    turn: Option<&'static Turn>,
    line: usize,
) -> Result<BodyColumns, TableFault> {
    let name = Some(body.name.clone());
    let (position, orientation) = match (body.position, body.rotation, turn) {
        ([Some(x), Some(y), Some(z)], ..) if body.kind == POINTS => {
            ([x, y, z], Orientation::Unseen)
        }
        ([Some(x), Some(y), Some(z)], [Some(a), Some(b), Some(c), Some(d)], None) => {
            ([x, y, z], Orientation::Quaternion([a, b, c, d]))
        }
        ([Some(x), Some(y), Some(z)], [Some(a), Some(b), Some(c), None], Some(turn)) => {
            let columns = [a, b, c];
            let unit = Some(AngleUnit::Degree);
            let turn = Some(turn);
            (
                [x, y, z],
                Orientation::Angles(Angles {
                    columns,
                    unit,
                    turn,
                }),
            )
        }
        _ => {
            return fault(
                line,
                format!(
                    "{:?} has not all of X, Y, Z, W of a rotation and X, Y, Z of a position, expected them: export it again \
                     with both",
                    body.name
                ),
            );
        }
    };
    Ok(BodyColumns {
        name,
        position,
        orientation,
        seen: Vec::new(),
    })
}

fn length(
    named: Option<&str>,
    line: &Line,
) -> Result<Option<crate::motion::LengthUnit>, TableFault> {
    let Some(named) = named else {
        return Ok(None);
    };
    match length_unit(&named.to_lowercase()) {
        Some(unit) => Ok(Some(unit)),
        None => fault(
            line.number,
            format!(
                "Length Units is {named}, expected Meters, Centimeters or Millimeters: export it again with one of them"
            ),
        ),
    }
}
