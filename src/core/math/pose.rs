//! Rigid transforms.

/// A rigid transform, named by its frames: `world_from_body`.
pub type Pose = nalgebra::Isometry3<f64>;
