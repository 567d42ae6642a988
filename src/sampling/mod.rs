//! A motion becomes frames: stamped poses of every body at a rate, from which files, viewers and live
//! streams are made. Nothing here knows in what they are written.
//!
//! [`SampledMotion`] has all of a motion: the estimated flights and what is simulated after them, and
//! the performance at its physical times. [`frames`] makes them body by body.

pub mod error;
pub mod frames;
pub mod motion;

pub use error::SamplingError;
pub use frames::{estimate_frames, sketch_frames, stamp, zero};
pub use motion::SampledMotion;
