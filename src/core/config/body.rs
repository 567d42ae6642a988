//! Bodies: shape, mass, tracker, features.

use nalgebra::{UnitQuaternion, Vector3};

use super::error::{Fault, fault};
use super::frame::{GivenSolids, in_axes, inertia, one_mass};
use super::held::held;
use super::number::{direction, finite, name, not_negative, unique, vector, vector_from_mm};
use super::raw::{Number, RawBody};
use super::solid::{PlacedSolid, SizeLimits, shape};
use super::spanned::Spanned;
use super::track::tracks;
use crate::math::Pose;
use crate::motion::{Feature, FreeBody, Track, Weights};
use crate::physics::body::Symmetry;
use crate::physics::shape::{Compound, Part, Solid};
use crate::physics::{Body, Drag, Shape, contact};

/// How deep a point is at least that is inside another part \[m\].
const SAME_M: f64 = 1e-7;

/// Sizes of bodies: objects that a hand can act with.
const SIZE: SizeLimits = SizeLimits {
    least_m: 1e-4,
    greatest_m: 100.0,
};

/// A checked body with all its tracks, and the first of them in the body itself; and the frame in which the file
/// gives it, in link axes.
pub(super) fn body(
    spanned: &Spanned<RawBody>,
    weights: &Weights,
) -> Result<(FreeBody, Vec<Track>, Pose), Fault> {
    let raw = spanned.get_ref();
    let name = name("body", &raw.name)?;
    let (placed, names) = solids(spanned)?;
    let span = raw.shape.as_ref().map_or(spanned.span(), Spanned::span);
    let solids = GivenSolids {
        placed: &placed,
        span: span.clone(),
    };
    let (body, link_from_given) = match held(spanned)? {
        Some(_) => (Body::IMMOVABLE, Pose::identity()),
        None => {
            let of = inertia(spanned, &solids)?;
            (in_air(raw, of.body)?, of.link_from_given)
        }
    };
    let shape = whole(&solids, &names, &link_from_given);
    let mut features = features(raw, &link_from_given)?;
    add_own(&shape, &mut features);
    let tracks = tracks(raw, &name, &features, &link_from_given, weights)?;
    let body = FreeBody {
        name,
        topic: tracks
            .first()
            .map_or_else(String::new, |of| of.topic.clone()),
        body,
        shape,
        body_from_tracker: tracks
            .first()
            .map_or(link_from_given, |of| of.link_from_tracker),
        features,
    };
    Ok((body, tracks, link_from_given))
}

/// A solid with the mass that the file gives it.
type Massive = (PlacedSolid, Option<f64>);

/// The solids of a body, and their names where it has parts.
fn solids(spanned: &Spanned<RawBody>) -> Result<(Vec<Massive>, Vec<String>), Fault> {
    let raw = spanned.get_ref();
    match (&raw.shape, raw.part.first()) {
        (Some(only), None) => Ok((vec![(shape("the body", only, &SIZE)?, None)], Vec::new())),
        (None, None) => fault(
            spanned.span(),
            "missing key `shape`: a body needs it, or [[body.part]]",
        ),
        (Some(shape), Some(_)) => fault(
            shape.span(),
            "shape beside [[body.part]], expected one of them",
        ),
        (None, Some(_)) => {
            let (mut placed, mut names) = (Vec::new(), Vec::<String>::new());
            for part in &raw.part {
                let part = part.get_ref();
                let name = name("part", &part.name)?;
                unique("part", &part.name, &name, names.iter().map(String::as_str))?;
                let solid = shape("the part", &part.shape, &SIZE)?;
                let keys = [&part.mass_g, &part.mass_kg, &part.density_kg_m3];
                let mass = one_mass("the part", keys, || solid.mass.volume_m3)?;
                placed.push((solid, mass.map(|(mass_kg, _)| mass_kg)));
                names.push(name);
            }
            Ok((placed, names))
        }
    }
}

/// The shape of a body in link axes: of parts all together, with those of their features that are not inside
/// another part.
fn whole(solids: &GivenSolids, names: &[String], link_from_given: &Pose) -> Shape {
    let placed = solids.placed.iter();
    let mut shapes = placed.map(|(of, _)| {
        let link_from_shape = link_from_given * of.given_from_shape;
        (&of.shape, link_from_shape)
    });
    if names.is_empty()
        && let Some((shape, link_from_shape)) = shapes.next()
    {
        return in_axes(shape, &link_from_shape);
    }
    let shapes: Vec<(&Shape, Pose)> = shapes.collect();
    let ball = Solid::ball(0.0);
    let is_inside = |of: usize, feature: &contact::Feature| {
        let contact::Feature::Point { point_m, .. } = feature else {
            return false;
        };
        let at = Pose::from_parts((*point_m).into(), UnitQuaternion::identity());
        let others = shapes.iter().enumerate().filter(|(index, _)| *index != of);
        let mut others = others.filter_map(|(_, (shape, pose))| Some((shape.solid().ok()?, pose)));
        others.any(|(solid, pose)| {
            let depth_m = solid.distance_m(pose, &ball, &at);
            depth_m.is_ok_and(|depth_m| depth_m < -SAME_M)
        })
    };
    let (mut parts, mut features) = (Vec::new(), Vec::new());
    for (index, (shape, link_from_shape)) in shapes.iter().enumerate() {
        for (name, feature) in shape.features().unwrap_or_default() {
            let feature = feature.placed(link_from_shape);
            if !is_inside(index, &feature) {
                features.push((format!("{}/{name}", names[index]), feature));
            }
        }
        match shape {
            Shape::Compound(compound) => parts.extend(compound.placed(link_from_shape).parts),
            other => parts.push(Part {
                shape: (*other).clone(),
                compound_from_shape: *link_from_shape,
            }),
        }
    }
    Shape::Compound(Compound { parts, features })
}

/// The corners in alphabetical order, then the faces as they are written.
fn features(raw: &RawBody, link_from_given: &Pose) -> Result<Vec<Feature>, Fault> {
    let placed = |geometry: contact::Feature| match *link_from_given == Pose::identity() {
        true => geometry,
        false => geometry.placed(link_from_given),
    };
    let mut features: Vec<Feature> = Vec::new();
    for (text, point) in &raw.features_mm {
        let name = name("feature", text)?;
        let point_m = vector_from_mm(&format!("feature {name:?}"), point)?;
        let geometry = placed(contact::Feature::corner(point_m));
        features.push(Feature { name, geometry });
    }
    for face in &raw.face {
        let name = name("face", &face.name)?;
        let taken = features.iter().map(|feature| feature.name.as_str());
        unique("feature", &face.name, &name, taken)?;
        let geometry = placed(contact::Feature::face(
            vector_from_mm("point_mm", &face.point_mm)?,
            direction("normal", &face.normal)?,
        ));
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
pub(super) fn is_same(a: &contact::Feature, b: &contact::Feature) -> bool {
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

/// The body with the force, drag and lift that are given.
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
    let lift = raw.lift.as_ref().map(|of| finite("lift", of)).transpose()?;
    let is_round = body.symmetry() == Symmetry::Spherical;
    if let (Some(of), false) = (&raw.lift, is_round) {
        return fault(
            of.span(),
            "only a ball is lifted, a body whose three moments are equal: expected no lift of this one",
        );
    }
    let body = body
        .with_force(force_m_s2)
        .and_then(|body| body.with_drag(drag))
        .and_then(|body| body.with_lift(lift.unwrap_or(0.0)));
    Ok(body.expect("checked numbers"))
}
