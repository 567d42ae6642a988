//! The motion of an estimate's file, for programs that do not read MCAP.
//!
//! [`motion`] reads back what an estimate added to a recording, [`frames`] puts it on a grid of frames with keys
//! where the motion has kinks, [`gltf`] makes a binary glTF of that and of what there is to draw, [`tables`] CSV
//! and TUM trajectories, [`events_csv`] a table of events, [`mod@bvh`] a skeleton with frames, [`mod@ros2`] a recording
//! of ROS 2's profile. All are functions of the file and of the wishes alone. `docs/export.md` says what is in each.

mod buffer;
pub mod bvh;
mod document;
mod events;
pub mod frames;
pub mod gltf;
pub mod motion;
mod names;
pub mod ros2;
pub mod tables;
mod verdict;

pub use bvh::bvh;
pub use events::events_csv;
pub use frames::{
    ExportedBody, Key, acted_at, deviation_at, exported_bodies, fastest_turn_rad_s, motion_at,
};
pub use gltf::glb;
pub use motion::{WrittenMotion, scene_of_estimate};
pub use ros2::ros2;
pub use tables::{csv, tum};
pub use verdict::WrittenVerdict;
