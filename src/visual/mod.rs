//! What of a scene is drawn, where and in which colour, apart from the formats in which it is said.
//!
//! [`visuals`](visuals()) lists bodies, obstacles, surfaces and goals with their shapes; [`primitives`] takes a
//! shape apart into boxes, balls, cones' frusta and triangles, and [`mesh`](mesh()) covers any with
//! triangles. Scene updates and URDF are written from these. [`camera`] looks at them from a direction, and
//! [`outline`](outline()) says what of a solid is seen from there: pictures are drawn of that.

pub mod camera;
pub mod mesh;
pub mod outline;
pub mod patch;
pub mod primitive;
pub mod visuals;

pub use camera::{Camera, View};
pub use mesh::{Triangle, mesh};
pub use outline::{Loop, Outline, SHADES, chain, outline, simplified};
pub use patch::{Patch, patches};
pub use primitive::{Form, Primitive, cone_slices, hull_slices, primitives};
pub use visuals::{GHOST_RGBA, Subject, Visual, body_rgba, visuals};
