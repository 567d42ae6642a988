//! A motion becomes frames: stamped poses of every body at a rate, from which files, viewers and live
//! streams are made. Nothing here knows in what they are written.
//!
//! [`SampledMotion`] has all of a motion: the estimated flights and what is simulated after them, and
//! the performance at its physical times. [`frames`] makes them body by body, [`deviations`] says how certain they are, [`joints`] has the angles of
//! bodies that are joined, joint by joint as [`hinges`]; [`MovedBody`] tells states at any times.

pub mod deviations;
pub mod error;
pub mod frames;
pub mod hinges;
pub mod joints;
pub mod motion;
pub mod moving;

pub use deviations::{DeviationSample, deviation_frames};
pub use error::SamplingError;
pub use frames::{estimate_frames, make_signs_continuous, sketch_frames, stamp, zero};
pub use hinges::{hinge_angles, hinge_axes};
pub use joints::{JointSample, SampledJoints};
pub use motion::SampledMotion;
pub use moving::{MovedBody, seen_less_moving};
