//! What is asked for.

use std::path::PathBuf;

/// Which takes are held out.
#[derive(Clone, Debug, PartialEq)]
pub enum HoldOut {
    /// A share of them, by their contents.
    Share(f64),
    /// These files.
    Files(Vec<PathBuf>),
}

/// The input of [`fit`](super::fit).
#[derive(Clone, Debug)]
pub struct FitJob {
    /// The recordings.
    pub inputs: Vec<PathBuf>,
    /// Scene file for all; each recording's own scene by default.
    pub scene: Option<PathBuf>,
    /// AskedNames of quantities that have one value in all takes,
    pub shared: Vec<String>,
    /// and of those that each take draws about a mean.
    pub drawn: Vec<String>,
    /// Takes by which the answer is tried and not made.
    pub hold_out: Option<HoldOut>,
    /// Where the answer goes as a calibration; by default it is only returned.
    pub output: Option<PathBuf>,
    /// Where a page of it goes, if anywhere; a page that is there is replaced.
    pub page: Option<PathBuf>,
}
