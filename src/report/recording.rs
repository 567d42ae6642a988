//! What became of one recording: one JSON object, or the numbers of a text.

use serde::Serialize;

use super::estimate::EstimateReport;
use super::reported::Reported;
use super::samples::Ordered;
use super::spent::Spent;
use crate::motion::Phase;

/// A finished recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecordingReport {
    /// The file that was read.
    pub recording: String,
    /// What every report says of the estimate.
    #[serde(flatten)]
    pub estimate: EstimateReport,
    /// Wall time of the estimation, without checks and settling.
    pub solve_seconds: f64,
    /// Wall time of all that was done of the recording, in order: reading, solving and so on.
    pub spent_seconds: Ordered<f64>,
    /// Wall time of the pipeline by phase, in order.
    pub phase_seconds: Ordered<f64>,
    /// Whether it was ended before all was tried, by its deadline.
    pub ended_early: bool,
    /// What of the recording could not be read.
    pub lost: Vec<String>,
    /// What in it was read with reservations.
    pub warnings: Vec<String>,
    /// The file that was written.
    pub output: String,
}

/// What the driver of an estimation knows beside the estimate; see [`RecordingReport`].
#[derive(Clone, Debug, PartialEq)]
pub struct Circumstances {
    /// The file that was read.
    pub recording: String,
    /// The file that was written.
    pub output: String,
    /// Wall time of all that was done of the recording.
    pub spent: Spent,
    /// Wall time of the pipeline by phase, in order.
    pub phase_seconds: Vec<(Phase, f64)>,
    /// Whether it was ended before all was tried, by its deadline.
    pub ended_early: bool,
    /// What of the recording could not be read.
    pub lost: Vec<String>,
    /// What in it was read with reservations.
    pub warnings: Vec<String>,
}

impl RecordingReport {
    /// What became of a recording and how.
    pub fn new(of: &Reported, circumstances: Circumstances) -> Self {
        let phases = circumstances.phase_seconds.into_iter();
        let phases = phases.map(|(phase, seconds)| (phase.as_str().to_owned(), seconds));
        Self {
            recording: circumstances.recording,
            estimate: EstimateReport::new(of),
            solve_seconds: circumstances.spent.solving(),
            spent_seconds: Ordered(circumstances.spent.parts()),
            phase_seconds: Ordered(phases.collect()),
            ended_early: circumstances.ended_early,
            lost: circumstances.lost,
            warnings: circumstances.warnings,
            output: circumstances.output,
        }
    }

    /// Whether nothing was lost or left untried, the motion is physical and not known not to fit, and no mistake is likely.
    pub fn is_whole(&self) -> bool {
        self.lost.is_empty() && !self.ended_early && self.estimate.is_undoubted()
    }
}
