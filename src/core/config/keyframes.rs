//! Written sketches: keyframes and marks as rows of a CSV file, or as tables of a TOML file.
//!
//! Both become [`WrittenKeyframes`] rows with the place of every value; one set of checks makes rows of the
//! scene of them. `docs/sketch.md` describes the formats.

mod csv;
mod tables;

#[cfg(test)]
pub(super) use self::tables::RawFile;

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::{UnitQuaternion, Vector3};

use super::error::{Fault, SceneError, fault};
use super::keys::nearest;
use crate::motion::{Keyframe, KeyframeTime, Mark, Scene, SketchRow, Stamp, Timing, TrackIndex};

/// Latest time \[s\]: longer takes are refused later.
const TIME_MAX_S: f64 = 86_400.0;
/// Greatest deviation of a quaternion's norm from 1: of numbers that were rounded to two digits.
const NORM_LIMIT: f64 = 0.02;

/// A value with its place in the text.
#[derive(Clone, Debug)]
struct PlacedKeyframe<T> {
    value: T,
    span: Range<usize>,
}

/// One row as it is written. Times in seconds, positions in metres.
#[derive(Clone, Debug, Default)]
struct WrittenKeyframes {
    span: Range<usize>,
    body: Option<PlacedKeyframe<String>>,
    flight: Option<PlacedKeyframe<f64>>,
    event: Option<PlacedKeyframe<String>>,
    time_s: Option<PlacedKeyframe<f64>>,
    earliest_s: Option<PlacedKeyframe<f64>>,
    latest_s: Option<PlacedKeyframe<f64>>,
    position_m: [Option<PlacedKeyframe<f64>>; 3],
    orientation_wxyz: [Option<PlacedKeyframe<f64>>; 4],
    rpy_deg: [Option<PlacedKeyframe<f64>>; 3],
    position_sd_m: Option<PlacedKeyframe<f64>>,
    orientation_sd_deg: Option<PlacedKeyframe<f64>>,
}

/// The rows of a CSV file.
pub fn sketch_from_csv(text: &str, scene: &Scene) -> Result<Vec<SketchRow>, SceneError> {
    let rows = self::csv::rows(text).and_then(|rows| checked(rows, scene));
    rows.map_err(|fault| SceneError::from_fault(text, fault))
}

/// The rows of a TOML file: its `[[keyframe]]` and `[[mark]]`, as they are written.
pub fn sketch_from_toml(text: &str, scene: &Scene) -> Result<Vec<SketchRow>, SceneError> {
    let rows = tables::rows(text)?;
    checked(rows, scene).map_err(|fault| SceneError::from_fault(text, fault))
}

fn checked(rows: Vec<WrittenKeyframes>, scene: &Scene) -> Result<Vec<SketchRow>, Fault> {
    if rows.is_empty() {
        return fault(0..0, "no keyframes, expected one row or table for each");
    }
    let mut last: BTreeMap<(TrackIndex, usize), Stamp> = BTreeMap::new();
    let mut marked: Vec<String> = Vec::new();
    rows.iter()
        .map(|row| {
            if let Some(event) = &row.event {
                return mark(row, event, scene, &mut marked);
            }
            let (track, flight) = (track(row, scene)?, 0);
            let flight = self::flight(row, scene, track)?.unwrap_or(flight);
            let keyframe = keyframe(row)?;
            if let KeyframeTime::Known(stamp) = keyframe.time {
                let known = last.insert((track, flight), stamp);
                if known.is_some_and(|known| known >= stamp) {
                    let span = row
                        .time_s
                        .as_ref()
                        .map_or(row.span.clone(), |t| t.span.clone());
                    return fault(
                        span,
                        "not later than the keyframe before it of this body, expected rows in \
                         order of time",
                    );
                }
            }
            Ok(SketchRow::Keyframe {
                track,
                flight,
                keyframe,
            })
        })
        .collect()
}

fn mark(
    row: &WrittenKeyframes,
    event: &PlacedKeyframe<String>,
    scene: &Scene,
    marked: &mut Vec<String>,
) -> Result<SketchRow, Fault> {
    let names: Vec<&str> = scene
        .events
        .iter()
        .map(|event| event.name.as_str())
        .collect();
    let name = event.value.as_str();
    if !scene.has_event_named(name) {
        return unknown("event", event, &names);
    }
    if scene.timing == Timing::Edited {
        return fault(
            event.span.clone(),
            "an edited sketch has no marks: its flights are parted by column `flight`; leave the \
             row out",
        );
    }
    if marked.iter().any(|known| known == name) {
        return fault(
            event.span.clone(),
            format!("a second mark of {name:?}, expected one"),
        );
    }
    let places = row.position_m.iter().chain(&row.orientation_wxyz);
    let places = places.chain(&row.rpy_deg);
    let more = places.flatten().map(|placed| &placed.span).next();
    let more = more.or(row.flight.as_ref().map(|placed| &placed.span));
    if let Some(span) = more {
        return fault(
            span.clone(),
            "the row of an event has no pose, expected one row for the event and one for the \
             keyframe",
        );
    }
    marked.push(name.to_owned());
    match time(row)? {
        KeyframeTime::Known(stamp) => Ok(SketchRow::Mark(Mark {
            stamp,
            event: Some(name.to_owned()),
        })),
        _ => fault(
            event.span.clone(),
            format!("event {name:?} has no time, expected `t`"),
        ),
    }
}

fn unknown<T>(what: &str, name: &PlacedKeyframe<String>, names: &[&str]) -> Result<T, Fault> {
    let hint = nearest(&name.value, names)
        .map_or(String::new(), |near| format!(", did you mean {near:?}?"));
    fault(
        name.span.clone(),
        format!(
            "unknown {what} {:?}{hint} The scene has {}",
            name.value,
            names.join(", ")
        ),
    )
}

fn track(row: &WrittenKeyframes, scene: &Scene) -> Result<TrackIndex, Fault> {
    let names: Vec<&str> = scene
        .tracks
        .keys()
        .map(|track| scene.link_seen_by(track).name.as_str())
        .collect();
    let Some(body) = &row.body else {
        return match names.as_slice() {
            [_] => Ok(TrackIndex(0)),
            _ => fault(
                row.span.clone(),
                format!("no body, expected one of {}", names.join(", ")),
            ),
        };
    };
    match names.iter().position(|name| *name == body.value) {
        Some(track) => Ok(TrackIndex(track)),
        None => unknown("body", body, &names),
    }
}

fn flight(
    row: &WrittenKeyframes,
    scene: &Scene,
    track: TrackIndex,
) -> Result<Option<usize>, Fault> {
    let flights = scene.streams(track);
    match (&row.flight, scene.timing) {
        (None, Timing::Edited) => fault(
            row.span.clone(),
            format!("no `flight`, expected 1 to {flights}: the scene's stamps are edited"),
        ),
        (None, _) => Ok(None),
        (Some(flight), Timing::Edited) => {
            let number = flight.value;
            let is_one = number.fract() == 0.0 && number >= 1.0 && number <= flights as f64;
            if is_one {
                return Ok(Some(number as usize - 1));
            }
            let name = &scene.link_seen_by(track).name;
            fault(
                flight.span.clone(),
                format!("flight {number} of {name:?}, expected 1 to {flights}"),
            )
        }
        (Some(flight), _) => fault(
            flight.span.clone(),
            "a flight's number, expected none: the scene's stamps are not edited, and marks part \
             the flights",
        ),
    }
}

fn keyframe(row: &WrittenKeyframes) -> Result<Keyframe, Fault> {
    let position_m = whole(row, &row.position_m, "x, y and z")?;
    let orientation_wxyz = orientation(row)?;
    if position_m.is_none() && orientation_wxyz.is_none() {
        return fault(
            row.span.clone(),
            "neither position nor orientation, expected x, y and z, or qw, qx, qy and qz (or roll_deg, pitch_deg and yaw_deg), \
             or both",
        );
    }
    let sd = |placed: &Option<PlacedKeyframe<f64>>| match placed {
        Some(placed) if placed.value <= 0.0 => fault(
            placed.span.clone(),
            format!(
                "a standard deviation of {}, expected a positive number",
                placed.value
            ),
        ),
        placed => Ok(placed.as_ref().map(|placed| placed.value)),
    };
    Ok(Keyframe {
        time: time(row)?,
        position_m: position_m.map(Vector3::from),
        orientation_wxyz,
        position_sd_m: sd(&row.position_sd_m)?,
        orientation_sd_deg: sd(&row.orientation_sd_deg)?,
    })
}

/// The orientation of a row, of a quaternion or of roll, pitch and yaw, `Rz·Ry·Rx`; `None` where it has none.
fn orientation(row: &WrittenKeyframes) -> Result<Option<[f64; 4]>, Fault> {
    let quaternion = whole(row, &row.orientation_wxyz, "qw, qx, qy and qz")?;
    let angles_deg = whole(row, &row.rpy_deg, "roll_deg, pitch_deg and yaw_deg")?;
    let Some(components) = quaternion else {
        return Ok(angles_deg.map(|angles_deg| {
            let [roll, pitch, yaw] = angles_deg.map(f64::to_radians);
            let turned = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
            [turned.w, turned.i, turned.j, turned.k]
        }));
    };
    if let (Some(_), Some(angle)) = (angles_deg, &row.rpy_deg[0]) {
        return fault(
            angle.span.clone(),
            "the orientation is given twice, expected a quaternion or roll, pitch and yaw",
        );
    }
    let norm = components.iter().map(|c| c * c).sum::<f64>().sqrt();
    let span = row.orientation_wxyz[0]
        .as_ref()
        .map_or(row.span.clone(), |w| w.span.clone());
    if (norm - 1.0).abs() > NORM_LIMIT {
        return fault(
            span,
            format!(
                "a quaternion of norm {norm:.3}, expected 1: is one component wrong? roll_deg, pitch_deg and yaw_deg take \
                 degrees"
            ),
        );
    }
    Ok(Some(components))
}

/// All of some values, or none.
fn whole<const N: usize>(
    row: &WrittenKeyframes,
    values: &[Option<PlacedKeyframe<f64>>; N],
    names: &str,
) -> Result<Option<[f64; N]>, Fault> {
    let mut all = [0.0; N];
    let mut count = 0;
    for (to, value) in all.iter_mut().zip(values) {
        if let Some(value) = value {
            *to = value.value;
            count += 1;
        }
    }
    match count {
        0 => Ok(None),
        _ if count == N => Ok(Some(all)),
        _ => {
            let first = values.iter().flatten().next();
            let span = first.map_or(row.span.clone(), |first| first.span.clone());
            fault(
                span,
                format!("{count} of {N} numbers, expected {names}, or none of them"),
            )
        }
    }
}

fn time(row: &WrittenKeyframes) -> Result<KeyframeTime, Fault> {
    let stamp = |placed: &PlacedKeyframe<f64>| {
        if (0.0..=TIME_MAX_S).contains(&placed.value) {
            Ok(Stamp((placed.value * 1e9).round() as i64))
        } else {
            fault(
                placed.span.clone(),
                format!("a time of {} s, expected 0 to {TIME_MAX_S} s", placed.value),
            )
        }
    };
    match (&row.time_s, &row.earliest_s, &row.latest_s) {
        (Some(time), None, None) => Ok(KeyframeTime::Known(stamp(time)?)),
        (None, None, None) => Ok(KeyframeTime::Unknown),
        (None, Some(earliest), Some(latest)) => {
            let (from, to) = (stamp(earliest)?, stamp(latest)?);
            if from > to {
                return fault(latest.span.clone(), "t_max is before t_min");
            }
            Ok(KeyframeTime::Within(from, to))
        }
        (Some(time), ..) => fault(
            time.span.clone(),
            "both `t` and `t_min` or `t_max`, expected a time, or both ends of an interval",
        ),
        (None, Some(one), None) | (None, None, Some(one)) => fault(
            one.span.clone(),
            "one end of an interval, expected both `t_min` and `t_max`",
        ),
    }
}
