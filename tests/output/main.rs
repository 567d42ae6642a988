//! What goes out: exports, reports, predictions.

mod certainty;
mod files;
mod predict;
mod problem;
#[path = "../support/program.rs"]
mod program;
mod report;
