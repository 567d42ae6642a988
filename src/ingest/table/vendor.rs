//! Heads of tables by OptiTrack's Motive and by Vicon's Tracker and Nexus.

use super::layout::{
    AngleUnit, BodyColumns, Fault, Layout, Orientation, TimeColumns, fault, points_are_taken,
};
use super::text::{Line, Lines, number};
use super::units::{TimeUnit, length_unit};

/// Sections of Vicon's files that have poses,
const SECTIONS: [&str; 2] = ["Objects", "Segments"];
/// and that which has points.
const POINTS: &str = "Trajectories";

/// The layout that a vendor's head gives, and how many rows are before its own; `None` for other heads.
pub(super) fn layout(lines: &Lines) -> Option<Result<(Layout, usize), Fault>> {
    let first = lines.head.first()?;
    if first
        .cells
        .first()
        .is_some_and(|cell| cell == "Format Version")
    {
        return Some(motive(lines).map(|layout| (layout, 0)));
    }
    let is_axes = |line: &Line| {
        let cells = &line.cells;
        cells.len() > 2 && cells[0] == "Frame" && cells[1] == "Sub Frame"
    };
    if !lines.head.iter().any(is_axes) {
        return None;
    }
    Some(vicon(lines, is_axes))
}

/// Columns of a rigid body of Motive, as far as they are found.
struct RigidBody {
    name: String,
    position: [Option<usize>; 3],
    rotation: [Option<usize>; 4],
}

/// Motive: a line of keys and values; then, above the columns, what they are of, whose, an identifier,
/// perhaps a parent, rotation or position, and the axis.
fn motive(lines: &Lines) -> Result<Layout, Fault> {
    let first = &lines.head[0];
    let said = |key: &str| {
        let at = first.cells.iter().position(|cell| cell == key)?;
        first.cells.get(at + 1).map(String::as_str)
    };
    let head = &lines.head[1..];
    let find = |is_it: &dyn Fn(&Line) -> bool| head.iter().position(is_it);
    let row_of = |what: &str| find(&|line| line.cells.iter().any(|cell| cell == what));
    let wanted = ["Rigid Body", "Marker"];
    let kind = wanted.into_iter().find(|kind| row_of(kind).is_some());
    let are_points = kind == Some("Marker");
    let turn = said("Rotation Type").filter(|_| !are_points);
    if let Some(turn) = turn.filter(|turn| *turn != "Quaternion") {
        return fault(
            first.number,
            format!(
                "Rotation Type is {turn}, expected Quaternion: export it again with that rotation type"
            ),
        );
    }
    let parts = row_of(if are_points { "Position" } else { "Rotation" });
    let (Some(kind), Some(kinds), Some(parts)) = (kind, kind.and_then(row_of), parts) else {
        return fault(
            head.last().map_or(first.number, |line| line.number),
            "no rigid bodies with rotations and no markers in this head of Motive, expected some: export it \
             again with Rigid Bodies",
        );
    };
    let Some(axes) = head.get(parts + 1) else {
        return fault(
            head[parts].number,
            "no line of axes after this one, expected Frame, Time (Seconds), X, Y, Z, W, …",
        );
    };
    let cell = |line: &Line, column: usize| line.cells.get(column).cloned().unwrap_or_default();
    let mut bodies: Vec<RigidBody> = Vec::new();
    let mut others = 0;
    for column in 2..axes.cells.len() {
        let part = cell(&head[parts], column);
        if cell(&head[kinds], column) != kind {
            others += usize::from(!part.is_empty());
            continue;
        }
        let name = head
            .get(kinds + 1)
            .map_or(String::new(), |line| cell(line, column));
        if bodies.last().is_none_or(|last| last.name != name) {
            bodies.push(RigidBody {
                name,
                position: [None; 3],
                rotation: [None; 4],
            });
        }
        let Some(body) = bodies.last_mut() else {
            continue;
        };
        let axis = "XYZW".find(cell(axes, column).as_str());
        match (part.as_str(), axis) {
            ("Rotation", Some(axis)) if axis < 4 => body.rotation[axis] = Some(column),
            ("Position", Some(axis)) if axis < 3 => body.position[axis] = Some(column),
            _ => others += 1,
        }
    }
    let columns = bodies.into_iter().map(|body| {
        let (name, all) = (body.name, (body.position, body.rotation));
        let (position, orientation) = match all {
            ([Some(x), Some(y), Some(z)], [Some(a), Some(b), Some(c), Some(d)]) => {
                ([x, y, z], Orientation::Quaternion([a, b, c, d]))
            }
            ([Some(x), Some(y), Some(z)], _) if are_points => ([x, y, z], Orientation::Unseen),
            _ => {
                return fault(
                    axes.number,
                    format!(
                        "{name:?} has not all of X, Y, Z, W of a rotation and X, Y, Z of a position"
                    ),
                );
            }
        };
        Ok(BodyColumns {
            name: Some(name),
            position,
            orientation,
        })
    });
    let length = match said("Length Units") {
        None => None,
        Some(named) => match length_unit(&named.to_lowercase()) {
            Some(unit) => Some(unit),
            None => {
                return fault(
                    first.number,
                    format!("Length Units is {named}, expected Meters, Centimeters or Millimeters"),
                );
            }
        },
    };
    let mut notes: Vec<String> = are_points.then(points_note).into_iter().collect();
    if said("Coordinate Space").is_some_and(|space| space != "Global") {
        notes.push(
            "Coordinate Space is not Global: poses may be relative to another body".to_owned(),
        );
    }
    Ok(Layout {
        kind: format!("Motive {}", said("Format Version").unwrap_or_default()),
        time: TimeColumns::One(1, Some(TimeUnit::Second)),
        bodies: columns.collect::<Result<_, _>>()?,
        body_name: None,
        length,
        rate_hz: said("Export Frame Rate").and_then(number),
        preset: Some("motive-y-up"),
        unread: unread(others),
        is_order_named: true,
        notes,
        is_section: false,
    })
}

fn points_note() -> String {
    points_are_taken("markers, no rigid bodies")
}

fn unread(others: usize) -> Vec<String> {
    if others == 0 {
        return Vec::new();
    }
    vec![format!("{others} of markers, errors and the like")]
}

/// Vicon: the section's name, its rate, names above the first of each one's columns, the axes, the units.
fn vicon(lines: &Lines, is_axes: impl Fn(&Line) -> bool) -> Result<(Layout, usize), Fault> {
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
                let is_degree = unit(a).is_some_and(|unit| unit.starts_with("deg"));
                let unit = if is_degree {
                    AngleUnit::Degree
                } else {
                    AngleUnit::Radian
                };
                Orientation::Angles([a, b, c], unit)
            }
        };
        bodies.push(BodyColumns {
            name: Some(name),
            position: [x, y, z],
            orientation,
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
    let layout = Layout {
        kind: format!("Vicon {}", all[at].cells[0]),
        time: TimeColumns::One(0, Some(TimeUnit::Frame)),
        bodies,
        body_name: None,
        length,
        rate_hz,
        preset: Some("vicon"),
        unread: Vec::new(),
        is_order_named: true,
        notes: are_points.then(points_note).into_iter().collect(),
        is_section: true,
    };
    Ok((layout, begin.saturating_sub(lines.head.len())))
}
