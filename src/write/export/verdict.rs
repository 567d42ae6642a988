//! The verdict of an estimate that was written, without its motion.

use super::super::topics;
use super::motion::json_of;
use crate::report::EstimateReport;
use crate::wire::Container;

/// What an estimate says of itself first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WrittenVerdict {
    /// `physical`, `plausible` or `failed`.
    pub verdict: String,
    /// Whether nothing speaks against the motion: it is physical, not known not to fit, and nothing is suspected.
    pub is_good: bool,
    /// What speaks against it most, else why the estimation ended, as a sentence.
    pub why: String,
}

impl WrittenVerdict {
    /// That of the last report in a file; `None` where there is none that can be read.
    pub fn read(container: &Container) -> Option<Self> {
        let is_report = |id: u16| {
            let channel = container.channels().get(&id);
            channel.is_some_and(|of| of.topic == topics::REPORT && topics::is_ours(&of.metadata))
        };
        let mut walk = container.walk();
        let mut found = None;
        while let Some(message) = walk.next_message() {
            if is_report(message.channel_id) {
                found = json_of(message.data).ok();
            }
        }
        let report = EstimateReport::read(&found?).ok()?;
        if report.verdict.is_empty() || report.fits.is_empty() {
            return None;
        }
        let is_good = report.is_good();
        let doubt = report.doubts.into_iter().next().map(|doubt| doubt.text);
        Some(Self {
            verdict: report.verdict,
            is_good,
            why: doubt.unwrap_or(report.reason),
        })
    }
}
