//! An estimate as a page that people open, and as pictures.
//!
//! [`html`] makes one file that needs nothing else: no net, no script, no font. It has what `/estimate/report` says in
//! words, tables and small charts, and [`Strobe`] pictures of the motion beside the performance; these are files of
//! their own as well. Everything is a function of what was read and of the wishes: no clock, no random names.
//! Whatever a file calls its bodies and events is escaped.

mod advice;
mod chart;
mod html;
mod residuals;
mod said;
mod sections;
pub mod strobe;
mod svg;
mod theme;
mod time_map;

pub use html::{PageError, html};
pub use strobe::Strobe;

pub use crate::visual::View;

use self::said::Suspect;
use crate::motion::{PoseSample, Scene, TrackIndex};
use crate::report::ExportProvenance;
use crate::report::units::for_people;
use crate::write::export::WrittenMotion;

/// What a page is made of.
#[derive(Clone, Copy)]
pub struct Page<'a> {
    /// The scene of the estimate.
    pub scene: &'a Scene,
    /// The motion and the performance.
    pub motion: &'a WrittenMotion,
    /// What trackers read that see points alone, as they read it.
    pub readings: &'a [(TrackIndex, PoseSample)],
    /// From what it is made.
    pub provenance: &'a ExportProvenance,
    /// What of the file could not be read.
    pub lost: &'a [String],
}

/// Class of the lines of the body that a track is on.
fn body_class(page: &Page, track: &str) -> String {
    let of = page.scene.tracks.iter().find(|of| of.name == track);
    let classes = strobe::colours(page.scene);
    of.map_or_else(|| "ax".to_owned(), |of| format!("b{}", classes[of.link]))
}

/// Likely values of what is suspected.
fn for_people_words(suspect: &Suspect) -> String {
    let (factor, unit) = for_people(&suspect.unit);
    let values = suspect.quantities.iter().map(|(name, value)| {
        let value = value.map_or("?".to_owned(), |value| format!("{:.3}", value * factor));
        let words = format!("{} {value} {unit}", svg::escaped(name));
        words.trim_end().to_owned()
    });
    values.collect::<Vec<_>>().join(", ")
}
