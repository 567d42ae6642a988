//! The shape of a body from the solids of its link.
//!
//! Shapes of scenes have their centre in the centre of mass and lie along the body's axes; hulls may
//! be anywhere. So a solid that is elsewhere becomes the hull of its corners.

use std::f64::consts::TAU;

use nalgebra::{UnitQuaternion, Vector3};

use super::element::Notes;
use super::geometry::{UrdfPlaced, UrdfPrimitive};

use super::robot::{Inertial, UrdfLink};
use crate::config::error::{Fault, fault};
use crate::config::principal::{ROUNDING, principal};
use crate::math::Pose;

/// How far a solid may be from the centre of mass to count as centred there \[m\].
const CENTRED_M: f64 = 1e-6;

/// By how much its axes may be turned to count as the body's: `rpy="1.5708 0 0"` is 3.7e-6 rad off a
/// quarter.
const ALONG_RAD: f64 = 1e-5;

/// Corners of a hull around an axis.
const CORNERS: usize = 24;

/// Height over radius below which a corner of a sphere is on its equator.
const EQUATOR: f64 = 1e-9;

/// Least side of a box of given moments, relative to its greatest.
const FLAT: f64 = 1e-3;

/// A body: its axes in the link's frame, mass, moments and shape.
#[derive(Clone, Debug)]
pub(super) struct UrdfSolid {
    pub(super) link_from_body: Pose,
    pub(super) mass_kg: f64,
    pub(super) moments_kg_m2: Vector3<f64>,
    pub(super) shape: UrdfShape,
}

/// A shape that scenes have, in the body's axes.
#[derive(Clone, Debug)]
pub(super) enum UrdfShape {
    Whole(UrdfPrimitive),
    Hull { points_m: Vec<Vector3<f64>> },
}

/// The body of a link with mass.
///
/// Its axes are the link's own where these are principal, else those of its solid where these are,
/// else the principal axes nearest to the link's.
pub(super) fn solid(
    link: &UrdfLink,
    inertial: &Inertial,
    notes: &mut Notes,
) -> Result<UrdfSolid, Fault> {
    let placed = chosen(link, inertial, notes);
    let centre = &inertial.link_from_centre;
    let turn = centre.rotation.to_rotation_matrix();
    let tensor = turn.matrix() * inertial.tensor_kg_m2 * turn.matrix().transpose();
    let body = |near: &UnitQuaternion<f64>| {
        let (turn, moments_kg_m2) = principal(&tensor, near, ROUNDING)?;
        let link_from_body = Pose::from_parts(centre.translation, turn);
        Some((link_from_body, moments_kg_m2))
    };
    let own = UnitQuaternion::identity();
    let of_solid = placed.iter().map(|of| of.link_from_solid.rotation);
    let native = std::iter::once(own).chain(of_solid).find_map(|near| {
        let (link_from_body, moments_kg_m2) = body(&near)?;
        let shape = native(&link_from_body, placed)?;
        Some((link_from_body, moments_kg_m2, UrdfShape::Whole(shape)))
    });
    let (link_from_body, moments_kg_m2, shape) = match native {
        Some(found) => found,
        None => {
            let Some((link_from_body, moments_kg_m2)) = body(&own) else {
                let said = format!(
                    "the inertia of {:?} has no principal axes, expected moments in kg m² that are not all zero",
                    link.name.get_ref()
                );
                return fault(inertial.span.clone(), said);
            };
            let shape = match placed.is_empty() {
                true => of_moments(inertial.mass_kg, &moments_kg_m2),
                false => {
                    let said = format!(
                        "the solid of {:?} is not in its centre of mass along principal axes, or is of several: its shape is their convex hull, with {CORNERS} corners around what is round",
                        link.name.get_ref()
                    );
                    notes.add(&link.name.span(), said);
                    hull(&link_from_body, placed)
                }
            };
            (link_from_body, moments_kg_m2, shape)
        }
    };
    Ok(UrdfSolid {
        link_from_body,
        mass_kg: inertial.mass_kg,
        moments_kg_m2,
        shape,
    })
}

/// The solids that count: those that collide, or that are drawn where none do.
fn chosen<'a>(link: &'a UrdfLink, inertial: &Inertial, notes: &mut Notes) -> &'a [UrdfPlaced] {
    let of = &link.geometries;
    let name = link.name.get_ref();
    let is_drawn = of.collision.placed.is_empty() && !of.visual.placed.is_empty();
    let solids = match is_drawn {
        true => &of.visual,
        false => &of.collision,
    };
    for mesh in of.collision.meshes.iter().chain(&of.visual.meshes) {
        notes.add(mesh, format!("a mesh of {name:?} is not read"));
    }
    if solids.placed.is_empty() {
        let said = format!("{name:?} has no solid: its shape is a box of the same moments");
        notes.add(&inertial.span, said);
    } else if is_drawn {
        let said = format!("nothing of {name:?} that collides is read: its shape is what is drawn");
        notes.add(&link.name.span(), said);
    }
    &solids.placed
}

/// The one solid as a shape of a body with these axes, where it is one.
fn native(link_from_body: &Pose, placed: &[UrdfPlaced]) -> Option<UrdfPrimitive> {
    let [of] = placed else {
        return None;
    };
    let body_from_solid = link_from_body.inverse() * of.link_from_solid;
    if body_from_solid.translation.vector.norm() > CENTRED_M {
        return None;
    }
    let turn = body_from_solid.rotation.to_rotation_matrix();
    match &of.primitive {
        UrdfPrimitive::Cuboid { half_extents_m } => {
            let along = turn.matrix().map(|of| of.abs().round());
            let is_along = (turn.matrix().abs() - along).amax() <= ALONG_RAD;
            is_along.then(|| UrdfPrimitive::Cuboid {
                half_extents_m: along * half_extents_m,
            })
        }
        UrdfPrimitive::Cylinder { .. } | UrdfPrimitive::Capsule { .. } => {
            let across = turn.matrix().column(2).xy().amax();
            (across <= ALONG_RAD).then(|| of.primitive.clone())
        }
        UrdfPrimitive::Sphere { .. } => Some(of.primitive.clone()),
    }
}

/// The box of uniform density with this mass and these moments. Where it would be a plate without
/// thickness it has a little.
fn of_moments(mass_kg: f64, moments_kg_m2: &Vector3<f64>) -> UrdfShape {
    // I_x = m (b² + c²)/3 with half sides a, b, c.
    let squares = moments_kg_m2.map(|of| (0.5 * moments_kg_m2.sum() - of) * 3.0 / mass_kg);
    let sides = squares.map(|of| of.max(0.0).sqrt());
    UrdfShape::Whole(UrdfPrimitive::Cuboid {
        half_extents_m: sides.map(|of| of.max(FLAT * sides.max())),
    })
}

/// Corners of all solids, in the body's axes.
fn hull(link_from_body: &Pose, placed: &[UrdfPlaced]) -> UrdfShape {
    let body_from_link = link_from_body.inverse();
    let mut points_m = Vec::new();
    for of in placed {
        let body_from_solid = body_from_link * of.link_from_solid;
        let corners = corners(&of.primitive).into_iter();
        points_m.extend(corners.map(|at| (body_from_solid * nalgebra::Point3::from(at)).coords));
    }
    UrdfShape::Hull { points_m }
}

fn corners(primitive: &UrdfPrimitive) -> Vec<Vector3<f64>> {
    match primitive {
        UrdfPrimitive::Cuboid { half_extents_m } => (0..8)
            .map(|corner| {
                let sign = |axis: usize| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
                Vector3::from_fn(|axis, _| sign(axis) * half_extents_m[axis])
            })
            .collect(),
        UrdfPrimitive::Cylinder {
            half_length_m,
            radius_m,
        } => [-half_length_m, *half_length_m]
            .into_iter()
            .flat_map(|z_m| ring(*radius_m, z_m))
            .collect(),
        UrdfPrimitive::Capsule {
            half_length_m,
            radius_m,
        } => [-1.0, 1.0]
            .into_iter()
            .flat_map(|end: f64| {
                let cap = ball(*radius_m).into_iter();
                // The ring around is of both caps.
                let cap = cap.filter(move |at| end * at.z > -EQUATOR * radius_m);
                cap.map(move |at| at + Vector3::z() * end * *half_length_m)
            })
            .collect(),
        UrdfPrimitive::Sphere { radius_m } => ball(*radius_m),
    }
}

fn ring(radius_m: f64, z_m: f64) -> impl Iterator<Item = Vector3<f64>> {
    (0..CORNERS).map(move |corner| {
        let (sin, cos) = (TAU * corner as f64 / CORNERS as f64).sin_cos();
        Vector3::new(radius_m * cos, radius_m * sin, z_m)
    })
}

/// Points of a sphere: its poles, and rings between.
fn ball(radius_m: f64) -> Vec<Vector3<f64>> {
    let poles = [-radius_m, radius_m].map(|z_m| Vector3::new(0.0, 0.0, z_m));
    let rings = (1..CORNERS / 2).flat_map(|of| {
        let (sin, cos) = (TAU * of as f64 / CORNERS as f64).sin_cos();
        ring(radius_m * sin, radius_m * cos)
    });
    poles.into_iter().chain(rings).collect()
}
