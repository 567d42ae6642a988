//! Reasons why shapes are refused.

use nalgebra::Vector3;
use thiserror::Error;

use crate::physics::body::BodyError;

/// Why a shape cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ShapeError {
    /// A length is not positive.
    #[error("{name} is {value_m} m, expected a positive number")]
    Length {
        /// Name of the length.
        name: &'static str,
        /// Length as given.
        value_m: f64,
    },
    /// A rounding is too large for its box.
    #[error("the rounding of {radius_m} m leaves no box: half the least side is {half_m} m")]
    Rounding {
        /// Radius of the rounding.
        radius_m: f64,
        /// Half the least side.
        half_m: f64,
    },
    /// A point has a coordinate that is not finite.
    #[error("point {index} of the hull is not finite")]
    Point {
        /// Index of the point.
        index: usize,
    },
    /// Points span no volume.
    #[error("the {count} points of the hull span no volume")]
    Flat {
        /// How many.
        count: usize,
    },
    /// parry built no hull although the points span a volume.
    #[error("no convex hull of these {count} points: {reason}")]
    Hull {
        /// How many.
        count: usize,
        /// Its message.
        reason: String,
    },
    /// The origin of a body's axes is not its centre of mass.
    #[error(
        "the hull's centre of mass is at [{}, {}, {}] mm, expected the origin: subtract that from every point",
        .offset_m.x * 1e3, .offset_m.y * 1e3, .offset_m.z * 1e3
    )]
    OffCentre {
        /// Centre of mass in the shape's axes.
        offset_m: Vector3<f64>,
    },
    /// A body's axes are not principal.
    #[error(
        "the axes of the hull are not its principal ones (products of inertia per kg: yz {}, xz {}, xy {} m²): turn its points, or give moments_kg_m2",
        .products_m2.x, .products_m2.y, .products_m2.z
    )]
    NotPrincipal {
        /// Products of inertia over mass: yz, xz, xy.
        products_m2: Vector3<f64>,
    },
    /// A profile sweeps no solid of revolution.
    #[error("point {} of the profile {why}", .index + 1)]
    Profile {
        /// Index of the point.
        index: usize,
        /// What is wrong with it.
        why: &'static str,
    },
    /// A mesh is no closed surface.
    #[error(
        "the surface is not closed: {open} of its {edges} edges do not lie between two triangles with one outside; close it, or take its convex hull"
    )]
    Open {
        /// Such edges.
        open: usize,
        /// All.
        edges: usize,
    },
    /// A mesh lies inside of itself.
    #[error(
        "{:.0} % of the surface lie inside of other parts of it, whose volume would count twice: unite the parts (a boolean union), or take its convex hull",
        .share * 100.0
    )]
    Overlapping {
        /// Which share of the surface.
        share: f64,
    },
    /// A compound has no parts.
    #[error("the compound has no part with a volume, expected one at least")]
    NoPart,
    /// A part of a compound is one itself.
    #[error("a part of a compound is a compound itself, expected its parts")]
    Nested,
    /// A pose contains a number that is not finite.
    #[error("a pose is not finite")]
    Pose,
    /// Mass or density, or the moments that follow, are refused for a body.
    #[error(transparent)]
    Body(#[from] BodyError),
}
