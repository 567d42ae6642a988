//! The daemon from outside: takes, previews, viewers, kills, journals, and every call of the system that may fail.

mod capture;
mod faults;
mod harness;
mod journals;
mod recover;
mod served;
#[path = "../support/skip.rs"]
mod skip;
