//! A row becomes the sample of a body.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::axes::Preset;
use super::layout::{
    Angles, BodyColumns, Orientation, SeenColumn, TableFault, TableLayout, fault, shown,
};
use super::missing::{Unseen, absence, is_sentinel, stray_zeros};
use super::order::{Days, RowTime, order};
use super::poses::{BodyPoses, TableOptions};
use super::said::Said;
use super::text::{Line, number};
use super::time::Clock;
use super::turn::{Turn, quaternion_of_matrix};
use super::units::AngleUnit;
use crate::motion::{Holds, PoseSample, Stamp};

/// A step of an angle that is a full turn, as a share of one.
const WRAP_SHARE: f64 = 0.85;
/// Unwrapped angles of more radians are none that a hand or a throw turns.
const RADIANS_MAX: f64 = 60.0;
/// Angles that reach so far and change so much are radians: as degrees they would hardly move.
const RADIANS_MIN: f64 = 1.5;
/// Rounding of π.
const NEAR_TURN: f64 = 0.01;
/// A share of matrices that are no rotations, and still are some.
const NO_ROTATION_SHARE: f64 = 0.1;

/// How rows are read.
pub(super) struct Reader {
    pub(super) preset: &'static Preset,
    pub(super) per_metre: f64,
    pub(super) turn: Option<&'static Turn>,
    pub(super) angle_unit: AngleUnit,
    pub(super) clock: Clock,
    pub(super) is_ragged: bool,
    pub(super) is_zero_unseen: bool,
}

/// What a row holds of a body.
enum CellReading {
    Sample(PoseSample),
    Unseen(Unseen),
}

/// The samples of a body while they are read.
#[derive(Default)]
struct SampledRows {
    body: BodyPoses,
    times: Vec<RowTime>,
    days: Days,
}

/// The samples of all bodies. Fails where a cell is no number, and where no row has a pose.
pub(super) fn bodies(
    layout: &TableLayout,
    rows: &[Line],
    reader: &Reader,
    is_open: bool,
    lost: &mut Vec<String>,
) -> Result<Vec<BodyPoses>, TableFault> {
    let mut all: Vec<SampledRows> = Vec::new();
    let mut of_name: BTreeMap<Option<String>, usize> = BTreeMap::new();
    for (index, row) in rows.iter().enumerate() {
        for (column, columns) in layout.bodies.iter().enumerate() {
            let at = match layout.body_name {
                Some(name) => {
                    let name = row.cells.get(name).cloned();
                    let next = all.len();
                    *of_name.entry(name).or_insert(next)
                }
                None => column,
            };
            if at == all.len() {
                let name = match layout.body_name {
                    Some(name) => row.cells.get(name).cloned(),
                    None => columns.name.clone(),
                };
                all.push(SampledRows::default());
                all[at].body.name = name;
            }
            let of_body = &mut all[at];
            // Rows of several bodies in turn are counted for each.
            let place = match layout.body_name {
                Some(_) => of_body.body.samples.len() + of_body.body.unseen.count(),
                None => index,
            };
            match reader.read(columns, row, place) {
                Ok(CellReading::Sample(sample)) => {
                    of_body.add(sample, row.number, reader.clock.wraps())
                }
                Ok(CellReading::Unseen(why)) => of_body.body.unseen.add(why),
                Err(_) if is_open && index + 1 == rows.len() => {
                    lost.push(format!("line {}: the last, which is cut off", row.number));
                }
                Err(fault) => return Err(fault),
            }
        }
    }
    lost.dedup();
    let bodies: Vec<BodyPoses> = all
        .into_iter()
        .map(|of| of.finished(&layout.other_times))
        .collect();
    if bodies.iter().all(|body| body.samples.is_empty()) {
        let why = bodies.iter().find_map(|body| body.unseen.words());
        return fault(
            rows.first().map_or(0, |row| row.number),
            format!(
                "no row with a pose, expected some{}: --columns says which columns are read",
                why.map_or(String::new(), |why| format!(
                    "; of these rows there are {why}"
                ))
            ),
        );
    }
    Ok(bodies)
}

impl SampledRows {
    fn add(&mut self, mut sample: PoseSample, line: usize, wraps: bool) {
        sample.stamp.0 = self.days.of(sample.stamp.0, wraps);
        self.times.push(RowTime {
            line,
            ns: sample.stamp.0,
        });
        self.body.samples.push(sample);
    }

    /// The body, with what its rows tell together.
    fn finished(mut self, other_times: &[String]) -> BodyPoses {
        let stray = stray_zeros(&self.body.samples);
        let mut is_stray = stray.iter();
        let body = &mut self.body;
        body.samples
            .retain(|_| !is_stray.next().copied().unwrap_or(false));
        for _ in stray.iter().filter(|stray| **stray) {
            body.unseen.add(Unseen::Zeros);
        }
        if let Some(off) = normalise(&mut body.samples) {
            body.notes.push(format!(
                "norms of quaternions are up to {off:.3} off 1: they are made 1"
            ));
        }
        let order = order(&self.times, other_times);
        body.notes.extend(order.notes);
        body.against.extend(order.against);
        if let Some(why) = body.unseen.words() {
            body.notes.push(format!("rows without a pose: {why}"));
        }
        let no_rotation = body.unseen.count_of(Unseen::NoRotation);
        if no_rotation as f64 > NO_ROTATION_SHARE * (no_rotation + body.samples.len()) as f64 {
            body.against.push(format!(
                "{no_rotation} matrices are no rotations: are their columns others? Expected r11, r12, r13, r21, … row by \
                 row in --columns"
            ));
        }
        let is_at_origin = |sample: &PoseSample| sample.position_m.iter().all(|of| *of == 0.0);
        if body.samples.len() > 1 && body.samples.iter().all(is_at_origin) {
            body.against.push(
                "all positions are 0: expected a position in three columns, with their names in --columns".to_owned(),
            );
        }
        self.body
    }
}

impl Reader {
    /// What a row holds of a body.
    fn read(
        &self,
        columns: &BodyColumns,
        row: &Line,
        place: usize,
    ) -> Result<CellReading, TableFault> {
        if let Some(why) = columns.seen.iter().find_map(|column| unseen(*column, row)) {
            return Ok(CellReading::Unseen(why));
        }
        let position = match self.numbers(row, &columns.position)? {
            Ok(position) => position,
            Err(why) => return Ok(CellReading::Unseen(why)),
        };
        if is_sentinel(position) {
            return Ok(CellReading::Unseen(Unseen::Sentinel));
        }
        if self.is_zero_unseen && position == [0.0; 3] {
            return Ok(CellReading::Unseen(Unseen::Zeros));
        }
        let position_m = self.preset.vector(position).map(|of| of / self.per_metre);
        let position_m = Vector3::from(position_m);
        let quaternion = match &columns.orientation {
            Orientation::Unseen => {
                let stamp = Stamp(self.clock.of(row, place)?);
                let sample = PoseSample::new(stamp, position_m, [f64::NAN; 4]);
                let holds = Holds::Position;
                return Ok(CellReading::Sample(PoseSample { holds, ..sample }));
            }
            Orientation::Quaternion(columns) => self.numbers(row, columns)?,
            Orientation::Matrix(columns) => self
                .numbers(row, columns)?
                .and_then(|rows| quaternion_of_matrix(&rows).ok_or(Unseen::NoRotation)),
            Orientation::Angles(angles) => match self.numbers(row, &angles.columns)? {
                Ok(numbers) => Ok(self.quaternion(numbers, angles, row.number)?),
                Err(why) => Err(why),
            },
        };
        let quaternion = match quaternion {
            // Of no orientation at all.
            Ok(parts) if parts == [0.0; 4] => return Ok(CellReading::Unseen(Unseen::Zeros)),
            Ok(parts) => parts,
            Err(why) => return Ok(CellReading::Unseen(why)),
        };
        let stamp = Stamp(self.clock.of(row, place)?);
        let quaternion = self.preset.quaternion(quaternion);
        Ok(CellReading::Sample(PoseSample::new(
            stamp, position_m, quaternion,
        )))
    }

    fn quaternion(
        &self,
        numbers: [f64; 3],
        angles: &Angles,
        line: usize,
    ) -> Result<[f64; 4], TableFault> {
        let Some(turn) = self.turn.or(angles.turn) else {
            return fault(
                line,
                format!(
                    "orientations are three angles, expected --rotation with what they mean, one of {}: the file does not \
                     say it; or export quaternions",
                    Turn::names()
                ),
            );
        };
        let numbers = match angles.unit.unwrap_or(self.angle_unit) {
            AngleUnit::Radian => numbers,
            AngleUnit::Degree => numbers.map(f64::to_radians),
        };
        Ok(turn.quaternion(numbers))
    }

    /// The numbers of a row in these columns, or why there are none.
    fn numbers<const N: usize>(
        &self,
        row: &Line,
        columns: &[usize; N],
    ) -> Result<Result<[f64; N], Unseen>, TableFault> {
        let mut found = [0.0; N];
        let most = columns.iter().max().map_or(0, |column| column + 1);
        let mut absent = None;
        for (to, column) in found.iter_mut().zip(columns) {
            match row.cells.get(*column) {
                // Programs leave out what is empty at the end of a line, but not all of it.
                None if self.is_ragged || row.cells.len() <= 2 => absent = Some(Unseen::Empty),
                None => {
                    return fault(
                        row.number,
                        format!(
                            "{} cells, expected {most} or more; leave the row out, or part the file there",
                            row.cells.len()
                        ),
                    );
                }
                Some(cell) => match (absence(cell), number(cell)) {
                    (Some(why), _) => absent = Some(why),
                    (None, Some(number)) => *to = number,
                    (None, None) => {
                        return fault(
                            row.number,
                            format!(
                                "column {}: {} is no number, expected one, or nothing where nothing was seen",
                                column + 1,
                                shown(cell)
                            ),
                        );
                    }
                },
            }
        }
        Ok(absent.map_or(Ok(found), Err))
    }
}

/// Whether a column says that a row was not seen.
fn unseen(column: SeenColumn, row: &Line) -> Option<Unseen> {
    let cell = |at: usize| row.cells.get(at).map(|cell| cell.to_ascii_lowercase());
    let is_no = |cell: &str| matches!(cell, "false" | "no" | "f") || number(cell) == Some(0.0);
    let is_yes = |cell: &str| {
        matches!(cell, "true" | "yes" | "t") || number(cell).is_some_and(|of| of != 0.0)
    };
    match column {
        SeenColumn::Tracked(at) => is_no(&cell(at)?).then_some(Unseen::Flag),
        SeenColumn::Lost(at) => is_yes(&cell(at)?).then_some(Unseen::Flag),
        SeenColumn::Residual(at) => (number(&cell(at)?)? < 0.0).then_some(Unseen::Residual),
    }
}

/// The unit of angles that is said, stated, or that their values support; says which, and why, with what they mean.
pub(super) fn angle_unit(
    layout: &TableLayout,
    rows: &[Line],
    options: &TableOptions,
    preset: &Preset,
    said: &mut Said,
) -> AngleUnit {
    let mut of_bodies = layout
        .bodies
        .iter()
        .filter_map(|body| match body.orientation {
            Orientation::Angles(angles) => Some(angles),
            _ => None,
        });
    let Some(first) = of_bodies.next() else {
        return AngleUnit::Radian;
    };
    if let Some(turn) = options.turn.or(first.turn) {
        let is_stated = options.turn.is_none() && layout.preset.is_some();
        said.angles(turn, options.turn.is_some(), is_stated, preset);
    }
    if let Some(unit) = options.angle_unit {
        said.angle_unit(unit, "as --angle-unit says");
        return unit;
    }
    if let Some(unit) = first.unit {
        said.angle_unit(unit, "as the file says");
        return unit;
    }
    let of_columns = [first]
        .into_iter()
        .chain(of_bodies)
        .flat_map(|of| of.columns);
    let mut greatest = 0.0_f64;
    let mut step_most = 0.0_f64;
    let mut range_most = 0.0_f64;
    for column in of_columns {
        let values = rows.iter().filter_map(|row| row.cells.get(column));
        let values: Vec<f64> = values.filter_map(|cell| number(cell)).collect();
        let (least, most) = values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), of| {
                (a.min(*of), b.max(*of))
            });
        greatest = greatest.max(least.abs()).max(most.abs());
        range_most = range_most.max(most - least);
        let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        step_most = steps.fold(step_most, f64::max);
    }
    let turn_rad = std::f64::consts::TAU;
    let untold = "nothing tells the unit of angles: expected --angle-unit deg or --angle-unit rad";
    if greatest > turn_rad + NEAR_TURN {
        said.angle_unit(
            AngleUnit::Degree,
            &format!("as {greatest:.1} is no angle in radians (--angle-unit for others)"),
        );
        // Angles that nobody wrapped may be of several turns.
        if greatest <= RADIANS_MAX && step_most < WRAP_SHARE * 360.0 {
            said.against(untold);
        }
        return AngleUnit::Degree;
    }
    let wraps = (WRAP_SHARE * turn_rad..=turn_rad + NEAR_TURN).contains(&step_most);
    let reaches = greatest > RADIANS_MIN && range_most > RADIANS_MIN;
    said.angle_unit(
        AngleUnit::Radian,
        &format!("as the greatest is {greatest:.3} (--angle-unit for others)"),
    );
    if !wraps && !reaches {
        said.against(untold);
    }
    AngleUnit::Radian
}

/// Greatest deviation of a norm from 1 that rounding explains,
const NORM_ROUNDED: f64 = 0.01;
/// and with which a quaternion is one, and not of other columns.
const NORM_OFF: f64 = 0.1;

/// Makes quaternions of norm 1 of those that are near it, and returns the greatest deviation; `None` where rounding
/// explains it, or where some are far from it.
fn normalise(samples: &mut [PoseSample]) -> Option<f64> {
    let norm = |sample: &PoseSample| {
        sample
            .quaternion_xyzw
            .iter()
            .map(|part| part * part)
            .sum::<f64>()
            .sqrt()
    };
    let off = |sample: &PoseSample| (norm(sample) - 1.0).abs();
    let of_poses = || samples.iter().filter(|sample| sample.holds == Holds::Pose);
    let most = of_poses().map(off).fold(0.0, f64::max);
    if !(NORM_ROUNDED..=NORM_OFF).contains(&most)
        || of_poses().any(|sample| !norm(sample).is_finite())
    {
        return None;
    }
    for sample in samples
        .iter_mut()
        .filter(|sample| sample.holds == Holds::Pose)
    {
        let norm = norm(sample);
        sample.quaternion_xyzw = sample.quaternion_xyzw.map(|part| part / norm);
    }
    Some(most)
}
