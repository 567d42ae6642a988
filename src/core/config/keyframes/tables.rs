//! Tables of a TOML file: `[[keyframe]]` and `[[mark]]`.

use std::ops::Range;

use schemars::JsonSchema;
use serde::Deserialize;

use super::{PlacedKeyframe, WrittenKeyframes};
use crate::config::counted;
use crate::config::error::{Fault, SceneError};
use crate::config::spanned::Spanned;

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::config) struct RawFile {
    #[serde(default)]
    keyframe: Vec<Spanned<RawKeyframe>>,
    #[serde(default)]
    mark: Vec<Spanned<RawMark>>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct RawKeyframe {
    body: Option<Spanned<String>>,
    flight: Option<Spanned<f64>>,
    t_s: Option<Spanned<f64>>,
    t_ms: Option<Spanned<f64>>,
    t_min_s: Option<Spanned<f64>>,
    t_min_ms: Option<Spanned<f64>>,
    t_max_s: Option<Spanned<f64>>,
    t_max_ms: Option<Spanned<f64>>,
    position_m: Option<Spanned<[f64; 3]>>,
    position_mm: Option<Spanned<[f64; 3]>>,
    orientation_wxyz: Option<Spanned<[f64; 4]>>,
    rpy_deg: Option<Spanned<[f64; 3]>>,
    position_sd_m: Option<Spanned<f64>>,
    position_sd_mm: Option<Spanned<f64>>,
    orientation_sd_deg: Option<Spanned<f64>>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct RawMark {
    event: Spanned<String>,
    t_s: Option<Spanned<f64>>,
    t_ms: Option<Spanned<f64>>,
}

pub(super) fn rows(text: &str) -> Result<Vec<WrittenKeyframes>, SceneError> {
    let raw: RawFile = counted::read(text)?;
    let keyframes = raw.keyframe.into_iter().map(|raw| {
        let span = raw.span();
        keyframe(span, raw.into_inner())
    });
    let marks = raw.mark.into_iter().map(|raw| {
        let span = raw.span();
        mark(span, raw.into_inner())
    });
    let rows: Result<Vec<WrittenKeyframes>, Fault> = keyframes.chain(marks).collect();
    let mut rows = rows.map_err(|fault| SceneError::from_fault(text, fault))?;
    // As they are written: a mark among keyframes says on which side of it each is.
    rows.sort_by_key(|row| row.span.start);
    Ok(rows)
}

fn keyframe(span: Range<usize>, raw: RawKeyframe) -> Result<WrittenKeyframes, Fault> {
    let position = one(raw.position_m, raw.position_mm, "position_m", "position_mm")?;
    let position = position.map(|(values, thousand)| {
        let span = values.span();
        values
            .into_inner()
            .map(|value| finite(value / thousand, &span))
    });
    let mut position_m = [None, None, None];
    for (to, value) in position_m.iter_mut().zip(position.into_iter().flatten()) {
        *to = Some(value?);
    }
    let mut orientation_wxyz = [None, None, None, None];
    if let Some(values) = raw.orientation_wxyz {
        let span = values.span();
        for (to, value) in orientation_wxyz.iter_mut().zip(values.into_inner()) {
            *to = Some(finite(value, &span)?);
        }
    }
    let mut rpy_deg = [None, None, None];
    if let Some(values) = raw.rpy_deg {
        let span = values.span();
        for (to, value) in rpy_deg.iter_mut().zip(values.into_inner()) {
            *to = Some(finite(value, &span)?);
        }
    }
    Ok(WrittenKeyframes {
        span,
        body: raw.body.map(placed),
        flight: raw.flight.map(placed),
        event: None,
        time_s: scaled(raw.t_s, raw.t_ms, "t_s", "t_ms")?,
        earliest_s: scaled(raw.t_min_s, raw.t_min_ms, "t_min_s", "t_min_ms")?,
        latest_s: scaled(raw.t_max_s, raw.t_max_ms, "t_max_s", "t_max_ms")?,
        position_m,
        orientation_wxyz,
        rpy_deg,
        position_sd_m: scaled(
            raw.position_sd_m,
            raw.position_sd_mm,
            "position_sd_m",
            "position_sd_mm",
        )?,
        orientation_sd_deg: scaled(raw.orientation_sd_deg, None, "orientation_sd_deg", "")?,
    })
}

fn mark(span: Range<usize>, raw: RawMark) -> Result<WrittenKeyframes, Fault> {
    Ok(WrittenKeyframes {
        span,
        event: Some(placed(raw.event)),
        time_s: scaled(raw.t_s, raw.t_ms, "t_s", "t_ms")?,
        ..WrittenKeyframes::default()
    })
}

fn placed<T>(spanned: Spanned<T>) -> PlacedKeyframe<T> {
    PlacedKeyframe {
        span: spanned.span(),
        value: spanned.into_inner(),
    }
}

fn finite(value: f64, span: &Range<usize>) -> Result<PlacedKeyframe<f64>, Fault> {
    let span = span.clone();
    if value.is_finite() {
        return Ok(PlacedKeyframe { value, span });
    }
    let message = format!("{value}, expected a finite number");
    Err(Fault { span, message })
}

/// One of two keys for the same, with how many of its unit are one of the other's.
fn one<T>(
    base: Option<Spanned<T>>,
    thousandths: Option<Spanned<T>>,
    name: &str,
    other: &str,
) -> Result<Option<(Spanned<T>, f64)>, Fault> {
    match (base, thousandths) {
        (Some(_), Some(second)) => Err(Fault {
            span: second.span(),
            message: format!("both `{name}` and `{other}`, expected one of them"),
        }),
        (Some(value), None) => Ok(Some((value, 1.0))),
        (None, Some(value)) => Ok(Some((value, 1e3))),
        (None, None) => Ok(None),
    }
}

fn scaled(
    base: Option<Spanned<f64>>,
    thousandths: Option<Spanned<f64>>,
    name: &str,
    other: &str,
) -> Result<Option<PlacedKeyframe<f64>>, Fault> {
    let found = one(base, thousandths, name, other)?;
    let value = found.map(|(value, thousand)| {
        let span = value.span();
        finite(value.into_inner() / thousand, &span)
    });
    value.transpose()
}
