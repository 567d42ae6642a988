//! Where methods fail: what is done to performances, and how the answer is judged.
//!
//! A [`Trouble`] makes a performance from a seed; [`judged`] asks the program and holds what it
//! says against an independent check ([`check()`]).

mod bodies;
mod check;
mod flights;
mod goals;
pub mod hit;
mod judge;
mod marks;
mod scales;
mod tracking;

use crate::case::Case;
use crate::perform::Acting;

pub use check::{Finding, check};
pub use judge::{Judged, asked, judged};

/// Something that goes wrong, or is hard.
pub struct Trouble {
    /// What kind, for the table.
    pub theme: &'static str,
    /// Which one: with `theme` and `timing` unique.
    pub name: String,
    /// What the stamps mean.
    pub timing: Timing,
    /// The performance of a seed, or why there is none.
    pub make: Make,
}

/// From a seed.
pub type Make = Box<dyn Fn(u64) -> Result<Case, String> + Send + Sync>;

/// What the stamps of a performance mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Timing {
    /// Physical times.
    Known,
    /// An order, in the performer's tempo.
    Unknown,
}

impl Timing {
    /// Both.
    pub const ALL: [Timing; 2] = [Timing::Known, Timing::Unknown];

    /// Its word.
    pub fn as_str(self) -> &'static str {
        match self {
            Timing::Known => "known",
            Timing::Unknown => "unknown",
        }
    }

    /// Acted as people do, at a distortion.
    pub fn acting(self, distortion: f64) -> Acting {
        let acting = match self {
            Timing::Known => Acting::timing_known(),
            Timing::Unknown => Acting::default(),
        };
        Acting {
            distortion,
            ..acting
        }
    }
}

/// All of them, in the order of the table.
pub fn all() -> Vec<Trouble> {
    let mut all = Vec::new();
    flights::add_bounces(&mut all);
    flights::add(&mut all);
    bodies::add(&mut all);
    marks::add(&mut all);
    tracking::add(&mut all);
    goals::add(&mut all);
    scales::add(&mut all);
    all
}

/// Adds a trouble at both kinds of timing.
fn add_both<F>(all: &mut Vec<Trouble>, theme: &'static str, name: &str, make: F)
where
    F: Fn(&Acting, u64) -> Result<Case, String> + Clone + Send + Sync + 'static,
{
    for timing in Timing::ALL {
        let make = make.clone();
        all.push(Trouble {
            theme,
            name: name.to_owned(),
            timing,
            make: Box::new(move |seed| make(&timing.acting(1.0), seed)),
        });
    }
}
