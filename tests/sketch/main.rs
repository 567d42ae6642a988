//! Sketches: keyframes by hand, edited segments, files of them, times that are open.

mod edited;
mod keyframes;
mod open_times;
#[path = "../support/program.rs"]
mod program;
mod written;
