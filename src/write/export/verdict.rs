//! The verdict of an estimate that was written, without its motion.

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::super::topics;
use super::motion::json_of;
use crate::motion::{Fits, Verdict};
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

#[derive(Deserialize)]
struct VerdictReport {
    verdict: String,
    fits: String,
    reason: String,
    doubts: Vec<WrittenDoubt>,
    #[serde(default)]
    suspects: Vec<IgnoredAny>,
}

#[derive(Deserialize)]
struct WrittenDoubt {
    text: String,
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
        let report: VerdictReport = serde_json::from_slice(&found?).ok()?;
        let doubt = report.doubts.into_iter().next().map(|doubt| doubt.text);
        Some(Self {
            is_good: report.verdict == Verdict::Physical.as_str()
                && report.fits != Fits::No.as_str()
                && report.suspects.is_empty(),
            verdict: report.verdict,
            why: doubt.unwrap_or(report.reason),
        })
    }
}
