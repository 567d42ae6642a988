//! Pairs of features that may touch.

use nalgebra::Vector3;

use super::error::ContactError;
use super::feature::Feature;

/// Cosine of the angle between normals, and distance \[m\] between planes, of faces that are the same.
const SAME_DIRECTION: f64 = 0.9999;
const SAME_M: f64 = 1e-5;

/// A pair of features that may touch: one of a body A, one of a body B or of the static world.
///
/// Supported are point–face, rim–face, point–point, point–line, each in either order, and
/// line–line. Points and lines may be rounded; point–point and point–line need a radius on at
/// least one. Lines and faces are infinite as geometry: the caller checks whether the contact lies
/// within an edge or a face, and whether another feature would have touched first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    a: Feature,
    b: Feature,
    pub(super) pair: Pair,
    /// Whether `pair` holds B's feature first.
    pub(super) mirrored: bool,
    pub(super) tangents: Option<[Vector3<f64>; 2]>,
}

/// A point and the ball about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ball {
    pub(super) centre_m: Vector3<f64>,
    pub(super) radius_m: f64,
}

/// A line and the tube about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tube {
    pub(super) point_m: Vector3<f64>,
    pub(super) direction: Vector3<f64>,
    pub(super) radius_m: f64,
}

/// A plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    pub(super) point_m: Vector3<f64>,
    pub(super) normal: Vector3<f64>,
}

/// A circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Circle {
    pub(super) centre_m: Vector3<f64>,
    pub(super) axis: Vector3<f64>,
    pub(super) radius_m: f64,
}

/// The pairs whose geometry is written out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pair {
    PointFace(Ball, Plane),
    RimFace(Circle, Plane),
    PointPoint(Ball, Ball),
    PointLine(Ball, Tube),
    LineLine(Tube, Tube, Outward),
}

/// To which side the normal of two lines points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Outward {
    /// To that of A's centre of mass.
    Centre,
    /// From B's line to A's.
    Apart,
    /// Along `dA × dB` of their directions times this sign.
    Crossed(f64),
}

impl Contact {
    /// The contact of A's feature with B's, each in its body's axes; features of the static world
    /// are in world axes.
    ///
    /// Fails where a feature is malformed ([`Feature::check`]), where the pair is not supported
    /// (the error says what to use in its place), and where both features are sharp, so that there
    /// is no normal.
    pub fn new(a: Feature, b: Feature) -> Result<Self, ContactError> {
        a.check()?;
        b.check()?;
        let (pair, mirrored) = match pair(&a, &b)? {
            Some(pair) => (pair, false),
            None => match pair(&b, &a)? {
                Some(pair) => (pair, true),
                None => {
                    return Err(ContactError::Pair {
                        a: a.kind(),
                        b: b.kind(),
                        instead: instead(&a, &b),
                    });
                }
            },
        };
        let tangents = match b {
            Feature::Face { normal, .. } => Some(Feature::tangents(&normal)),
            _ => None,
        };
        Ok(Self {
            a,
            b,
            pair,
            mirrored,
            tangents,
        })
    }

    /// A's feature.
    pub fn a(&self) -> &Feature {
        &self.a
    }

    /// B's feature.
    pub fn b(&self) -> &Feature {
        &self.b
    }

    /// Whether another contact of the same two bodies is with the same face of either, of a convex solid: two features of the
    /// one may be at a face of the other at the same time.
    pub fn shares_face(&self, other: &Self) -> bool {
        let is_same = |one: &Feature, another: &Feature| match (*one, *another) {
            (
                Feature::Face { point_m, normal },
                Feature::Face {
                    point_m: other_m,
                    normal: other_normal,
                },
            ) => {
                let off_m = normal.dot(&(other_m - point_m));
                normal.dot(&other_normal) > SAME_DIRECTION && off_m.abs() < SAME_M
            }
            _ => false,
        };
        is_same(&self.a, &other.a) || is_same(&self.b, &other.b)
    }

    /// The axes about which the normal may be tilted: two unit tangents of B's face, in B's
    /// axes. `None` where B's feature is no face.
    pub fn tilt_axes(&self) -> Option<&[Vector3<f64>; 2]> {
        self.tangents.as_ref()
    }
}

/// The pair in this order, if it is supported in this order.
fn pair(a: &Feature, b: &Feature) -> Result<Option<Pair>, ContactError> {
    Ok(Some(match (primitive(a), primitive(b)) {
        (ContactPrimitive::Ball(ball), ContactPrimitive::Plane(plane)) => {
            Pair::PointFace(ball, plane)
        }
        (ContactPrimitive::Circle(circle), ContactPrimitive::Plane(plane)) => {
            Pair::RimFace(circle, plane)
        }
        (ContactPrimitive::Ball(p), ContactPrimitive::Ball(q)) => {
            rounded(a, b, p.radius_m + q.radius_m)?;
            Pair::PointPoint(p, q)
        }
        (ContactPrimitive::Ball(p), ContactPrimitive::Tube(q)) => {
            rounded(a, b, p.radius_m + q.radius_m)?;
            Pair::PointLine(p, q)
        }
        (ContactPrimitive::Tube(p), ContactPrimitive::Tube(q)) => {
            let foot = p.point_m - p.direction * p.direction.dot(&p.point_m);
            let centre_is_outside = foot.norm() > p.radius_m;
            if !centre_is_outside && p.radius_m + q.radius_m == 0.0 {
                return Err(ContactError::LineThroughCentre);
            }
            let outward = if centre_is_outside {
                Outward::Centre
            } else {
                Outward::Apart
            };
            Pair::LineLine(p, q, outward)
        }
        _ => return Ok(None),
    }))
}

/// A feature as geometry.
enum ContactPrimitive {
    Ball(Ball),
    Tube(Tube),
    Circle(Circle),
    Plane(Plane),
}

fn primitive(feature: &Feature) -> ContactPrimitive {
    match *feature {
        Feature::Point { point_m, radius_m } => ContactPrimitive::Ball(Ball {
            centre_m: point_m,
            radius_m,
        }),
        Feature::Line {
            point_m,
            direction,
            radius_m,
        } => ContactPrimitive::Tube(Tube {
            point_m,
            direction,
            radius_m,
        }),
        Feature::Rim {
            centre_m,
            axis,
            radius_m,
        } => ContactPrimitive::Circle(Circle {
            centre_m,
            axis,
            radius_m,
        }),
        Feature::Face { point_m, normal } => ContactPrimitive::Plane(Plane { point_m, normal }),
    }
}

fn rounded(a: &Feature, b: &Feature, radius_m: f64) -> Result<(), ContactError> {
    if radius_m > 0.0 {
        return Ok(());
    }
    Err(ContactError::Sharp {
        a: a.kind(),
        b: b.kind(),
    })
}

/// What to use in place of a pair that is not supported.
fn instead(a: &Feature, b: &Feature) -> &'static str {
    match (a, b) {
        (Feature::Line { .. }, Feature::Face { .. })
        | (Feature::Face { .. }, Feature::Line { .. }) => {
            "use one end of the line as a point, or both ends at once where it lands flat"
        }
        (Feature::Face { .. }, Feature::Face { .. }) => {
            "use one corner of a face as a point, or three corners at once where it lands flat"
        }
        _ => "use the face that the rim bounds, or the side beside it as a line with a radius",
    }
}
