//! URDF → the text of a scene: the mechanism of a robot description as `[[body]]` and `[[joint]]`
//! ([`scene_from_urdf`]).
//!
//! | file | what it does |
//! |---|---|
//! | `element` | XML elements, their attributes and numbers; what is not read is noted |
//! | `robot` | links and joints as they are written |
//! | `geometry` | solids of links |
//! | `solid` | solids of a link as the one shape of its body |
//! | `mechanism` | links and joints become bodies and joints; those without mass merge |
//! | `merge` | axes that meet become one joint |
//! | `text` | bodies and joints become TOML |
//! | `import` | all in a row |
//!
//! The form is that of <https://wiki.ros.org/urdf/XML>.

mod element;
mod geometry;
mod import;
mod mechanism;
mod merge;
mod robot;
mod solid;
mod text;

pub use import::{UrdfScene, scene_from_urdf};
