//! A table's text becomes the samples of its bodies.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::{UnitQuaternion, Vector3};

use super::axes::Preset;
use super::head;
use super::layout::{
    AngleUnit, BodyColumns, Fault, Layout, Orientation, QuaternionOrder, TimeColumns, Turn, fault,
};
use super::text::{Line, Lines, is_absent, lines, number};
use super::time::{Clock, clock};
use super::units::TimeUnit;
use super::vendor;
use crate::ingest::error::IngestError;
use crate::motion::{Holds, LengthUnit, PoseSample, Stamp};

/// What a user says of a table; what is not said is read off its head, or guessed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TableOptions {
    /// Names of the columns, in order, parted by commas, in place of those in the file.
    pub columns: Option<String>,
    /// Unit of the times.
    pub time_unit: Option<TimeUnit>,
    /// Unit of the positions.
    pub length_unit: Option<LengthUnit>,
    /// Rows are so many a second, whatever their times say; frames are, where times count frames.
    pub rate_hz: Option<f64>,
    /// Order of the quaternion's numbers, where names do not say it.
    pub quaternion: Option<QuaternionOrder>,
    /// What three angles mean.
    pub turn: Option<Turn>,
    /// What is usual where it comes from.
    pub preset: Option<&'static Preset>,
}

/// What a table holds.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseTable {
    /// What wrote it, in words.
    pub kind: String,
    /// The preset by which its axes were turned.
    pub preset: &'static Preset,
    /// The unit of its positions.
    pub length: LengthUnit,
    /// Its bodies, in the order of their columns or first rows.
    pub bodies: Vec<BodyPoses>,
    /// What was guessed, and what was not read.
    pub notes: Vec<String>,
    /// What is lost.
    pub lost: Vec<String>,
}

/// The samples of a body, in file order: metres, z up.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyPoses {
    /// Its name in the file, if it has one there.
    pub name: Option<String>,
    /// Its readings.
    pub samples: Vec<PoseSample>,
    /// Rows in which it has no pose.
    pub absent: usize,
}

/// Reads the text of a table; `path` is its name in errors. Fails, with the line and what is wrong there,
/// where cells are no numbers or the columns of a pose are not found.
pub fn read_table(
    path: &Path,
    text: &str,
    options: &TableOptions,
) -> Result<PoseTable, IngestError> {
    read(text, options).map_err(|fault| IngestError::Table {
        path: path.to_owned(),
        line: fault.line,
        message: fault.message,
    })
}

fn read(text: &str, options: &TableOptions) -> Result<PoseTable, Fault> {
    let lines = lines(text)?;
    let (layout, begin) = layout(&lines, options)?;
    let mut notes = layout.notes.clone();
    let named = layout.bodies.first().filter(|_| layout.is_order_named);
    if let Some(order) = named.and_then(|body| body.orientation.order()) {
        notes.push(format!(
            "quaternions are {order}, as their columns are named"
        ));
    }
    if !layout.unread.is_empty() {
        let shown = layout.unread.len().min(8);
        let more = match layout.unread.len() - shown {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let named = layout.unread[..shown].join(", ");
        notes.push(format!("columns not read: {named}{more}"));
    }
    let preset = preset(&layout, options, &mut notes);
    let length = options
        .length_unit
        .or(layout.length)
        .unwrap_or(preset.length);
    let rows = section(
        &layout,
        &lines.rows[begin.min(lines.rows.len())..],
        &mut notes,
    );
    let unit = options.time_unit;
    let unit = unit.or(match layout.time {
        TimeColumns::One(_, None) => preset.time,
        _ => None,
    });
    let clock = clock(&layout, rows, unit, options.rate_hz, &mut notes)?;
    let reader = Reader {
        preset,
        per_metre: 1.0 / length.length_m(),
        turn: options.turn,
        clock,
    };
    let mut lost = Vec::new();
    let bodies = bodies(&layout, rows, &reader, lines.is_open, &mut lost)?;
    Ok(PoseTable {
        kind: format!("{}, {}", layout.kind, lines.separator.name()),
        preset,
        length,
        bodies,
        notes,
        lost,
    })
}

fn layout(lines: &Lines, options: &TableOptions) -> Result<(Layout, usize), Fault> {
    let of_preset = options.preset.and_then(|preset| preset.columns);
    let has_names = || lines.head.iter().any(|line| line.cells.len() >= 4);
    let given = options
        .columns
        .as_deref()
        .or(of_preset.filter(|_| !has_names()));
    let Some(given) = given else {
        return match vendor::layout(lines) {
            Some(found) => found,
            None => Ok((head::general(lines, options.quaternion)?, 0)),
        };
    };
    let mut names: Vec<String> = given
        .split(',')
        .map(|name| name.trim().to_owned())
        .collect();
    let count = lines.rows[0].cells.len();
    if names.len() > count {
        return fault(
            lines.rows[0].number,
            format!(
                "{count} columns, and {} names are given for them",
                names.len()
            ),
        );
    }
    names.resize(count, "-".to_owned());
    let layout = head::layout(0, &names, options.quaternion)?;
    let kind = "a table with columns as given".to_owned();
    Ok((Layout { kind, ..layout }, 0))
}

/// The preset that is asked for, or usual for what wrote the file.
fn preset(layout: &Layout, options: &TableOptions, notes: &mut Vec<String>) -> &'static Preset {
    if let Some(preset) = options.preset {
        return preset;
    }
    let usual = layout.preset.and_then(Preset::named);
    let preset = usual.unwrap_or(&super::axes::PRESETS[0]);
    if !preset.keeps_axes() {
        notes.push(format!(
            "axes are taken as in {} (--from for others)",
            preset.about
        ));
    }
    preset
}

/// The rows up to one that is of another section.
fn section<'l>(layout: &Layout, rows: &'l [Line], notes: &mut Vec<String>) -> &'l [Line] {
    let ends = |row: &Line| layout.is_section && number(&row.cells[0]).is_none();
    let Some(end) = rows.iter().position(ends) else {
        return rows;
    };
    notes.push(format!(
        "not read from line {} on: section {}",
        rows[end].number, rows[end].cells[0]
    ));
    &rows[..end]
}

struct Reader {
    preset: &'static Preset,
    per_metre: f64,
    turn: Option<Turn>,
    clock: Clock,
}

fn bodies(
    layout: &Layout,
    rows: &[Line],
    reader: &Reader,
    is_open: bool,
    lost: &mut Vec<String>,
) -> Result<Vec<BodyPoses>, Fault> {
    let mut bodies: Vec<BodyPoses> = Vec::new();
    let mut of_name: BTreeMap<Option<String>, usize> = BTreeMap::new();
    for (index, row) in rows.iter().enumerate() {
        for columns in &layout.bodies {
            let name = match layout.body_name {
                Some(column) => row.cells.get(column).cloned(),
                None => columns.name.clone(),
            };
            let at = *of_name.entry(name.clone()).or_insert_with(|| {
                bodies.push(BodyPoses {
                    name,
                    samples: Vec::new(),
                    absent: 0,
                });
                bodies.len() - 1
            });
            let body = &mut bodies[at];
            // Rows of several bodies in turn are counted for each.
            let place = match layout.body_name {
                Some(_) => body.samples.len() + body.absent,
                None => index,
            };
            match reader.sample(columns, row, place) {
                Ok(Some(sample)) => body.samples.push(sample),
                Ok(None) => body.absent += 1,
                Err(_) if is_open && index + 1 == rows.len() => {
                    lost.push(format!("line {}: the last, which is cut off", row.number));
                }
                Err(fault) => return Err(fault),
            }
        }
    }
    if bodies.iter().all(|body| body.samples.is_empty()) {
        return fault(
            rows.first().map_or(0, |row| row.number),
            "no row with a pose, expected some",
        );
    }
    Ok(bodies)
}

impl Reader {
    /// The sample of a body in a row; `None` where cells of its pose are empty.
    fn sample(
        &self,
        columns: &BodyColumns,
        row: &Line,
        place: usize,
    ) -> Result<Option<PoseSample>, Fault> {
        let Some(position) = numbers(row, &columns.position)? else {
            return Ok(None);
        };
        let position_m = self.preset.vector(position).map(|of| of / self.per_metre);
        let position_m = Vector3::from(position_m);
        let quaternion = match &columns.orientation {
            Orientation::Unseen => {
                let stamp = Stamp(self.clock.of(row, place)?);
                let sample = PoseSample::new(stamp, position_m, [f64::NAN; 4]);
                let holds = Holds::Position;
                return Ok(Some(PoseSample { holds, ..sample }));
            }
            Orientation::Quaternion(columns) => numbers(row, columns)?,
            Orientation::Angles(columns, unit) => match numbers(row, columns)? {
                Some(angles) => Some(self.quaternion(angles, *unit, row.number)?),
                None => None,
            },
        };
        let Some(quaternion) = quaternion else {
            return Ok(None);
        };
        let stamp = Stamp(self.clock.of(row, place)?);
        Ok(Some(PoseSample::new(
            stamp,
            position_m,
            self.preset.quaternion(quaternion),
        )))
    }

    fn quaternion(
        &self,
        angles: [f64; 3],
        unit: AngleUnit,
        line: usize,
    ) -> Result<[f64; 4], Fault> {
        let [x, y, z] = match unit {
            AngleUnit::Radian => angles,
            AngleUnit::Degree => angles.map(f64::to_radians),
        };
        let about = |axis: Vector3<f64>| UnitQuaternion::from_scaled_axis(axis);
        let turned = match self.turn {
            Some(Turn::Vector) => about(Vector3::new(x, y, z)),
            Some(Turn::EulerXyz) => {
                about(Vector3::x() * x) * about(Vector3::y() * y) * about(Vector3::z() * z)
            }
            None => {
                return fault(
                    line,
                    "orientations are three angles, expected --rotation vector or --rotation euler-xyz: \
                     the file does not say which; or export quaternions",
                );
            }
        };
        Ok([turned.i, turned.j, turned.k, turned.w])
    }
}

/// The numbers of a row in these columns; `None` where one of them is empty.
fn numbers<const N: usize>(row: &Line, columns: &[usize; N]) -> Result<Option<[f64; N]>, Fault> {
    let mut found = [0.0; N];
    let most = columns.iter().max().map_or(0, |column| column + 1);
    let mut is_whole = true;
    for (to, column) in found.iter_mut().zip(columns) {
        match row.cells.get(*column) {
            // Programs leave out what is empty at the end of a line, but not all of it.
            None if row.cells.len() <= 2 => is_whole = false,
            None => {
                return fault(
                    row.number,
                    format!("{} cells, expected {most} or more", row.cells.len()),
                );
            }
            Some(cell) if is_absent(cell) => is_whole = false,
            Some(cell) => match number(cell) {
                Some(number) => *to = number,
                None => {
                    return fault(
                        row.number,
                        format!("column {}: {cell:?} is no number", column + 1),
                    );
                }
            },
        }
    }
    Ok(is_whole.then_some(found))
}
