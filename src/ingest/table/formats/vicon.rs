//! Tables of Vicon's Tracker and Nexus.

use crate::ingest::table::layout::{
    Angles, BodyColumns, Orientation, TableFault, TableLayout, TimeColumns, fault, points_are_taken,
};
use crate::ingest::table::text::{Line, Lines, number};
use crate::ingest::table::units::{AngleUnit, TimeUnit, length_unit};

/// Sections that have poses,
const SECTIONS: [&str; 2] = ["Objects", "Segments"];
/// and that which has points.
const POINTS: &str = "Trajectories";

/// The layout of a table of Vicon, and how many rows are before its own; `None` for others.
pub(super) fn layout(lines: &Lines) -> Option<Result<(TableLayout, usize), TableFault>> {
    let all = lines.head.iter().chain(&lines.rows);
    { all }.any(is_axes).then(|| vicon(lines))
}

fn is_axes(line: &Line) -> bool {
    let cells = &line.cells;
    cells.len() > 2 && cells[0] == "Frame" && cells[1] == "Sub Frame"
}

/// Vicon: the section's name, its rate, names above the first of each one's columns, the axes, the units.
fn vicon(lines: &Lines) -> Result<(TableLayout, usize), TableFault> {
    let all: Vec<&Line> = lines.head.iter().chain(&lines.rows).collect();
    let is_section = |line: &&Line| SECTIONS.contains(&line.cells[0].as_str());
    let of_points = || all.iter().position(|line| line.cells[0] == POINTS);
    let Some(at) = all.iter().position(is_section).or_else(of_points) else {
        return fault(
            all[0].number,
            "no section Objects, Segments or Trajectories in this head of Vicon, expected one: export \
             objects (Tracker) or segments (Nexus)",
        );
    };
    let are_points = all[at].cells[0] == POINTS;
    let [rate, names, axes, ref rest @ ..] = all[at + 1..] else {
        return fault(
            all[at].number,
            "a section without rows, expected its rate, names, axes and units",
        );
    };
    let rate_hz = rate.cells.first().and_then(|cell| number(cell));
    let rate_hz = rate_hz.filter(|rate| *rate > 0.0);
    if rate_hz.is_none() || !is_axes(axes) {
        return fault(
            rate.number,
            "expected the section's rate in Hz, a line of names and one of Frame, Sub Frame, RX, …",
        );
    }
    let units = rest.first().filter(|line| number(&line.cells[0]).is_none());
    let unit = |column: usize| units.and_then(|line| line.cells.get(column)).cloned();
    let begins: Vec<usize> = (2..axes.cells.len())
        .filter(|column| {
            names
                .cells
                .get(*column)
                .is_some_and(|name| !name.is_empty())
        })
        .collect();
    let mut bodies = Vec::new();
    let mut length = None;
    for (index, begin) in begins.iter().enumerate() {
        let end = begins.get(index + 1).copied().unwrap_or(axes.cells.len());
        let find = |name: &str| (*begin..end).find(|column| axes.cells[*column] == name);
        let name = names.cells[*begin].clone();
        // `Cup:Cup`, subject and segment; `Global Angle Cup:Cup` where there are more.
        let name = match name.split_once(':') {
            Some((subject, segment)) if subject == segment => segment.to_owned(),
            _ => name,
        };
        let position = match are_points {
            true => [find("X"), find("Y"), find("Z")],
            false => [find("TX"), find("TY"), find("TZ")],
        };
        if let (true, [Some(x), Some(y), Some(z)]) = (are_points, position) {
            length = length.or_else(|| length_unit(&unit(x)?));
            bodies.push(BodyColumns {
                name: Some(name),
                position: [x, y, z],
                orientation: Orientation::Unseen,
                seen: Vec::new(),
            });
            continue;
        }
        let turn = [find("RX"), find("RY"), find("RZ")];
        let ([Some(x), Some(y), Some(z)], [Some(a), Some(b), Some(c)]) = (position, turn) else {
            return fault(
                axes.number,
                format!("{name:?} has not all of RX, RY, RZ and TX, TY, TZ"),
            );
        };
        length = length.or_else(|| length_unit(&unit(x)?));
        let orientation = match find("RW") {
            Some(w) => Orientation::Quaternion([a, b, c, w]),
            None => {
                let unit = unit(a).and_then(|unit| AngleUnit::of(&unit.to_lowercase()));
                let columns = [a, b, c];
                Orientation::Angles(Angles {
                    columns,
                    unit,
                    turn: None,
                })
            }
        };
        bodies.push(BodyColumns {
            name: Some(name),
            position: [x, y, z],
            orientation,
            seen: Vec::new(),
        });
    }
    if bodies.is_empty() {
        return fault(
            names.number,
            "no names above the columns, expected one per object",
        );
    }
    // Rows of the section, past the units.
    let begin = at + 4 + usize::from(units.is_some());
    let time = TimeColumns::One(0, Some(TimeUnit::Frame));
    let notes = match are_points {
        true => vec![points_are_taken("markers, no rigid bodies")],
        false => Vec::new(),
    };
    let layout = TableLayout {
        length,
        rate_hz,
        preset: Some("vicon"),
        is_order_named: true,
        notes,
        is_section: true,
        is_ragged: true,
        ..TableLayout::plain(format!("Vicon {}", all[at].cells[0]), time, bodies)
    };
    Ok((layout, begin.saturating_sub(lines.head.len())))
}
