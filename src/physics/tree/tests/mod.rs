//! Trees against formulas, against each other and against differences.

mod accelerations;
mod examples;
mod flow;
mod forms;
mod links;
mod motions;
mod refusals;
