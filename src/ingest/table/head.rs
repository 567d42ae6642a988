//! Heads of tables that are no vendor's own, and tables without one.

use super::columns::{Meaning, meaning};
use super::layout::{
    AngleUnit, BodyColumns, Fault, Layout, Orientation, QuaternionOrder, TimeColumns, fault,
    points_are_taken,
};
use super::text::{Line, Lines, number};
use super::units::TimeUnit;

/// Numbers greater than this are nanoseconds since 1970, and never seconds of anything.
const NANOSECONDS_MIN: f64 = 1e17;

/// The layout that a line of column names gives, and whether an order of numbered parts was assumed.
pub(super) fn layout(
    line: usize,
    names: &[String],
    order: Option<QuaternionOrder>,
) -> Result<Layout, Fault> {
    let meanings: Vec<Option<Meaning>> = names.iter().map(|name| meaning(name)).collect();
    let mut used = vec![false; names.len()];
    let mut one = |what: &str, is_it: &dyn Fn(&Meaning) -> bool| -> Result<Option<usize>, Fault> {
        let found = (0..names.len()).filter(|index| meanings[*index].as_ref().is_some_and(is_it));
        let found: Vec<usize> = found.collect();
        match found[..] {
            [] => Ok(None),
            [index] => {
                used[index] = true;
                Ok(Some(index))
            }
            _ => {
                let names: Vec<&str> = found.iter().map(|index| names[*index].as_str()).collect();
                fault(
                    line,
                    format!(
                        "several columns for {what}: {}; expected one: name the columns that are meant \
                         with --columns, and - for the others",
                        names.join(", ")
                    ),
                )
            }
        }
    };
    let mut position = [None; 3];
    for (axis, of) in position.iter_mut().enumerate() {
        *of = one(
            ["x", "y", "z"][axis],
            &|m| matches!(m, Meaning::Position { axis: of, .. } if *of == axis),
        )?;
    }
    let mut quaternion = [None; 4];
    let mut numbered = [None; 4];
    let mut angles = [None; 3];
    for part in 0..4 {
        let name = ["qx", "qy", "qz", "qw"][part];
        quaternion[part] = one(name, &|m| *m == Meaning::Quaternion(part))?;
        numbered[part] = one(name, &|m| *m == Meaning::Numbered(part))?;
        // `rw` beside `rx`, `ry`, `rz` makes a quaternion of them.
        let of = one(
            name,
            &|m| matches!(m, Meaning::Angle { axis, .. } if *axis == part),
        )?;
        match angles.get_mut(part) {
            Some(angle) => *angle = of,
            None if of.is_some() => {
                quaternion = [angles[0], angles[1], angles[2], of];
                angles = [None; 3];
            }
            None => {}
        }
    }
    let body_name = one("the body's name", &|m| *m == Meaning::Body)?;
    let mut notes = Vec::new();
    let all = |parts: [Option<usize>; 4]| -> Option<[usize; 4]> {
        let parts: Vec<usize> = parts.into_iter().flatten().collect();
        parts.try_into().ok()
    };
    let is_order_named = all(quaternion).is_some();
    let orientation = if let Some(parts) = all(quaternion) {
        Orientation::Quaternion(parts)
    } else if let Some([a, b, c, d]) = all(numbered) {
        let why = match order {
            Some(_) => "as --quaternion says",
            None => "the usual order (--quaternion xyzw for the other)",
        };
        let order = order.unwrap_or(QuaternionOrder::Wxyz);
        notes.push(format!(
            "the quaternion's columns are numbered: taken as {}, {why}",
            order.words()
        ));
        Orientation::Quaternion(match order {
            QuaternionOrder::Wxyz => [b, c, d, a],
            QuaternionOrder::Xyzw => [a, b, c, d],
        })
    } else if let [Some(x), Some(y), Some(z)] = angles {
        let is_degree = |index: usize| matches!(meanings[index], Some(Meaning::Angle { is_degree, .. }) if is_degree);
        let unit = if is_degree(x) {
            AngleUnit::Degree
        } else {
            AngleUnit::Radian
        };
        Orientation::Angles([x, y, z], unit)
    } else if !meanings.iter().any(is_of_orientation) {
        notes.push(points_are_taken("no columns for an orientation"));
        Orientation::Unseen
    } else {
        return fault(
            line,
            format!(
                "not all columns for an orientation among {}; expected qx, qy, qz and qw in any order, or \
                 their names with --columns",
                listed(names)
            ),
        );
    };
    let [Some(x), Some(y), Some(z)] = position else {
        return fault(
            line,
            format!(
                "no columns for a position among {}; expected x, y and z in any order, or their names \
                 with --columns",
                listed(names)
            ),
        );
    };
    let position = [x, y, z];
    let length = position.iter().find_map(|index| match meanings[*index] {
        Some(Meaning::Position { unit, .. }) => unit,
        _ => None,
    });
    let time = time(line, names, &meanings, &mut used)?;
    let unread = names.iter().zip(&used);
    let unread = unread.filter(|(name, used)| !**used && !is_skipped(name));
    Ok(Layout {
        kind: String::new(),
        time,
        bodies: vec![BodyColumns {
            name: None,
            position,
            orientation,
        }],
        body_name,
        length,
        rate_hz: None,
        preset: None,
        unread: unread.map(|(name, _)| name.clone()).collect(),
        is_order_named,
        notes,
        is_section: false,
    })
}

fn is_of_orientation(meaning: &Option<Meaning>) -> bool {
    matches!(
        meaning,
        Some(Meaning::Quaternion(_) | Meaning::Numbered(_) | Meaning::Angle { .. })
    )
}

/// How a column is named that is not to be read.
fn is_skipped(name: &str) -> bool {
    name == "-" || name.is_empty()
}

fn listed(names: &[String]) -> String {
    let names = names.iter().filter(|name| !is_skipped(name));
    let names: Vec<&str> = names.map(String::as_str).collect();
    names.join(", ")
}

/// The columns of time: that of the highest rank, in two parts if it is; otherwise frames.
fn time(
    line: usize,
    names: &[String],
    meanings: &[Option<Meaning>],
    used: &mut [bool],
) -> Result<TimeColumns, Fault> {
    let ranked = meanings
        .iter()
        .enumerate()
        .filter_map(|(index, of)| match of {
            Some(Meaning::Time { rank, unit }) => Some((*rank, index, *unit)),
            _ => None,
        });
    let ranked: Vec<(u8, usize, Option<TimeUnit>)> = ranked.collect();
    let Some(best) = ranked.iter().map(|(rank, ..)| *rank).max() else {
        let frame = meanings.iter().position(|of| *of == Some(Meaning::Frame));
        return Ok(match frame {
            Some(index) => {
                used[index] = true;
                TimeColumns::One(index, Some(TimeUnit::Frame))
            }
            None => TimeColumns::Row,
        });
    };
    let of_best: Vec<(usize, Option<TimeUnit>)> = ranked
        .iter()
        .filter(|(rank, ..)| *rank == best)
        .map(|(_, index, unit)| (*index, *unit))
        .collect();
    let (s, ns) = (Some(TimeUnit::Second), Some(TimeUnit::Nanosecond));
    let found = match of_best[..] {
        [(index, unit)] => TimeColumns::One(index, unit),
        [(whole, a), (rest, b)] if (a, b) == (s, ns) => TimeColumns::Two(whole, rest),
        [(rest, b), (whole, a)] if (a, b) == (s, ns) => TimeColumns::Two(whole, rest),
        _ => {
            let names: Vec<&str> = of_best.iter().map(|(i, _)| names[*i].as_str()).collect();
            return fault(
                line,
                format!(
                    "several columns for the time: {}; expected one: name the columns that are meant \
                     with --columns, and - for the others",
                    names.join(", ")
                ),
            );
        }
    };
    match found {
        TimeColumns::One(index, _) => used[index] = true,
        TimeColumns::Two(whole, rest) => {
            used[whole] = true;
            used[rest] = true;
        }
        TimeColumns::Row => {}
    }
    Ok(found)
}

/// The layout of a table that no program's head is before: its last line of names, or by the number of its
/// columns where it has none.
pub(super) fn general(lines: &Lines, order: Option<QuaternionOrder>) -> Result<Layout, Fault> {
    let row = &lines.rows[0];
    let names = lines
        .head
        .iter()
        .rev()
        .find(|line| line.cells.len() == row.cells.len() && has_names(line));
    if let Some(line) = names {
        let layout = layout(line.number, &line.cells, order)?;
        let is_euroc = line.cells.iter().any(|name| name.contains("p_RS_R"));
        return Ok(Layout {
            kind: if is_euroc { "EuRoC" } else { "a table" }.to_owned(),
            ..layout
        });
    }
    if let Some(line) = lines.head.iter().rev().find(|line| has_names(line)) {
        return fault(
            line.number,
            format!(
                "{} column names, and {} numbers in line {}; expected as many",
                line.cells.len(),
                row.cells.len(),
                row.number
            ),
        );
    }
    without_head(row, order)
}

/// Whether a line names the columns that points need.
fn has_names(line: &Line) -> bool {
    let known = line.cells.iter().filter(|name| meaning(name).is_some());
    known.count() >= 3
}

fn without_head(row: &Line, order: Option<QuaternionOrder>) -> Result<Layout, Fault> {
    let count = row.cells.len();
    let first = row.cells.first().and_then(|cell| number(cell));
    let is_euroc = count >= 8 && first.is_some_and(|first| first >= NANOSECONDS_MIN);
    if !is_euroc && count != 8 {
        return fault(
            row.number,
            format!(
                "{count} columns without names, expected 8 (t, x, y, z, qx, qy, qz, qw), or the names \
                 with --columns"
            ),
        );
    }
    let (order, why) = match (order, is_euroc) {
        (Some(order), _) => (order, "--quaternion says"),
        (None, true) => (
            QuaternionOrder::Wxyz,
            "EuRoC has them, whose times are nanoseconds too",
        ),
        (None, false) => (QuaternionOrder::Xyzw, "TUM has them, with 8 columns too"),
    };
    let (kind, quaternion, named) = match order {
        QuaternionOrder::Xyzw => ("TUM", [4, 5, 6, 7], "qx, qy, qz, qw"),
        QuaternionOrder::Wxyz => ("EuRoC", [5, 6, 7, 4], "qw, qx, qy, qz"),
    };
    let unit = is_euroc.then_some(TimeUnit::Nanosecond);
    Ok(Layout {
        kind: kind.to_owned(),
        time: TimeColumns::One(0, unit),
        bodies: vec![BodyColumns {
            name: None,
            position: [1, 2, 3],
            orientation: Orientation::Quaternion(quaternion),
        }],
        body_name: None,
        length: None,
        rate_hz: None,
        preset: None,
        unread: (9..=count)
            .map(|column| format!("column {column}"))
            .collect(),
        is_order_named: false,
        notes: vec![format!(
            "columns have no names: taken as t, x, y, z, {named}, as {why} (--columns for others)"
        )],
        is_section: false,
    })
}
