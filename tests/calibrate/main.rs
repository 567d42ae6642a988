//! Calibrations: how often their intervals hold the truth, and what the command writes.

mod command;
mod fit;
mod fit_joined;
mod intervals;
mod performed;
