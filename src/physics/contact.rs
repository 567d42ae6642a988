//! Where two solids touch: the features that may meet.

use nalgebra::Vector3;

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
    /// A straight edge (radius 0), the side of a cylinder or a capsule; endless as geometry.
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
    /// A flat face; endless as geometry.
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
}
