//! Motions of bodies from performances: exact, robust, certain, with goals of every kind.

mod accuracy;
mod aliased;
mod along;
mod bounded;
mod brief_flights;
mod covariance;
mod cube_toss;
mod few_poses;
mod few_samples;
mod goals;
mod held;
mod parts;
mod preview;
mod recipe;
mod rest;
mod right_answer;
mod search;
#[path = "../support/skip.rs"]
mod skip;
mod small_dice;
mod stress;
mod tempo;
mod wanders;
mod waypoints;
mod waypoints_said;
