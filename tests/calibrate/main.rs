//! Calibrations: how often their intervals hold the truth, and what the command writes.

mod command;
mod intervals;
mod performed;
