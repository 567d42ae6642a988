//! Shapes: the one door to parry. Axes of cylinders, capsules and cones are z here, y there.
//!
//! A shape's own axes have their origin at its centre of mass, so that the shape of a body of
//! uniform density lies in body axes as it stands.

mod error;
mod hull;
mod kind;
mod mass;
mod solid;
#[cfg(test)]
mod tests;

pub use error::ShapeError;
pub use hull::hull_triangles;
pub use kind::Shape;
pub use mass::UniformMass;
pub use solid::{Closest, Solid};
