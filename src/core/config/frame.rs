//! The frame in which a body is given, and the one in which it moves.
//!
//! A scene file gives a body in any frame. The core has the axes of a body at its centre of mass along
//! principal axes. Here the one is computed from the other; what the file gives of the body is turned into
//! link axes where it is read: shape, features, mounts, joints and goals.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::error::{Fault, fault};
use super::number::{positive, vector, vector_from_mm};
use super::principal::{ROUNDING, principal};
use super::raw::RawBody;
use super::solid::PlacedSolid;
use super::spanned::Spanned;
use crate::math::Pose;
use crate::physics::shape::{Compound, MOMENT_TOLERANCE, MassDistribution, Part, equalise};
use crate::physics::{Body, BodyError, Shape};

/// A body's inertia and where its link axes are.
pub(super) struct GivenInertia {
    pub(super) body: Body,
    /// The frame in which the body is given, in link axes.
    pub(super) link_from_given: Pose,
}

/// Lightest and heaviest body \[kg\].
const MASS_KG: std::ops::RangeInclusive<f64> = 1e-6..=1e4;

/// Where the solids of a body are in the frame in which it is given.
pub(super) struct GivenSolids<'a> {
    /// One, unless the body has parts; each with the mass that the file gives it.
    pub(super) placed: &'a [(PlacedSolid, Option<f64>)],
    /// What an error about all of them points at.
    pub(super) span: std::ops::Range<usize>,
}

/// Mass, principal moments and axes of a body that flies: those that are given, or computed.
pub(super) fn inertia(
    spanned: &Spanned<RawBody>,
    solids: &GivenSolids,
) -> Result<GivenInertia, Fault> {
    let raw = spanned.get_ref();
    let (mass_kg, mass_span) = mass(spanned, solids)?;
    if !MASS_KG.contains(&mass_kg) {
        return fault(
            mass_span,
            format!(
                "the body's mass is {mass_kg} kg, expected {:e} to {:e} kg: mass_g is in grams, mass_kg in kilograms",
                MASS_KG.start(),
                MASS_KG.end()
            ),
        );
    }
    let refused = |error: BodyError, given: std::ops::Range<usize>| Fault {
        span: match error {
            BodyError::Mass { .. } => mass_span.clone(),
            _ => given,
        },
        message: error.to_string(),
    };
    let (link_from_given, moments_kg_m2, at) = match (&raw.moments_kg_m2, &raw.inertia_kg_m2) {
        (Some(_), Some(tensor)) => {
            return fault(
                tensor.span(),
                "the moments are given twice, expected one of moments_kg_m2, inertia_kg_m2",
            );
        }
        (Some(moments), None) => {
            let centre_m = match &raw.centre_mm {
                Some(centre) => vector_from_mm("centre_mm", centre)?,
                None => Vector3::zeros(),
            };
            let moments_kg_m2 = vector("moments_kg_m2", moments)?;
            (shifted(centre_m), moments_kg_m2, moments.span())
        }
        (None, Some(tensor)) => {
            let (link_from_given, moments) = of_tensor(raw, tensor)?;
            (link_from_given, moments, tensor.span())
        }
        (None, None) => {
            if let Some(centre) = &raw.centre_mm {
                return fault(
                    centre.span(),
                    "centre_mm beside the centre that follows from shape and mass, expected it with inertia_kg_m2 or moments_kg_m2",
                );
            }
            let (link_from_given, moments_m2) = computed(solids)?;
            (link_from_given, moments_m2 * mass_kg, solids.span.clone())
        }
    };
    if raw.moments_kg_m2.is_some() || raw.inertia_kg_m2.is_some() {
        let radii = solids.placed.iter().map(|(of, _)| {
            let link_from_shape = link_from_given * of.given_from_shape;
            in_axes(&of.shape, &link_from_shape).radius_m()
        });
        let greatest_kg_m2 = mass_kg * radii.fold(0.0, f64::max).powi(2);
        if moments_kg_m2.max() > greatest_kg_m2 * (1.0 + 1e-9) {
            let key = match raw.moments_kg_m2 {
                Some(_) => "moments_kg_m2",
                None => "inertia_kg_m2",
            };
            return fault(
                at,
                format!(
                    "{key} has {} kg m², expected at most {greatest_kg_m2:e}: no {mass_kg} kg within this shape have more (lengths are in millimetres)",
                    moments_kg_m2.max()
                ),
            );
        }
    }
    let body = Body::new(mass_kg, moments_kg_m2).map_err(|error| refused(error, at))?;
    Ok(GivenInertia {
        body,
        link_from_given,
    })
}

/// The mass \[kg\] and its place: that of the body, or of all its parts.
fn mass(
    spanned: &Spanned<RawBody>,
    solids: &GivenSolids,
) -> Result<(f64, std::ops::Range<usize>), Fault> {
    let raw = spanned.get_ref();
    let of_parts: Vec<f64> = solids.placed.iter().filter_map(|(_, mass)| *mass).collect();
    let own = one_mass(
        "the body",
        [&raw.mass_g, &raw.mass_kg, &raw.density_kg_m3],
        || {
            let volumes = solids.placed.iter().map(|(of, _)| of.mass.volume_m3);
            volumes.sum()
        },
    )?;
    match (own, of_parts.len()) {
        (Some(own), 0) => Ok(own),
        (Some((_, span)), _) => fault(
            span,
            "a mass of the body beside those of its parts, expected one or the others",
        ),
        (None, 0) => fault(
            spanned.span(),
            "the body has no mass, expected one of mass_g, mass_kg, density_kg_m3",
        ),
        (None, count) if count < solids.placed.len() => fault(
            spanned.span(),
            format!(
                "{count} of the body's {} parts have a mass, expected all of them or the body alone",
                solids.placed.len()
            ),
        ),
        (None, _) => Ok((of_parts.iter().sum(), solids.span.clone())),
    }
}

/// The mass \[kg\] that one of three keys gives, in grams, in kilograms or as a density, with its place; `None`
/// where none is given.
pub(super) fn one_mass(
    what: &str,
    [mass_g, mass_kg, density_kg_m3]: [&Option<super::raw::Number>; 3],
    volume_m3: impl Fn() -> f64,
) -> Result<Option<(f64, std::ops::Range<usize>)>, Fault> {
    Ok(match (mass_g, mass_kg, density_kg_m3) {
        (Some(g), None, None) => Some((positive("mass_g", g)? / 1e3, g.span())),
        (None, Some(kg), None) => Some((positive("mass_kg", kg)?, kg.span())),
        (None, None, Some(density)) => {
            let density_kg_m3 = positive("density_kg_m3", density)?;
            Some((density_kg_m3 * volume_m3(), density.span()))
        }
        (None, None, None) => None,
        (_, _, Some(extra)) | (_, Some(extra), _) => {
            return fault(
                extra.span(),
                format!(
                    "{what}'s mass is given twice, expected only one of mass_g, mass_kg, density_kg_m3"
                ),
            );
        }
    })
}

/// Principal moments over mass from the solids, and the frame that this makes.
fn computed(solids: &GivenSolids) -> Result<(Pose, Vector3<f64>), Fault> {
    if let [(only, _)] = solids.placed
        && only.given_from_shape == Pose::identity()
        && only.is_filled
    {
        // To the last bit what the shape alone says.
        if let Ok(uniform) = only.shape.uniform_mass() {
            return Ok((Pose::identity(), uniform.moments_per_mass_m2));
        }
    }
    let parts = solids
        .placed
        .iter()
        .map(|(of, mass_kg)| (mass_kg.unwrap_or(of.mass.volume_m3), of.mass));
    let parts: Vec<(f64, MassDistribution)> = parts.collect();
    // The axes of a single solid stay its own where they are principal.
    let near = match solids.placed {
        [(only, _)] => only.given_from_shape.rotation,
        _ => UnitQuaternion::identity(),
    };
    let made = MassDistribution::joined(&parts).and_then(|whole| {
        Some((
            whole.centre_m,
            axes(&whole.tensor_m2, &near, MOMENT_TOLERANCE)?,
        ))
    });
    let Some((centre_m, (turn, moments_m2))) = made else {
        return fault(
            solids.span.clone(),
            "the shape has no volume, expected a solid",
        );
    };
    let given_from_link = Pose::from_parts(centre_m.into(), turn);
    Ok((given_from_link.inverse(), moments_m2))
}

/// Principal moments \[kg m²\] of a tensor that is given, and the frame that this makes.
fn of_tensor(raw: &RawBody, tensor: &Spanned<[f64; 6]>) -> Result<(Pose, Vector3<f64>), Fault> {
    let Some(centre) = &raw.centre_mm else {
        return fault(
            tensor.span(),
            "inertia_kg_m2 is about the centre of mass, expected centre_mm beside it",
        );
    };
    let centre_m = vector_from_mm("centre_mm", centre)?;
    let [xx, yy, zz, xy, xz, yz] = *tensor.get_ref();
    let matrix = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let Some((turn, moments)) = axes(&matrix, &UnitQuaternion::identity(), ROUNDING) else {
        return fault(
            tensor.span(),
            "inertia_kg_m2 has no principal axes, expected xx, yy, zz, xy, xz, yz: six finite numbers, not all zero",
        );
    };
    let given_from_link = Pose::from_parts(centre_m.into(), turn);
    Ok((given_from_link.inverse(), moments))
}

fn axes(
    tensor: &Matrix3<f64>,
    near: &UnitQuaternion<f64>,
    equal: f64,
) -> Option<(UnitQuaternion<f64>, Vector3<f64>)> {
    let (turn, mut moments) = principal(tensor, near, equal)?;
    let none = equal * moments.max();
    equalise(&mut moments, none);
    Some((turn, moments))
}

/// The frame of a body whose centre of mass is there, along its axes.
fn shifted(centre_m: Vector3<f64>) -> Pose {
    Pose::from_parts((-centre_m).into(), UnitQuaternion::identity())
}

/// A shape in other axes: itself where they are its own.
pub(super) fn in_axes(shape: &Shape, axes_from_shape: &Pose) -> Shape {
    let is_near = axes_from_shape.translation.vector.norm() <= 1e-12
        && axes_from_shape.rotation.angle() <= 1e-12;
    match shape {
        _ if is_near => shape.clone(),
        Shape::Hull { points_m } => {
            let points = points_m.iter();
            let points = points.map(|p| axes_from_shape.transform_point(&(*p).into()).coords);
            Shape::Hull {
                points_m: points.collect(),
            }
        }
        Shape::Compound(compound) => Shape::Compound(compound.placed(axes_from_shape)),
        // Others lie along axes of their own.
        other => {
            let features = other.features().unwrap_or_default().into_iter();
            let features = features.map(|(name, of)| (name, of.placed(axes_from_shape)));
            Shape::Compound(Compound {
                features: features.collect(),
                parts: vec![Part {
                    shape: other.clone(),
                    compound_from_shape: *axes_from_shape,
                }],
            })
        }
    }
}
