//! Bodies joined in trees, through the program.

mod adequacy;
mod air;
mod groups;
mod hand;
mod impacts;
mod keep_out;
mod landings;
mod laws;
mod meetings;
mod open;
mod outputs;
#[path = "../support/robot.rs"]
mod robot;
mod settle;
#[path = "../support/skip.rs"]
mod skip;
mod swings;
mod tempo;
mod times;
