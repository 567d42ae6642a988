//! Shapes of bodies: mass properties and distances. The only module that imports parry. Axes of
//! cylinders, capsules and cones are z here and y in parry.
//!
//! A shape's own axes have their origin at its centre of mass, so that for a body of uniform
//! density they are the body's axes.

mod error;
mod hull;
mod inside;
mod kind;
mod mass;
mod mesh;
mod revolution;
mod solid;
#[cfg(test)]
mod tests;

pub use error::ShapeError;
pub use hull::hull_triangles;
pub use kind::{Compound, Part, Shape};
pub use mass::{MOMENT_TOLERANCE, MassDistribution, UniformMass, equalise};
pub use mesh::TriangleMesh;
pub use revolution::Revolution;
pub use solid::{Closest, Solid};
