//! `enact`: acting capture.

#![forbid(unsafe_code)]

pub mod cli;
pub mod config;
pub mod estimate;
pub mod ingest;
pub mod initialise;
pub mod math;
pub mod motion;
pub mod physics;
pub mod pipeline;
pub mod segment;
pub mod service;
pub mod verify;
pub mod wire;
pub mod write;
