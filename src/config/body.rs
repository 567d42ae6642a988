//! Bodies: shape, mass, tracker, features.

use std::ops::RangeInclusive;

use nalgebra::Vector3;
use toml::Spanned;

use super::error::{Fault, fault};
use super::held::held;
use super::number::{direction, name, not_negative, positive, unique, vector, vector_from_mm};
use super::raw::{Number, RawBody, RawShape};
use super::solid::{SizeLimits, shape};
use super::track::tracks;
use crate::math::Pose;
use crate::motion::{Feature, FreeBody, Track, Weights};
use crate::physics::{Body, BodyError, Drag, Shape, ShapeError, contact};

/// Sizes of bodies: objects that a hand can act with.
const SIZE: SizeLimits = SizeLimits {
    least_m: 1e-4,
    greatest_m: 100.0,
};

/// Lightest and heaviest body \[kg\].
const MASS_KG: RangeInclusive<f64> = 1e-6..=1e4;

/// A checked body with all its tracks, and the first of them in the body itself.
pub(super) fn body(
    spanned: &Spanned<RawBody>,
    weights: &Weights,
) -> Result<(FreeBody, Vec<Track>), Fault> {
    let raw = spanned.get_ref();
    let name = name("body", &raw.name)?;
    let shape = shape("the body", &raw.shape, &SIZE)?;
    let body = match held(spanned)? {
        Some(_) => Body::IMMOVABLE,
        None => in_air(raw, mass_and_moments(spanned, &raw.shape, &shape)?)?,
    };
    let mut features = features(raw)?;
    add_own(&shape, &mut features);
    let tracks = tracks(raw, (&name, &features), weights)?;
    let body = FreeBody {
        name,
        topic: tracks
            .first()
            .map_or_else(String::new, |of| of.topic.clone()),
        body,
        shape,
        body_from_tracker: tracks
            .first()
            .map_or_else(Pose::identity, |of| of.link_from_tracker),
        features,
    };
    Ok((body, tracks))
}

/// The corners in alphabetical order, then the faces as they are written.
fn features(raw: &RawBody) -> Result<Vec<Feature>, Fault> {
    let mut features: Vec<Feature> = Vec::new();
    for (text, point) in &raw.features_mm {
        let name = name("feature", text)?;
        let point_m = vector_from_mm(&format!("feature {name:?}"), point)?;
        let geometry = contact::Feature::corner(point_m);
        features.push(Feature { name, geometry });
    }
    for face in &raw.face {
        let name = name("face", &face.name)?;
        let taken = features.iter().map(|feature| feature.name.as_str());
        unique("feature", &face.name, &name, taken)?;
        let geometry = contact::Feature::face(
            vector_from_mm("point_mm", &face.point_mm)?,
            direction("normal", &face.normal)?,
        );
        features.push(Feature { name, geometry });
    }
    Ok(features)
}

/// Appends the shape's own features, except those that are declared already under a name.
fn add_own(shape: &Shape, features: &mut Vec<Feature>) {
    let own = shape.features().unwrap_or_default();
    let own = own
        .into_iter()
        .map(|(name, geometry)| Feature { name, geometry });
    for feature in own {
        let is_known = |known: &Feature| {
            known.name == feature.name || is_same(&known.geometry, &feature.geometry)
        };
        if !features.iter().any(is_known) {
            features.push(feature);
        }
    }
}

/// Whether two features are equal to the precision of typed numbers.
fn is_same(a: &contact::Feature, b: &contact::Feature) -> bool {
    const DIGITS: f64 = 1e-7;
    let numbers = |feature: &contact::Feature| match *feature {
        contact::Feature::Point { point_m, radius_m } => (point_m, Vector3::zeros(), radius_m),
        contact::Feature::Line {
            point_m,
            direction,
            radius_m,
        } => (point_m, direction, radius_m),
        contact::Feature::Rim {
            centre_m,
            axis,
            radius_m,
        } => (centre_m, axis, radius_m),
        // Any point of the face describes the same face.
        contact::Feature::Face { point_m, normal } => (normal * normal.dot(&point_m), normal, 0.0),
    };
    let (a_numbers, b_numbers) = (numbers(a), numbers(b));
    a.kind() == b.kind()
        && (a_numbers.0 - b_numbers.0).norm() < DIGITS
        && (a_numbers.1 - b_numbers.1).norm() < DIGITS
        && (a_numbers.2 - b_numbers.2).abs() < DIGITS
}

/// The body with the force and drag that are given.
fn in_air(raw: &RawBody, body: Body) -> Result<Body, Fault> {
    let force_m_s2 = match &raw.force_m_s2 {
        Some(force) => vector("force_m_s2", force)?,
        None => Vector3::zeros(),
    };
    let number = |key: &str, number: &Option<Number>| match number {
        Some(number) => not_negative(key, number),
        None => Ok(0.0),
    };
    let drag = Drag {
        linear_per_s: number("drag_linear_per_s", &raw.drag_linear_per_s)?,
        quadratic_per_m: number("drag_quadratic_per_m", &raw.drag_quadratic_per_m)?,
    };
    let body = body
        .with_force(force_m_s2)
        .and_then(|body| body.with_drag(drag));
    Ok(body.expect("checked numbers"))
}

/// Exactly one of the three keys for mass; moments from the shape unless they are given.
fn mass_and_moments(
    spanned: &Spanned<RawBody>,
    raw_shape: &Spanned<RawShape>,
    shape: &Shape,
) -> Result<Body, Fault> {
    let raw = spanned.get_ref();
    let at_shape = |error: ShapeError| Fault {
        span: raw_shape.span(),
        message: error.to_string(),
    };
    let (mass_kg, mass_span) = match (&raw.mass_g, &raw.mass_kg, &raw.density_kg_m3) {
        (Some(g), None, None) => (positive("mass_g", g)? / 1e3, g.span()),
        (None, Some(kg), None) => (positive("mass_kg", kg)?, kg.span()),
        (None, None, Some(density)) => {
            let volume_m3 = shape.uniform_mass().map_err(at_shape)?.volume_m3;
            (
                positive("density_kg_m3", density)? * volume_m3,
                density.span(),
            )
        }
        (None, None, None) => {
            return fault(
                spanned.span(),
                "the body has no mass, expected one of mass_g, mass_kg, density_kg_m3",
            );
        }
        (_, _, Some(extra)) | (_, Some(extra), _) => {
            return fault(
                extra.span(),
                "the body's mass is given twice, expected only one of mass_g, mass_kg, density_kg_m3",
            );
        }
    };
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
    let Some(given) = &raw.moments_kg_m2 else {
        return shape.body_of_mass_kg(mass_kg).map_err(at_shape);
    };
    let moments_kg_m2 = vector("moments_kg_m2", given)?;
    let greatest_kg_m2 = mass_kg * shape.radius_m().powi(2);
    if moments_kg_m2.max() > greatest_kg_m2 * (1.0 + 1e-9) {
        return fault(
            given.span(),
            format!(
                "moments_kg_m2 has {} kg m², expected at most {greatest_kg_m2:e}: no {mass_kg} kg within this shape have more (lengths are in millimetres)",
                moments_kg_m2.max()
            ),
        );
    }
    Body::new(mass_kg, moments_kg_m2).map_err(|error| Fault {
        span: match error {
            BodyError::Mass { .. } => mass_span,
            _ => given.span(),
        },
        message: error.to_string(),
    })
}
