//! Shapes: the one door to parry. Axes of cylinders, capsules and cones are z here, y there.

use nalgebra::Vector3;
use thiserror::Error;

/// A solid, in its own axes, in metres.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A box centred at the origin.
    Cuboid {
        /// Half its sides.
        half_extents_m: Vector3<f64>,
    },
    /// A ball centred at the origin.
    Sphere {
        /// Radius.
        radius_m: f64,
    },
    /// A cylinder about z, centred at the origin.
    Cylinder {
        /// Half its length.
        half_length_m: f64,
        /// Radius.
        radius_m: f64,
    },
    /// A capsule about z, centred at the origin.
    Capsule {
        /// Half the length between the centres of its caps.
        half_length_m: f64,
        /// Radius.
        radius_m: f64,
    },
    /// A cone about z, apex up, origin half way.
    Cone {
        /// Half its height.
        half_height_m: f64,
        /// Radius of the base.
        radius_m: f64,
    },
    /// The convex hull of points.
    Hull {
        /// At least four, not in one plane.
        points_m: Vec<Vector3<f64>>,
    },
}

/// Why a shape cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ShapeError {
    /// A length is not positive.
    #[error("{name} is {value_m} m, expected a positive number")]
    Length {
        /// Which one.
        name: &'static str,
        /// As given.
        value_m: f64,
    },
    /// Points span no volume.
    #[error("the {count} points of the hull span no volume")]
    Flat {
        /// How many.
        count: usize,
    },
}
