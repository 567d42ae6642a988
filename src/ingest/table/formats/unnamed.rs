//! Tables without names of columns: TUM and EuRoC, rows of matrices, messages of ROS 2.

use crate::ingest::table::layout::{
    BodyColumns, Orientation, QuaternionOrder, TableFault, TableLayout, TimeColumns, fault,
    points_are_taken,
};
use crate::ingest::table::missing::is_absent;
use crate::ingest::table::text::{Line, Lines, Separator, number};
use crate::ingest::table::turn::quaternion_of_matrix;
use crate::ingest::table::units::TimeUnit;

/// Numbers greater than this are nanoseconds since 1970, and never seconds of anything.
const NANOSECONDS_MIN: f64 = 1e17;
/// So many rows are looked at.
const ROWS: usize = 50;
/// Seconds since 1970 of this century.
const SECONDS: std::ops::Range<f64> = 9e8..4.2e9;

/// The layout of rows without names. Fails where their number of columns is none that is known.
pub(super) fn layout(
    lines: &Lines,
    order: Option<QuaternionOrder>,
) -> Result<TableLayout, TableFault> {
    let row = &lines.rows[0];
    let count = row.filled();
    if let Some(layout) = echoed(lines) {
        return Ok(layout);
    }
    if let Some(layout) = matrices(lines, count) {
        return Ok(layout);
    }
    let first = row.cells.first().and_then(|cell| number(cell));
    let is_ns = first.is_some_and(|first| first >= NANOSECONDS_MIN);
    let is_euroc = count >= 8 && is_ns && lines.separator == Separator::Byte(b',');
    if !is_euroc && count != 8 {
        return fault(
            row.number,
            format!(
                "{count} columns without names, expected 8 (t, x, y, z, qx, qy, qz, qw), the entries of a matrix, or the \
                 names with --columns"
            ),
        );
    }
    quaternions(lines, order, is_ns, is_euroc)
}

fn quaternions(
    lines: &Lines,
    order: Option<QuaternionOrder>,
    is_ns: bool,
    is_euroc: bool,
) -> Result<TableLayout, TableFault> {
    let count = lines.rows[0].filled();
    let is_tum = lines.separator == Separator::Blanks;
    let mut against = Vec::new();
    let (order, why) = match order {
        Some(order) => (order, "--quaternion says"),
        None if is_euroc => (
            QuaternionOrder::Wxyz,
            "EuRoC has them, with commas and nanoseconds too",
        ),
        None if is_tum => (
            QuaternionOrder::Xyzw,
            "TUM has them, with 8 columns and blanks too",
        ),
        None => {
            against.push(
                "nothing tells the order of quaternions in columns without names, neither blanks (TUM) nor commas with \
                 nanoseconds (EuRoC): expected --quaternion xyzw or --quaternion wxyz"
                    .to_owned(),
            );
            (QuaternionOrder::Xyzw, "most have them")
        }
    };
    let (kind, named) = match order {
        QuaternionOrder::Xyzw => ("TUM", "qx, qy, qz, qw"),
        QuaternionOrder::Wxyz => ("EuRoC", "qw, qx, qy, qz"),
    };
    // TUM's times are seconds; numbers that no seconds can be are nanoseconds, as some programs write them.
    let unit = match (is_ns, is_tum) {
        (true, _) => Some(TimeUnit::Nanosecond),
        (false, true) => Some(TimeUnit::Second),
        (false, false) => None,
    };
    let body = BodyColumns {
        name: None,
        position: [1, 2, 3],
        orientation: Orientation::Quaternion(order.columns([4, 5, 6, 7])),
        seen: Vec::new(),
    };
    Ok(TableLayout {
        unread: (9..=count)
            .map(|column| format!("column {column}"))
            .collect(),
        notes: vec![format!(
            "columns have no names: taken as t, x, y, z, {named}, as {why} (--columns for others)"
        )],
        against,
        ..TableLayout::plain(kind, TimeColumns::One(0, unit), vec![body])
    })
}

/// Numbers of the rows that are looked at, from a column on; those of rows that have them all.
fn blocks<const N: usize>(lines: &Lines, from: usize) -> Vec<[f64; N]> {
    let block = |row: &Line| -> Option<[f64; N]> {
        let cells = row.cells.get(from..from + N)?;
        let numbers: Option<Vec<f64>> = cells.iter().map(|cell| number(cell)).collect();
        numbers?.try_into().ok()
    };
    lines.rows.iter().take(ROWS).filter_map(block).collect()
}

/// Rows of a 3×4 or 4×4 matrix, with a time before it or without: KITTI, ARKit and many others.
fn matrices(lines: &Lines, count: usize) -> Option<TableLayout> {
    let (from, is_square) = match count {
        12 => (0, false),
        13 => (1, false),
        16 => (0, true),
        17 => (1, true),
        _ => return None,
    };
    // Of a square one, the last row or the last column is 0, 0, 0, 1.
    let is_by_columns = is_square && {
        let all = blocks::<16>(lines, from);
        let is_last =
            |of: &[f64; 16]| of[3] == 0.0 && of[7] == 0.0 && of[11] == 0.0 && of[15] == 1.0;
        let is_position = all.iter().any(|of| of[12..15].iter().any(|of| *of != 0.0));
        !all.is_empty() && all.iter().all(is_last) && is_position
    };
    let at = |row: usize, column: usize| match is_by_columns {
        true => 4 * column + row,
        false => 4 * row + column,
    };
    let rotation: [usize; 9] = std::array::from_fn(|index| at(index / 3, index % 3));
    let all = blocks::<12>(lines, from);
    let is_rotation = |of: &[f64; 12]| {
        let entries = rotation.map(|index| of.get(index).copied().unwrap_or(f64::NAN));
        quaternion_of_matrix(&entries).is_some()
    };
    // A few rows may be of what was not seen.
    let rotations = all.iter().filter(|of| is_rotation(of)).count();
    if all.is_empty() || 4 * rotations < 3 * all.len() {
        return None;
    }
    let time = match from {
        0 => TimeColumns::Row,
        _ => TimeColumns::One(0, None),
    };
    let body = BodyColumns {
        name: None,
        position: [0, 1, 2].map(|row| from + at(row, 3)),
        orientation: Orientation::Matrix(rotation.map(|index| from + index)),
        seen: Vec::new(),
    };
    let (shape, by) = match (is_square, is_by_columns) {
        (true, true) => ("4×4", "column by column"),
        (true, false) => ("4×4", "row by row"),
        (false, _) => ("3×4", "row by row"),
    };
    let kind = if from == 0 && !is_square {
        "KITTI"
    } else {
        "matrices"
    };
    Some(TableLayout {
        notes: vec![
            format!("columns have no names: taken as a {shape} matrix {by}, whose first three columns are a rotation"),
            "poses are taken for those of the body in the world; of cameras as KITTI and OpenCV have them y is down: \
             expected --from camera"
                .to_owned(),
        ],
        ..TableLayout::plain(kind, time, vec![body])
    })
}

/// `ros2 topic echo --csv`: seconds, nanoseconds, one or two frames, then a pose or a point.
fn echoed(lines: &Lines) -> Option<TableLayout> {
    let row = &lines.rows[0];
    let at = |column: usize| row.cells.get(column).and_then(|cell| number(cell));
    let is_stamp = |seconds: f64, rest: f64| {
        let are_whole = seconds.fract() == 0.0 && rest.fract() == 0.0;
        are_whole && (0.0..1e9).contains(&rest) && (SECONDS.contains(&seconds) || seconds < 1e6)
    };
    if !is_stamp(at(0)?, at(1)?) || at(2).is_some() {
        return None;
    }
    let first = (2..row.cells.len()).find(|column| at(*column).is_some())?;
    let numbers = row.cells[first..]
        .iter()
        .take_while(|cell| number(cell).is_some() || is_absent(cell));
    let count = numbers.filter(|cell| !cell.is_empty()).count();
    let is_pose = count >= 7;
    if first > 4 || !(is_pose || count == 3) {
        return None;
    }
    let position = [0, 1, 2].map(|index| first + index);
    let orientation = match is_pose {
        true => Orientation::Quaternion([3, 4, 5, 6].map(|index| first + index)),
        false => Orientation::Unseen,
    };
    let named = match is_pose {
        true => "x, y, z, qx, qy, qz, qw".to_owned(),
        false => points_are_taken("x, y, z"),
    };
    let body = BodyColumns {
        name: None,
        position,
        orientation,
        seen: Vec::new(),
    };
    let unread = (first + if is_pose { 7 } else { 3 }..row.filled())
        .map(|column| format!("column {}", column + 1));
    let frames = &row.cells[2..first];
    Some(TableLayout {
        unread: unread.collect(),
        notes: vec![format!(
            "columns have no names: taken as ros2 topic echo --csv writes messages: sec, nanosec, frame ({}), {named}",
            frames.join(", ")
        )],
        // The frame of the child, where there are two.
        body_name: (frames.len() == 2).then_some(3),
        ..TableLayout::plain("ROS 2", TimeColumns::Two(0, 1), vec![body])
    })
}
