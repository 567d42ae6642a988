//! Rows of a CSV file: a line of column names, then a row for each keyframe or event. Empty lines
//! and lines that begin with `#` are skipped.

use std::ops::Range;

use super::{PlacedKeyframe, WrittenKeyframes};
use crate::config::error::{Fault, fault};
use crate::config::keys::nearest;

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Value {
    Body,
    Flight,
    Event,
    Time,
    Earliest,
    Latest,
    Position(usize),
    Orientation(usize),
    Angle(usize),
    PositionSd,
    OrientationSd,
}

/// Names of columns, with what they hold and the power of ten that makes it SI.
const COLUMNS: [(&str, Value, i32); 31] = [
    ("body", Value::Body, 0),
    ("flight", Value::Flight, 0),
    ("event", Value::Event, 0),
    ("t", Value::Time, 0),
    ("t_s", Value::Time, 0),
    ("t_ms", Value::Time, -3),
    ("t_min", Value::Earliest, 0),
    ("t_min_s", Value::Earliest, 0),
    ("t_min_ms", Value::Earliest, -3),
    ("t_max", Value::Latest, 0),
    ("t_max_s", Value::Latest, 0),
    ("t_max_ms", Value::Latest, -3),
    ("x", Value::Position(0), 0),
    ("x_m", Value::Position(0), 0),
    ("x_mm", Value::Position(0), -3),
    ("y", Value::Position(1), 0),
    ("y_m", Value::Position(1), 0),
    ("y_mm", Value::Position(1), -3),
    ("z", Value::Position(2), 0),
    ("z_m", Value::Position(2), 0),
    ("z_mm", Value::Position(2), -3),
    ("qw", Value::Orientation(0), 0),
    ("qx", Value::Orientation(1), 0),
    ("qy", Value::Orientation(2), 0),
    ("qz", Value::Orientation(3), 0),
    ("roll_deg", Value::Angle(0), 0),
    ("pitch_deg", Value::Angle(1), 0),
    ("yaw_deg", Value::Angle(2), 0),
    ("position_sd_m", Value::PositionSd, 0),
    ("position_sd_mm", Value::PositionSd, -3),
    ("orientation_sd_deg", Value::OrientationSd, 0),
];

/// A field of a line, without the blanks and quotes about it.
#[derive(Clone, Debug)]
struct CsvField {
    text: String,
    span: Range<usize>,
}

pub(super) fn rows(text: &str) -> Result<Vec<WrittenKeyframes>, Fault> {
    let mut lines = lines(text);
    let Some((start, line)) = lines.next() else {
        return fault(0..0, "an empty file, expected a line of column names");
    };
    let columns = columns(&fields(start, line)?)?;
    let mut rows = Vec::new();
    for (start, line) in lines {
        rows.push(row(&columns, start, line)?);
    }
    Ok(rows)
}

/// Lines with where they begin, but for empty ones and remarks.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut start = 0;
    let all = text.split_inclusive('\n').map(move |line| {
        let begins = start;
        start += line.len();
        (begins, line.trim_end_matches(['\n', '\r']))
    });
    all.filter(|(_, line)| {
        let line = line.trim_start_matches('\u{feff}').trim();
        !line.is_empty() && !line.starts_with('#')
    })
}

/// The fields of a line. A field in quotes may hold commas, and two quotes stand for one.
fn fields(start: usize, line: &str) -> Result<Vec<CsvField>, Fault> {
    let mut fields = Vec::new();
    let mut at = 0;
    loop {
        let rest = &line[at..];
        let blank = rest.len() - rest.trim_start_matches([' ', '\t', '\u{feff}']).len();
        let begin = at + blank;
        let (text, end) = if line[begin..].starts_with('"') {
            quoted(line, begin).ok_or_else(|| Fault {
                span: start + begin..start + line.len(),
                message: "a quote that is not closed, expected `\"` before the next comma".into(),
            })?
        } else {
            let end = line[begin..]
                .find(',')
                .map_or(line.len(), |comma| begin + comma);
            (line[begin..end].trim_end().to_owned(), end)
        };
        fields.push(CsvField {
            span: start + begin..start + end.max(begin),
            text,
        });
        if end >= line.len() {
            return Ok(fields);
        }
        at = end + 1;
    }
}

/// The text of a field that begins with a quote, and where its comma or the line's end is.
fn quoted(line: &str, begin: usize) -> Option<(String, usize)> {
    let mut text = String::new();
    let mut chars = line[begin + 1..].char_indices().peekable();
    while let Some((at, character)) = chars.next() {
        if character != '"' {
            text.push(character);
        } else if chars.next_if(|(_, next)| *next == '"').is_some() {
            text.push('"');
        } else {
            let after = begin + 1 + at + 1;
            let rest = &line[after..];
            let end = after + rest.find(',').unwrap_or(rest.len());
            return line[after..end].trim().is_empty().then_some((text, end));
        }
    }
    None
}

fn columns(header: &[CsvField]) -> Result<Vec<(Value, i32)>, Fault> {
    let names: Vec<&str> = COLUMNS.iter().map(|(name, ..)| *name).collect();
    let mut columns: Vec<(Value, i32)> = Vec::new();
    for field in header {
        let name = field.text.as_str();
        let known = COLUMNS.iter().find(|(known, ..)| *known == name);
        let Some((_, value, power)) = known else {
            let hint = nearest(name, &names)
                .map_or(String::new(), |near| format!(", did you mean `{near}`?"));
            return fault(
                field.span.clone(),
                format!(
                    "unknown column `{name}`{hint} Expected some of {}",
                    names.join(", ")
                ),
            );
        };
        if columns.iter().any(|(other, _)| other == value) {
            return fault(
                field.span.clone(),
                format!("column `{name}` says what another column says already"),
            );
        }
        columns.push((*value, *power));
    }
    Ok(columns)
}

fn row(columns: &[(Value, i32)], start: usize, line: &str) -> Result<WrittenKeyframes, Fault> {
    let fields = fields(start, line)?;
    if fields.len() != columns.len() {
        return fault(
            start..start + line.len(),
            format!(
                "{} fields, expected {}, as many as columns",
                fields.len(),
                columns.len()
            ),
        );
    }
    let mut row = WrittenKeyframes {
        span: start..start + line.len(),
        ..WrittenKeyframes::default()
    };
    for ((value, power), field) in columns.iter().zip(fields) {
        if field.text.is_empty() {
            continue;
        }
        let word = |field: CsvField| {
            Some(PlacedKeyframe {
                value: field.text,
                span: field.span,
            })
        };
        match value {
            Value::Body => row.body = word(field),
            Value::Event => row.event = word(field),
            value => {
                let number = Some(number(&field, *power)?);
                match value {
                    Value::Flight => row.flight = number,
                    Value::Time => row.time_s = number,
                    Value::Earliest => row.earliest_s = number,
                    Value::Latest => row.latest_s = number,
                    Value::Position(axis) => row.position_m[*axis] = number,
                    Value::Orientation(part) => row.orientation_wxyz[*part] = number,
                    Value::Angle(axis) => row.rpy_deg[*axis] = number,
                    Value::PositionSd => row.position_sd_m = number,
                    Value::OrientationSd => row.orientation_sd_deg = number,
                    Value::Body | Value::Event => {}
                }
            }
        }
    }
    Ok(row)
}

/// A number times a power of ten, rounded once.
fn number(field: &CsvField, power: i32) -> Result<PlacedKeyframe<f64>, Fault> {
    let text = field.text.as_str();
    let scaled = match power {
        0 => text.to_owned(),
        // Digits and a point: the exponent moves the point.
        power if !text.contains(['e', 'E']) => format!("{text}e{power}"),
        power => match text.parse::<f64>() {
            Ok(number) => (number * 10_f64.powi(power)).to_string(),
            Err(_) => text.to_owned(),
        },
    };
    match scaled.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(PlacedKeyframe {
            value,
            span: field.span.clone(),
        }),
        _ => fault(
            field.span.clone(),
            format!("`{text}` is no number, expected digits with a point, or nothing"),
        ),
    }
}
