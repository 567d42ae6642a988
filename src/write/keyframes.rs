//! Rows of a sketch as text that people edit: CSV, or TOML. Lengths are in metres and times in
//! seconds, so that what is read again is the same to the last bit.

use std::fmt::Write;

use crate::motion::{Keyframe, KeyframeTime, Mark, Scene, SketchRow, Stamp, Timing, TrackIndex};

/// The rows as CSV, with the columns that they need.
pub fn csv_of_sketch(rows: &[SketchRow], scene: &Scene) -> String {
    let parts = KeyframeParts::of(rows, scene);
    let columns = parts.columns();
    let mut text = columns.join(",");
    text.push('\n');
    for row in rows {
        let cells = match row {
            SketchRow::Keyframe {
                track,
                flight,
                keyframe,
            } => cells_of_keyframe(scene, *track, *flight, keyframe),
            SketchRow::Mark(mark) => cells_of_mark(mark),
        };
        let of = |column: &&str| {
            let cell = cells.iter().find(|(name, _)| name == column);
            cell.map_or("", |(_, cell)| cell.as_str())
        };
        let line: Vec<&str> = columns.iter().map(of).collect();
        text += &line.join(",");
        text.push('\n');
    }
    text
}

/// The rows as TOML.
pub fn toml_of_sketch(rows: &[SketchRow], scene: &Scene) -> String {
    let parts = KeyframeParts::of(rows, scene);
    let mut text = String::new();
    for row in rows {
        if !text.is_empty() {
            text.push('\n');
        }
        match row {
            SketchRow::Keyframe {
                track,
                flight,
                keyframe,
            } => keyframe_table(&mut text, scene, &parts, *track, *flight, keyframe),
            SketchRow::Mark(mark) => {
                let event = mark.event.as_deref().unwrap_or_default();
                let at = seconds(mark.stamp);
                let _ = write!(text, "[[mark]]\nevent = {event:?}\nt_s = {at}\n");
            }
        }
    }
    text
}

/// What occurs in some rows.
struct KeyframeParts {
    body: bool,
    flight: bool,
    event: bool,
    known: bool,
    within: bool,
    position: bool,
    orientation: bool,
    position_sd: bool,
    orientation_sd: bool,
}

impl KeyframeParts {
    fn of(rows: &[SketchRow], scene: &Scene) -> Self {
        let keyframes = || {
            rows.iter().filter_map(|row| match row {
                SketchRow::Keyframe { keyframe, .. } => Some(keyframe),
                SketchRow::Mark(_) => None,
            })
        };
        let marks = rows.iter().any(|row| matches!(row, SketchRow::Mark(_)));
        let known = |k: &Keyframe| matches!(k.time, KeyframeTime::Known(_));
        Self {
            body: scene.tracks.len() > 1,
            flight: scene.timing == Timing::Edited,
            event: marks,
            known: marks || keyframes().any(known),
            within: keyframes().any(|k| matches!(k.time, KeyframeTime::Within(..))),
            position: keyframes().any(|k| k.position_m.is_some()),
            orientation: keyframes().any(|k| k.orientation_wxyz.is_some()),
            position_sd: keyframes().any(|k| k.position_sd_m.is_some()),
            orientation_sd: keyframes().any(|k| k.orientation_sd_deg.is_some()),
        }
    }

    fn columns(&self) -> Vec<&'static str> {
        let groups: [(bool, &[&str]); 9] = [
            (self.body, &["body"]),
            (self.flight, &["flight"]),
            (self.event, &["event"]),
            (self.known, &["t_s"]),
            (self.within, &["t_min_s", "t_max_s"]),
            (self.position, &["x_m", "y_m", "z_m"]),
            (self.orientation, &["qw", "qx", "qy", "qz"]),
            (self.position_sd, &["position_sd_mm"]),
            (self.orientation_sd, &["orientation_sd_deg"]),
        ];
        let used = groups.iter().filter(|(is_used, _)| *is_used);
        used.flat_map(|(_, names)| names.iter().copied()).collect()
    }
}

fn cells_of_keyframe(
    scene: &Scene,
    track: TrackIndex,
    flight: usize,
    keyframe: &Keyframe,
) -> Vec<(&'static str, String)> {
    let mut cells = vec![
        ("body", quoted(&scene.link_seen_by(track).name)),
        ("flight", (flight + 1).to_string()),
    ];
    match keyframe.time {
        KeyframeTime::Known(stamp) => cells.push(("t_s", seconds(stamp))),
        KeyframeTime::Within(earliest, latest) => {
            cells.push(("t_min_s", seconds(earliest)));
            cells.push(("t_max_s", seconds(latest)));
        }
        KeyframeTime::Unknown => {}
    }
    if let Some(position_m) = keyframe.position_m {
        let names = ["x_m", "y_m", "z_m"].into_iter();
        cells.extend(names.zip(position_m.iter().map(f64::to_string)));
    }
    if let Some(orientation) = keyframe.orientation_wxyz {
        let names = ["qw", "qx", "qy", "qz"].into_iter();
        cells.extend(names.zip(orientation.iter().map(f64::to_string)));
    }
    if let Some(sd_m) = keyframe.position_sd_m {
        cells.push(("position_sd_mm", millimetres(sd_m)));
    }
    if let Some(sd_deg) = keyframe.orientation_sd_deg {
        cells.push(("orientation_sd_deg", sd_deg.to_string()));
    }
    cells
}

fn cells_of_mark(mark: &Mark) -> Vec<(&'static str, String)> {
    let event = mark.event.as_deref().unwrap_or_default();
    vec![("event", quoted(event)), ("t_s", seconds(mark.stamp))]
}

fn keyframe_table(
    text: &mut String,
    scene: &Scene,
    parts: &KeyframeParts,
    track: TrackIndex,
    flight: usize,
    keyframe: &Keyframe,
) {
    *text += "[[keyframe]]\n";
    if parts.body {
        let _ = writeln!(text, "body = {:?}", scene.link_seen_by(track).name);
    }
    if parts.flight {
        let _ = writeln!(text, "flight = {}", flight + 1);
    }
    match keyframe.time {
        KeyframeTime::Known(stamp) => {
            let _ = writeln!(text, "t_s = {}", seconds(stamp));
        }
        KeyframeTime::Within(earliest, latest) => {
            let (from, to) = (seconds(earliest), seconds(latest));
            let _ = write!(text, "t_min_s = {from}\nt_max_s = {to}\n");
        }
        KeyframeTime::Unknown => {}
    }
    let listed = |values: &[f64]| {
        let each: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
        each.join(", ")
    };
    if let Some(position_m) = keyframe.position_m {
        let _ = writeln!(text, "position_m = [{}]", listed(position_m.as_slice()));
    }
    if let Some(orientation) = keyframe.orientation_wxyz {
        let _ = writeln!(text, "orientation_wxyz = [{}]", listed(&orientation));
    }
    if let Some(sd_m) = keyframe.position_sd_m {
        let _ = writeln!(text, "position_sd_m = {sd_m:?}");
    }
    if let Some(sd_deg) = keyframe.orientation_sd_deg {
        let _ = writeln!(text, "orientation_sd_deg = {sd_deg:?}");
    }
}

/// A name as a field: in quotes where it has a comma, a quote, or a blank at an end.
pub(super) fn quoted(name: &str) -> String {
    let is_plain = !name.contains([',', '"', '\n', '#']) && name.trim() == name;
    if is_plain {
        name.to_owned()
    } else {
        format!("\"{}\"", name.replace('"', "\"\""))
    }
}

/// Seconds with as many digits as the nanoseconds need, at least one after the point.
pub(super) fn seconds(stamp: Stamp) -> String {
    let sign = if stamp.0 < 0 { "-" } else { "" };
    let ns = stamp.0.unsigned_abs();
    let fraction = format!("{:09}", ns % 1_000_000_000);
    let fraction = match fraction.trim_end_matches('0') {
        "" => "0",
        digits => digits,
    };
    format!("{sign}{}.{fraction}", ns / 1_000_000_000)
}

/// A positive length in millimetres, with the digits of the length in metres: it is the same length
/// when its point is moved back.
fn millimetres(length_m: f64) -> String {
    let text = length_m.to_string();
    let (whole, fraction) = text.split_once('.').unwrap_or((&text, ""));
    let fraction = format!("{fraction:0<3}");
    let (moved, rest) = fraction.split_at(3);
    let whole = format!("{whole}{moved}");
    let whole = match whole.trim_start_matches('0') {
        "" => "0",
        digits => digits,
    };
    if rest.is_empty() {
        whole.to_owned()
    } else {
        format!("{whole}.{rest}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_lengths_have_the_digits_that_they_need() {
        for (ns, text) in [
            (0, "0.0"),
            (250_000_000, "0.25"),
            (1_000_000_001, "1.000000001"),
            (12_000_000_000, "12.0"),
        ] {
            assert_eq!(seconds(Stamp(ns)), text);
        }
        for (m, text) in [
            (0.001, "1"),
            (0.0015, "1.5"),
            (1.0 / 3.0, "333.3333333333333"),
        ] {
            assert_eq!(millimetres(m), text);
            assert_eq!(format!("{text}e-3").parse(), Ok(m));
        }
    }
}
