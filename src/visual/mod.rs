//! What of a scene is drawn, where and in which colour, apart from the formats in which it is said.
//!
//! [`visuals`](visuals()) lists bodies, obstacles, surfaces and goals with their shapes; [`primitives`] takes a
//! shape apart into boxes, balls, cones' frusta and triangles, and [`mesh`](mesh()) covers any with
//! triangles. Scene updates and URDF are written from these.

pub mod mesh;
pub mod primitive;
pub mod visuals;

pub use mesh::{Triangle, mesh};
pub use primitive::{Form, Primitive, bounding_box, cone_slices, primitives};
pub use visuals::{GHOST_RGBA, Subject, Visual, surface_side_m, visuals};
