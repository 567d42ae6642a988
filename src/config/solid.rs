//! Reads shapes from their keys.

use std::ops::Range;

use nalgebra::Vector3;
use toml::Spanned;

use super::error::{Fault, fault};
use super::number::{positive, vector};
use super::raw::{Number, RawShape};
use crate::physics::Shape;

/// The kinds of shape, each with its keys in the order in which missing ones are reported.
const KINDS: &[(&str, &[&str])] = &[
    ("cuboid", &["size_mm"]),
    ("rounded_cuboid", &["size_mm", "radius_mm"]),
    ("sphere", &["radius_mm"]),
    ("cylinder", &["length_mm", "radius_mm"]),
    ("capsule", &["length_mm", "radius_mm"]),
    ("cone", &["height_mm", "radius_mm"]),
    ("hull", &["points_mm"]),
];

/// Limits of the size of a body, or of a part of its world \[m\].
pub(super) struct SizeLimits {
    pub(super) least_m: f64,
    pub(super) greatest_m: f64,
}

/// A solid within the size limits.
pub(super) fn shape(
    what: &str,
    raw: &Spanned<RawShape>,
    limits: &SizeLimits,
) -> Result<Shape, Fault> {
    let shape = by_kind(raw)?;
    shape
        .check()
        .or_else(|error| fault(raw.span(), error.to_string()))?;
    let size_m = 2.0 * shape.radius_m();
    if size_m > limits.greatest_m {
        return fault(
            raw.span(),
            format!(
                "{what} is {size_m} m across, expected at most {} m: lengths are in millimetres here",
                limits.greatest_m
            ),
        );
    }
    if size_m < limits.least_m {
        return fault(
            raw.span(),
            format!(
                "{what} is {} mm across, expected at least {} mm: lengths are in millimetres here, not in metres",
                size_m * 1e3,
                limits.least_m * 1e3
            ),
        );
    }
    // Only a hull can still fail here: its surface must close.
    shape
        .solid()
        .or_else(|error| fault(raw.span(), error.to_string()))?;
    Ok(shape)
}

fn by_kind(spanned: &Spanned<RawShape>) -> Result<Shape, Fault> {
    let raw = spanned.get_ref();
    let kind = raw.kind.get_ref().as_str();
    let Some((_, wanted)) = KINDS.iter().find(|(name, _)| *name == kind) else {
        let names: Vec<&str> = KINDS.iter().map(|(name, _)| *name).collect();
        return fault(
            raw.kind.span(),
            format!(
                "unknown kind of shape {kind:?}, expected one of {}",
                names.join(", ")
            ),
        );
    };
    for (key, span) in given(raw) {
        if !wanted.contains(&key) {
            return fault(
                span,
                format!(
                    "{key} does not apply to a {kind}, expected {}",
                    wanted.join(" and ")
                ),
            );
        }
    }
    let missing = |key: &str| Fault {
        span: spanned.span(),
        message: format!(
            "missing key `{key}`: a {kind} needs {}",
            wanted.join(" and ")
        ),
    };
    let length_m = |key: &str, number: &Option<Number>| -> Result<f64, Fault> {
        Ok(positive(key, number.as_ref().ok_or_else(|| missing(key))?)? / 1e3)
    };
    let half_extents_m = || -> Result<Vector3<f64>, Fault> {
        let size = raw.size_mm.as_ref().ok_or_else(|| missing("size_mm"))?;
        let half_extents_m = vector("size_mm", size)? / 2e3;
        if half_extents_m.min() <= 0.0 {
            return fault(size.span(), "size_mm has a side that is not positive");
        }
        Ok(half_extents_m)
    };
    Ok(match kind {
        "cuboid" => Shape::Cuboid {
            half_extents_m: half_extents_m()?,
        },
        "rounded_cuboid" => Shape::RoundedCuboid {
            half_extents_m: half_extents_m()?,
            radius_m: length_m("radius_mm", &raw.radius_mm)?,
        },
        "sphere" => Shape::Sphere {
            radius_m: length_m("radius_mm", &raw.radius_mm)?,
        },
        "cylinder" => Shape::Cylinder {
            half_length_m: length_m("length_mm", &raw.length_mm)? / 2.0,
            radius_m: length_m("radius_mm", &raw.radius_mm)?,
        },
        "capsule" => Shape::Capsule {
            half_length_m: length_m("length_mm", &raw.length_mm)? / 2.0,
            radius_m: length_m("radius_mm", &raw.radius_mm)?,
        },
        "cone" => Shape::Cone {
            half_height_m: length_m("height_mm", &raw.height_mm)? / 2.0,
            radius_m: length_m("radius_mm", &raw.radius_mm)?,
        },
        _ => {
            let points = raw.points_mm.as_ref().ok_or_else(|| missing("points_mm"))?;
            Shape::Hull {
                points_m: points
                    .get_ref()
                    .iter()
                    .map(|p| Vector3::from(*p) / 1e3)
                    .collect(),
            }
        }
    })
}

/// The keys that are given, with their places in the text.
fn given(raw: &RawShape) -> impl Iterator<Item = (&'static str, Range<usize>)> {
    [
        ("size_mm", raw.size_mm.as_ref().map(Spanned::span)),
        ("radius_mm", raw.radius_mm.as_ref().map(Spanned::span)),
        ("length_mm", raw.length_mm.as_ref().map(Spanned::span)),
        ("height_mm", raw.height_mm.as_ref().map(Spanned::span)),
        ("points_mm", raw.points_mm.as_ref().map(Spanned::span)),
    ]
    .into_iter()
    .filter_map(|(key, span)| Some((key, span?)))
}
