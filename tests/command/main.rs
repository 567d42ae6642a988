//! Commands from outside: what they print, where, with which exit code, and what they leave alone.

mod cli;
mod deadlines;
mod golden;
mod hands;
mod impacts;
mod inputs;
mod landings;
mod lasting;
mod laws;
mod phases;
mod pivots;
#[path = "../support/program.rs"]
mod program;
mod seen;
mod several;
mod shell;
#[path = "../support/skip.rs"]
mod skip;
mod sticking;
mod terminal;
mod tumbles;
