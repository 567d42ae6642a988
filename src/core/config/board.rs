//! Surfaces with an end: boards.

use nalgebra::{Rotation3, UnitQuaternion, Vector3};

use super::error::{Fault, fault};
use super::number::{direction, positive};
use super::raw::RawSurface;
use crate::math::Pose;
use crate::motion::Obstacle;
use crate::physics::Shape;

/// Thickness where none is given \[m\].
const THICKNESS_M: f64 = 0.01;

/// Largest side \[m\].
const SIDE_LIMIT_M: f64 = 1e4;

/// The solid of a surface that has a size: a box below it. `None` of one without an end.
pub(super) fn board(
    raw: &RawSurface,
    name: &str,
    point_m: Vector3<f64>,
    normal: Vector3<f64>,
) -> Result<Option<Obstacle>, Fault> {
    let Some(size) = &raw.size_mm else {
        let own = [
            (
                "thickness_mm",
                raw.thickness_mm.as_ref().map(|of| of.span()),
            ),
            ("along", raw.along.as_ref().map(|of| of.span())),
        ];
        return match own.into_iter().find_map(|(key, span)| Some((key, span?))) {
            Some((key, span)) => fault(
                span,
                format!("{key} is about a board, expected size_mm beside it"),
            ),
            None => Ok(None),
        };
    };
    let sides_m = size.get_ref().map(|mm| mm / 1e3);
    if !sides_m
        .iter()
        .all(|side| *side > 0.0 && *side <= SIDE_LIMIT_M)
    {
        return fault(
            size.span(),
            format!(
                "size_mm is [{}, {}], expected two positive sides of at most {SIDE_LIMIT_M} m",
                size.get_ref()[0],
                size.get_ref()[1]
            ),
        );
    }
    let thickness_m = match &raw.thickness_mm {
        Some(number) => positive("thickness_mm", number)? / 1e3,
        None => THICKNESS_M,
    };
    let along = match &raw.along {
        Some(given) => direction("along", given)?,
        None if normal.x.abs() > normal.y.abs() && normal.x.abs() > 0.9 => Vector3::y(),
        None => Vector3::x(),
    };
    // Half a degree from the normal is no direction in the board.
    let across = along - normal * normal.dot(&along);
    let Some(first) = across.try_normalize(1e-2) else {
        let span = raw.along.as_ref().map_or(raw.normal.span(), |of| of.span());
        return fault(
            span,
            "along is the normal, expected a direction in the board",
        );
    };
    let turn = Rotation3::from_basis_unchecked(&[first, normal.cross(&first), normal]);
    let half_extents_m = Vector3::new(sides_m[0], sides_m[1], thickness_m) / 2.0;
    let middle_m = point_m - normal * half_extents_m.z;
    Ok(Some(Obstacle {
        name: name.to_owned(),
        shape: Shape::Cuboid { half_extents_m },
        world_from_shape: Pose::from_parts(
            middle_m.into(),
            UnitQuaternion::from_rotation_matrix(&turn),
        ),
    }))
}
