//! The performances with known truth that everything is measured on: they obey physics, and are acted as badly as they say.

mod acting;
mod drawn;
mod hand;
mod kinks;
mod objects;
mod scenes;
#[path = "../support/skip.rs"]
mod skip;
mod truths;
