//! The motion of a body in the hand: what its tracker saw, smoothed.
//!
//! A held body does not fly. Whatever hits it bounces off a body of infinite mass that moves as it
//! was tracked: the hand is stronger than the impact. Its motion is a curve through knots
//! ([`Knot`]), the poses, velocities and accelerations of the tracker that the smoother
//! ([`smooth`](crate::segment::smooth)) found at every sample; at its collisions there is their
//! covariance too. Times are acted times. Between two knots, positions are the polynomial of fifth
//! degree with their places, velocities and accelerations, the most likely path where the jerk is
//! white noise; rotations are the same in the tangent space of the earlier knot ([`jets`]).
//!
//! The body's own state ([`Mounted`]) follows from the tracker's by how the tracker is mounted and
//! by how fast acted time runs.

pub mod curve;
pub mod estimate;
pub mod grip;
pub mod jets;
pub mod knot;
pub mod mounted;
pub mod tracked;

pub use curve::Curve;
pub use estimate::{HeldEstimate, Passed};
pub use grip::GripEstimate;
pub use knot::{Driven, Knot, StateCovariance};
pub use mounted::Mounted;
pub use tracked::{HeldMotion, Meeting};
