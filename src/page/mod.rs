//! An estimate as a page that people open, and as pictures.
//!
//! [`html`] makes one file that needs nothing else: no net, no font, no script but the one that plays the motion. It has what `/estimate/report` says in
//! words, tables and small charts, and [`Strobe`] pictures of the motion beside the performance; these are files of
//! their own as well. Everything is a function of what was read and of the wishes: no clock, no random names.
//! Whatever a file calls its bodies and events is escaped.

mod advice;
mod certainty;
mod chart;
mod checks;
mod events;
mod html;
mod impacts;
mod input;
mod joint;
mod markup;
mod parameters;
mod residuals;
mod seen;
pub mod strobe;
mod svg;
#[cfg(test)]
mod tests;
mod theme;
mod time_map;
mod verdict;

pub use html::{PLAYER, PageError, html, strobe_of};
pub use input::Page;
pub use joint::fit_page;
pub use strobe::{Size, Strobe};

pub use crate::visual::View;
