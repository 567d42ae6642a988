//! The features of solids that may touch.

use nalgebra::{Point3, Vector3};

use super::error::ContactError;
use crate::math::Pose;

/// Greatest deviation of a direction's length from one: the rounding error of a normalised vector.
const UNIT_TOLERANCE: f64 = 1e-9;

/// Distance from a rim's axis below which all of the rim is equally near \[m\].
const ON_AXIS_M: f64 = 1e-6;

/// A part of a solid's surface that may touch another, in the solid's own axes.
///
/// Radii round a feature: a corner of radius `r` is the ball about it, a line of radius `r` the
/// side of a capsule or a cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Feature {
    /// A corner (radius 0), a ball, the cap of a capsule, the corner of a rounded box.
    Point {
        /// Its centre \[m\].
        point_m: Vector3<f64>,
        /// Its radius \[m\], zero or more.
        radius_m: f64,
    },
    /// A straight edge (radius 0), the side of a cylinder or a capsule; an infinite line as
    /// geometry.
    Line {
        /// A point on it \[m\].
        point_m: Vector3<f64>,
        /// Unit direction.
        direction: Vector3<f64>,
        /// Its radius \[m\], zero or more.
        radius_m: f64,
    },
    /// The rim of a flat end: of a cylinder, of a cone's base.
    Rim {
        /// Its centre \[m\].
        centre_m: Vector3<f64>,
        /// Unit axis, out of the solid.
        axis: Vector3<f64>,
        /// Its radius \[m\], positive.
        radius_m: f64,
    },
    /// A flat face; an infinite plane as geometry.
    Face {
        /// A point on it \[m\].
        point_m: Vector3<f64>,
        /// Unit normal, out of the solid.
        normal: Vector3<f64>,
    },
}

impl Feature {
    /// A sharp corner at a point \[m\].
    pub fn corner(point_m: Vector3<f64>) -> Self {
        Feature::Point {
            point_m,
            radius_m: 0.0,
        }
    }

    /// The face through a point \[m\] with that unit normal.
    pub fn face(point_m: Vector3<f64>, normal: Vector3<f64>) -> Self {
        Feature::Face { point_m, normal }
    }

    /// Two orthonormal tangents of a plane; the first is perpendicular to the axis along which the
    /// normal has its smallest component.
    pub fn tangents(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
        let least = Vector3::ith(normal.iamin(), 1.0);
        let first = normal.cross(&least).normalize();
        [first, normal.cross(&first)]
    }

    /// The feature in the axes in which its solid has the given pose.
    pub fn placed(&self, pose: &Pose) -> Self {
        let place = |point_m: Vector3<f64>| (pose * Point3::from(point_m)).coords;
        let turn = |direction: Vector3<f64>| pose.rotation * direction;
        match *self {
            Feature::Point { point_m, radius_m } => Feature::Point {
                point_m: place(point_m),
                radius_m,
            },
            Feature::Line {
                point_m,
                direction,
                radius_m,
            } => Feature::Line {
                point_m: place(point_m),
                direction: turn(direction),
                radius_m,
            },
            Feature::Rim {
                centre_m,
                axis,
                radius_m,
            } => Feature::Rim {
                centre_m: place(centre_m),
                axis: turn(axis),
                radius_m,
            },
            Feature::Face { point_m, normal } => Feature::Face {
                point_m: place(point_m),
                normal: turn(normal),
            },
        }
    }

    /// The feature displaced by `shift_m` \[m\].
    pub fn shifted(&self, shift_m: &Vector3<f64>) -> Self {
        self.placed(&Pose::translation(shift_m.x, shift_m.y, shift_m.z))
    }

    /// Its own point \[m\]: the centre of a point or a rim, the point given on a line or a face.
    pub fn place_m(&self) -> Vector3<f64> {
        match *self {
            Feature::Point { point_m, .. }
            | Feature::Line { point_m, .. }
            | Feature::Rim {
                centre_m: point_m, ..
            }
            | Feature::Face { point_m, .. } => point_m,
        }
    }

    /// The point nearest to another on the feature's skeleton (centre, axis, circle, plane), and the radius of the
    /// feature about it [m, its solid's axes].
    pub fn skeleton_m(&self, point_m: &Vector3<f64>) -> (Vector3<f64>, f64) {
        match *self {
            Feature::Point {
                point_m: centre_m,
                radius_m,
            } => (centre_m, radius_m),
            Feature::Line {
                point_m: on_line_m,
                direction,
                radius_m,
            } => {
                let along_m = direction.dot(&(point_m - on_line_m));
                (on_line_m + direction * along_m, radius_m)
            }
            Feature::Rim {
                centre_m,
                axis,
                radius_m,
            } => {
                let offset_m = point_m - centre_m;
                let radial_m = offset_m - axis * axis.dot(&offset_m);
                let outward = radial_m
                    .try_normalize(ON_AXIS_M)
                    .unwrap_or_else(|| axis.cross(&Vector3::ith(axis.iamin(), 1.0)).normalize());
                (centre_m + outward * radius_m, 0.0)
            }
            Feature::Face {
                point_m: on_face_m,
                normal,
            } => (point_m - normal * normal.dot(&(point_m - on_face_m)), 0.0),
        }
    }

    /// Distance of a point from the feature's surface [m, its solid's axes].
    pub fn distance_m(&self, point_m: &Vector3<f64>) -> f64 {
        let (skeleton_m, radius_m) = self.skeleton_m(point_m);
        ((point_m - skeleton_m).norm() - radius_m).abs()
    }

    /// Its kind as a word for messages.
    pub fn kind(&self) -> &'static str {
        match self {
            Feature::Point { .. } => "point",
            Feature::Line { .. } => "line",
            Feature::Rim { .. } => "rim",
            Feature::Face { .. } => "face",
        }
    }

    /// Fails where a number is not finite, the direction is no unit vector, or the radius is
    /// negative (of a rim: not positive).
    pub fn check(&self) -> Result<(), ContactError> {
        let kind = self.kind();
        let (direction, radius_m) = match *self {
            Feature::Point { radius_m, .. } => (None, radius_m),
            Feature::Line {
                direction,
                radius_m,
                ..
            } => (Some(direction), radius_m),
            Feature::Rim { axis, radius_m, .. } => (Some(axis), radius_m),
            Feature::Face { normal, .. } => (Some(normal), 0.0),
        };
        if !self.place_m().iter().all(|x| x.is_finite()) {
            return Err(ContactError::NotFinite { kind });
        }
        if let Some(length) = direction.map(|d| d.norm())
            && !((length - 1.0).abs() <= UNIT_TOLERANCE)
        {
            return Err(ContactError::NotUnit { kind, length });
        }
        let is_rim = matches!(self, Feature::Rim { .. });
        if !(radius_m.is_finite() && (radius_m > 0.0 || radius_m == 0.0 && !is_rim)) {
            return Err(ContactError::Radius { kind, radius_m });
        }
        Ok(())
    }
}
