//! The core of `enact`: texts of scenes and events of takes go in, checked estimates come out.
//!
//! There are no files, no sockets, no clock, no threads, no printing and no logging here, and the same take gives the same bits.
//! The crate `enact` stands on it, shows these rooms as its own, and says how they hang together.

#![forbid(unsafe_code)]

pub mod calibrate;
pub mod config;
pub mod estimate;
pub mod initialise;
pub mod jointly;
pub mod math;
pub mod motion;
pub mod optimise;
pub mod physics;
pub mod pipeline;
pub mod segment;
pub mod settle;
pub mod verify;
