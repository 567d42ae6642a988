//! Marks of collisions, and the segments between them.

mod counted;
mod event_times;
mod mark;
mod marks;
#[path = "../support/program.rs"]
mod program;
mod segments;
