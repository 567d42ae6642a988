//! Trees against formulas, against each other and against differences.

mod accelerations;
mod air;
mod examples;
mod flow;
mod forms;
mod hand;
mod impacts;
mod links;
mod meetings;
mod motions;
mod refusals;
