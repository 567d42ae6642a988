//! A motion as one picture, as if a lamp flashed while it was open: bodies at equal steps of time along their
//! ways, the performance beside them as a ghost, and what they touch.

mod draw;
mod file;
mod items;
mod layout;
mod lit;
mod plan;
mod play;

pub use layout::Size;
pub use lit::Strobe;
