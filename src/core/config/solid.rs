//! Reads shapes from their keys.

use std::ops::Range;

use crate::config::spanned::Spanned;
use nalgebra::Vector3;

use super::error::{Fault, fault};
use super::number::{pose, positive, vector};
use super::raw::{Number, RawShape};
use crate::math::Pose;
use crate::physics::shape::{Compound, MassDistribution, Part, Revolution};
use crate::physics::{Shape, ShapeError};

/// The kinds of shape, each with its keys in the order in which missing ones are reported.
pub(super) const KINDS: &[(&str, &[&str])] = &[
    ("cuboid", &["size_mm"]),
    ("rounded_cuboid", &["size_mm", "radius_mm"]),
    ("sphere", &["radius_mm"]),
    ("cylinder", &["length_mm", "radius_mm"]),
    ("capsule", &["length_mm", "radius_mm"]),
    ("cone", &["height_mm", "radius_mm"]),
    ("hull", &["points_mm"]),
    ("revolution", &["profile_mm"]),
    ("pieces", &["pieces_mm"]),
];

/// Kinds that may have a wall.
const HOLLOW: &[&str] = &[
    "cuboid",
    "rounded_cuboid",
    "sphere",
    "cylinder",
    "capsule",
    "revolution",
];

/// A solid at its place in the frame of what it is of.
#[derive(Clone, Debug)]
pub(super) struct PlacedSolid {
    /// In its own axes.
    pub(super) shape: Shape,
    /// Where these are.
    pub(super) given_from_shape: Pose,
    /// How its mass is distributed at uniform density, in the frame of what it is of.
    pub(super) mass: MassDistribution,
    /// Whether it is full of mass up to its surface, and is no approximation of another shape.
    pub(super) is_filled: bool,
}

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
) -> Result<PlacedSolid, Fault> {
    let (shape, exact) = by_kind(raw)?;
    let refused = |error: ShapeError| Fault {
        span: raw.span(),
        message: error.to_string(),
    };
    shape.check().map_err(refused)?;
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
    shape.solid().map_err(refused)?;
    let of = raw.get_ref();
    let turn = (of.orientation_wxyz.as_ref(), of.rpy_deg.as_ref());
    let given_from_shape = pose(what, of.position_mm.as_ref(), turn)?;
    let is_filled = exact.is_none() && of.wall_mm.is_none();
    let mass = match exact {
        Some(exact) => exact,
        None => shape.mass().map_err(refused)?,
    };
    let mass = match (&of.wall_mm, of.kind.get_ref().as_str()) {
        (Some(wall), kind) if kind != "revolution" => hollow(&shape, &mass, wall)?,
        _ => mass,
    };
    Ok(PlacedSolid {
        mass: mass.placed(&given_from_shape),
        shape,
        given_from_shape,
        is_filled,
    })
}

/// What is left of a solid's mass around a cavity that is everywhere so far from its surface.
fn hollow(
    shape: &Shape,
    mass: &MassDistribution,
    wall: &Number,
) -> Result<MassDistribution, Fault> {
    let wall_m = positive("wall_mm", wall)? / 1e3;
    let cavity = match *shape {
        Shape::Cuboid { half_extents_m } => Shape::Cuboid {
            half_extents_m: half_extents_m.add_scalar(-wall_m),
        },
        Shape::RoundedCuboid {
            half_extents_m,
            radius_m,
        } if radius_m > wall_m => Shape::RoundedCuboid {
            half_extents_m: half_extents_m.add_scalar(-wall_m),
            radius_m: radius_m - wall_m,
        },
        Shape::RoundedCuboid { half_extents_m, .. } => Shape::Cuboid {
            half_extents_m: half_extents_m.add_scalar(-wall_m),
        },
        Shape::Sphere { radius_m } => Shape::Sphere {
            radius_m: radius_m - wall_m,
        },
        Shape::Cylinder {
            half_length_m,
            radius_m,
        } => Shape::Cylinder {
            half_length_m: half_length_m - wall_m,
            radius_m: radius_m - wall_m,
        },
        Shape::Capsule {
            half_length_m,
            radius_m,
        } => Shape::Capsule {
            half_length_m,
            radius_m: radius_m - wall_m,
        },
        Shape::Cone { .. } | Shape::Hull { .. } | Shape::Compound(_) => {
            return fault(wall.span(), "wall_mm does not apply to this kind of shape");
        }
    };
    let left = cavity.mass().ok().and_then(|cavity| {
        let parts = [(mass.volume_m3, *mass), (-cavity.volume_m3, cavity)];
        MassDistribution::joined(&parts)
    });
    left.ok_or_else(|| Fault {
        span: wall.span(),
        message: "wall_mm leaves no cavity, expected less than half the least size: a filled shape has no wall_mm".into(),
    })
}

/// The shape in its own axes, and how its mass is distributed where the shape is only near to it.
fn by_kind(spanned: &Spanned<RawShape>) -> Result<(Shape, Option<MassDistribution>), Fault> {
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
    if let Some(wall) = raw.wall_mm.as_ref().filter(|_| !HOLLOW.contains(&kind)) {
        let said = format!(
            "wall_mm does not apply to a {kind}, expected one of {}",
            HOLLOW.join(", ")
        );
        return fault(wall.span(), said);
    }
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
    let shape = match kind {
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
        "revolution" => return revolution(raw, || missing("profile_mm")),
        "pieces" => {
            let pieces = raw.pieces_mm.as_ref().ok_or_else(|| missing("pieces_mm"))?;
            let parts = pieces.get_ref().iter().map(|points| Part {
                shape: hull(points),
                compound_from_shape: Pose::identity(),
            });
            Shape::Compound(Compound {
                parts: parts.collect(),
                features: Vec::new(),
            })
        }
        _ => {
            let points = raw.points_mm.as_ref().ok_or_else(|| missing("points_mm"))?;
            hull(points.get_ref())
        }
    };
    Ok((shape, None))
}

fn hull(points_mm: &[[f64; 3]]) -> Shape {
    let points = points_mm.iter();
    Shape::Hull {
        points_m: points.map(|p| Vector3::from(*p) / 1e3).collect(),
    }
}

fn revolution(
    raw: &RawShape,
    missing: impl Fn() -> Fault,
) -> Result<(Shape, Option<MassDistribution>), Fault> {
    let profile = raw.profile_mm.as_ref().ok_or_else(missing)?;
    let points = profile.get_ref().iter();
    let profile_m: Vec<[f64; 2]> = points.map(|p| p.map(|mm| mm / 1e3)).collect();
    let wall_m = match &raw.wall_mm {
        Some(wall) => Some(positive("wall_mm", wall)? / 1e3),
        None => None,
    };
    let made = Revolution::new(&profile_m, wall_m);
    let made = made.and_then(|of| Ok((of.compound(), of.mass()?)));
    let (compound, mass) = made.map_err(|error| Fault {
        span: profile.span(),
        message: error.to_string(),
    })?;
    Ok((Shape::Compound(compound), Some(mass)))
}

/// The keys that are given, with their places in the text.
fn given(raw: &RawShape) -> impl Iterator<Item = (&'static str, Range<usize>)> {
    [
        ("size_mm", raw.size_mm.as_ref().map(Spanned::span)),
        ("radius_mm", raw.radius_mm.as_ref().map(Spanned::span)),
        ("length_mm", raw.length_mm.as_ref().map(Spanned::span)),
        ("height_mm", raw.height_mm.as_ref().map(Spanned::span)),
        ("points_mm", raw.points_mm.as_ref().map(Spanned::span)),
        ("profile_mm", raw.profile_mm.as_ref().map(Spanned::span)),
        ("pieces_mm", raw.pieces_mm.as_ref().map(Spanned::span)),
    ]
    .into_iter()
    .filter_map(|(key, span)| Some((key, span?)))
}
