//! Counts of what was found while a recording was read.

use std::collections::BTreeSet;

use crate::wire::DecodeError;
use crate::wire::container::Damages;

/// Counts of one of the scene's topics.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TopicReport {
    /// Topic as the scene writes it.
    pub topic: String,
    /// Messages on it.
    pub messages: u64,
    /// Samples or marks that they gave.
    pub events: u64,
    /// Messages that could not be decoded.
    pub undecodable: u64,
    /// Why the first of those could not.
    pub first_error: Option<DecodeError>,
    /// Samples or marks stamped with the log time, because their messages have no stamp
    /// (a zero stamp with a zero log time is not counted: they are equal).
    pub stamped_by_log_time: u64,
}

/// Counts of a recording, for a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TakeReport {
    /// One per track of the scene, in its order, then one for the marks; in an edited sketch one
    /// per segment of each track, and one for marks only if there are any.
    pub topics: Vec<TopicReport>,
    /// The frames in which poses are given; more than one is likely a mistake.
    pub frame_ids: BTreeSet<String>,
    /// Least log time less stamp of a pose \[ns\]: the difference of the two clocks, up to the
    /// least delay.
    pub log_offset_ns: Option<i64>,
    /// How frames, clocks and topics were taken, in words.
    pub notes: Vec<String>,
    /// Readings of several publishers that are mixed, in words.
    pub mixed: Vec<String>,
    /// Messages on the scene's topics that were not decoded because there are too many samples.
    pub beyond_limit: u64,
    /// Most samples and marks that are read of a recording of this size.
    pub sample_limit: u64,
    /// Messages in the recording, on any topic.
    pub messages: u64,
    /// Size of the recording.
    pub bytes: usize,
    /// Whether its end is missing.
    pub is_truncated: bool,
    /// What is wrong with the file.
    pub damages: Damages,
}

impl TakeReport {
    /// Messages on the scene's topics that could not be decoded.
    pub fn undecodable(&self) -> u64 {
        self.topics.iter().map(|topic| topic.undecodable).sum()
    }

    /// Whether data were lost: by damage to the file or by messages that cannot be decoded or are too many, or mixed with
    /// those of another publisher.
    pub fn is_lossy(&self) -> bool {
        self.damages.count() > 0
            || self.undecodable() > 0
            || self.beyond_limit > 0
            || !self.mixed.is_empty()
    }
}
