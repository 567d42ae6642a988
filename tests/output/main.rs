//! What goes out: exports, reports, predictions.

mod certainty;
mod files;
mod impacts;
mod predict;
mod problem;
#[path = "../support/program.rs"]
mod program;
mod report;
