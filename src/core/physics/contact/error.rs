//! Reasons why contacts are refused, and what to use in their place.

use thiserror::Error;

/// Why two features are refused as a contact.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ContactError {
    /// The pair has no single point of contact, or is not supported.
    #[error("a {a} against a {b} is not supported: {instead}")]
    Pair {
        /// Kind of the first.
        a: &'static str,
        /// Kind of the second.
        b: &'static str,
        /// What to use in its place.
        instead: &'static str,
    },
    /// Both are sharp: their contact has no normal of its own.
    #[error(
        "a sharp {a} against a sharp {b} has no normal: give one of them a radius, or use the face or the edge beside it"
    )]
    Sharp {
        /// Kind of the first.
        a: &'static str,
        /// Kind of the second.
        b: &'static str,
    },
    /// A sharp edge passes through its body's centre of mass, so that no side of it is the outside.
    #[error("a sharp line through its body's centre of mass has no outside: give it a radius")]
    LineThroughCentre,
    /// A coordinate is not finite.
    #[error("the place of a {kind} is not finite")]
    NotFinite {
        /// Kind of the feature.
        kind: &'static str,
    },
    /// A direction is no unit vector.
    #[error("the direction of a {kind} has length {length}, expected 1")]
    NotUnit {
        /// Kind of the feature.
        kind: &'static str,
        /// Length of the direction.
        length: f64,
    },
    /// A radius is negative, or a rim's not positive.
    #[error("the radius of a {kind} is {radius_m} m, expected {}", if *.kind == "rim" { "a positive number" } else { "zero or more" })]
    Radius {
        /// Kind of the feature.
        kind: &'static str,
        /// Radius as given.
        radius_m: f64,
    },
}

/// A pose in which the points that touch, or the normal, are not determined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Degenerate {
    /// A rim lies flat on a face: every point of it is the lowest.
    #[error("the rim lies flat on the face: it has no lowest point (use three points of it)")]
    FlatRim,
    /// Two lines are parallel: they touch along a length.
    #[error("the two lines are parallel: they have no one point of contact (use points of one)")]
    ParallelLines,
    /// Two centres coincide, or a centre lies on a line.
    #[error("the centres of the two features coincide: their contact has no normal")]
    Coincident,
}
