//! Lists the contents of a recording, without estimating anything.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use serde::Serialize;

use super::deadline::Deadline;
use super::finish::{attached_scene, lost, opened, warnings};
use super::words::words;
use super::working::Working;
use crate::ingest::{PoseExtent, Recording};
use crate::motion::{Mark, Scene, Stamp, TakeEvent};
use crate::write::is_cut_short;

/// What is said of a take that was not closed.
pub(super) const CUT_SHORT: &str = "the take was not closed: its recording was stopped, or cut short, and what came \
                                    after that is not in it";

/// Number of topics that are listed; a file may have 65,535.
const LISTED: usize = 1000;

/// An interval between messages longer than this many median ones is a gap.
const GAP_RATIO: f64 = 2.5;

/// The contents of a recording.
#[derive(Clone, Debug, Serialize)]
pub struct Inspection {
    /// The file.
    pub recording: String,
    /// Its size.
    pub bytes: usize,
    /// Its messages, on all topics.
    pub messages: u64,
    /// From the least log time to the greatest.
    pub duration_s: f64,
    /// Whether messages lie in order of log time.
    pub sorted: bool,
    /// Whether its end is missing.
    pub truncated: bool,
    /// Parts that could not be read.
    pub lost: Vec<String>,
    /// Parts that were read with reservations.
    pub warnings: Vec<String>,
    /// Number of all topics, each counted once for each of its channels.
    pub topics_in_all: usize,
    /// The first thousand topics in alphabetical order.
    pub topics: Vec<TopicLine>,
    /// Names of the attachments.
    pub attachments: Vec<String>,
    /// What the poses of each topic and child are like.
    pub poses: Vec<PoseLine>,
    /// Name of the scene with which it was looked at, if it is valid.
    pub scene: Option<String>,
    /// Why there is no scene, or why the recording does not match it.
    pub complaint: Option<String>,
    /// The marks, as the scene reads them.
    pub marks: Vec<MarkLine>,
}

/// The messages of a topic.
#[derive(Clone, Debug, Serialize)]
pub struct TopicLine {
    /// The topic.
    pub topic: String,
    /// Schema of its messages.
    pub schema: String,
    /// Encoding of its messages.
    pub encoding: String,
    /// Number of messages.
    pub messages: u64,
    /// Rate by the median interval of log times.
    pub rate_hz: Option<f64>,
    /// Number of intervals longer than 2.5 times the median.
    pub gaps: usize,
    /// The longest interval.
    pub longest_gap_s: Option<f64>,
}

/// The poses of one child on a topic.
#[derive(Clone, Debug, Serialize)]
pub struct PoseLine {
    /// The topic; with `#child` where its messages name one, as scenes write it.
    pub topic: String,
    /// How many.
    pub poses: u64,
    /// Least and greatest coordinate of each axis; `None` where no position is held.
    pub extent_m: Option<[[f64; 2]; 3]>,
    /// Least and greatest norm of the quaternions; `None` where none is held.
    pub norms: Option<[f64; 2]>,
    /// Poses with a number that is not finite.
    pub not_finite: u64,
    /// The frames in which they are given.
    pub frame_ids: Vec<String>,
}

/// A mark.
#[derive(Clone, Debug, Serialize)]
pub struct MarkLine {
    /// Time since the first sample.
    pub time_s: f64,
    /// Time on the clock of the samples.
    pub stamp_ns: i64,
    /// The event it names.
    pub event: Option<String>,
}

/// Lists the contents of a recording, of what can be read of it within a time if one is given, with its own scene or that
/// of a file. Damage or a missing scene is no error, but a file of a scene that cannot be used is.
pub fn inspect(
    input: &Path,
    scene_file: Option<&Path>,
    deadline_after: Option<Duration>,
) -> anyhow::Result<Inspection> {
    let _working = Working::begin("reading");
    let deadline = Deadline::begin(deadline_after);
    let recording = Recording::open_until(input, deadline.instant())?;
    let (recording, scene) = match scene_file {
        Some(_) => {
            let opened = opened(recording, scene_file, deadline)?;
            (opened.recording, Ok(opened.scene.for_reading().clone()))
        }
        None => {
            let scene = attached_scene(&recording);
            (recording, scene)
        }
    };
    let container = recording.container();
    let mut inspection = Inspection {
        recording: input.display().to_string(),
        bytes: container.byte_count(),
        messages: container.message_count(),
        duration_s: container
            .log_times()
            .map_or(0.0, |(first, last)| (last - first) as f64 * 1e-9),
        topics_in_all: container.channels().len(),
        sorted: container.is_sorted(),
        truncated: recording.is_truncated(),
        lost: container
            .damages()
            .first()
            .iter()
            .map(ToString::to_string)
            .collect(),
        warnings: Vec::new(),
        topics: topics(&recording),
        attachments: container
            .attachments()
            .iter()
            .map(|attachment| attachment.name.clone())
            .collect(),
        poses: Vec::new(),
        scene: None,
        complaint: None,
        marks: Vec::new(),
    };
    let poses = recording.poses();
    match scene {
        Ok(scene) => {
            inspection.scene = Some(scene.name.clone());
            look_with(&recording, &scene, &mut inspection);
        }
        Err(error) => inspection.complaint = Some(words(&error)),
    }
    if inspection.complaint.is_some() {
        // With a scene the topics that it reads are looked at.
        inspection
            .warnings
            .extend(poses.iter().filter_map(|of| of.mixed.clone()));
    }
    inspection.poses = lines_of(poses);
    if is_cut_short(recording.container()) {
        inspection.lost.push(CUT_SHORT.to_owned());
    }
    if deadline.is_over() {
        inspection.lost.push(format!(
            "the time limit of {} was reached: not everything was looked at",
            deadline.words()
        ));
    }
    Ok(inspection)
}

fn look_with(recording: &Recording, scene: &Scene, inspection: &mut Inspection) {
    let take = match recording.take(scene) {
        Ok(take) => take,
        Err(error) => {
            inspection.complaint = Some(error.to_string());
            return;
        }
    };
    inspection.lost = lost(&take.report);
    inspection.warnings = warnings(&take.report);
    let stamps = take.events.iter().filter_map(|event| match event {
        TakeEvent::Pose { sample, .. } => Some(sample.stamp),
        TakeEvent::Mark(_) => None,
    });
    let first = stamps.min();
    for event in &take.events {
        if let TakeEvent::Mark(mark) = event {
            let first = first.unwrap_or(mark.stamp);
            inspection.marks.push(mark_line(mark, first));
        }
    }
    inspection
        .marks
        .sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
}

/// A mark, counted from the first sample.
pub(super) fn mark_line(mark: &Mark, first: Stamp) -> MarkLine {
    MarkLine {
        time_s: (i128::from(mark.stamp.0) - i128::from(first.0)) as f64 * 1e-9,
        stamp_ns: mark.stamp.0,
        event: mark.event.clone(),
    }
}

fn lines_of(poses: Vec<PoseExtent>) -> Vec<PoseLine> {
    let all = poses.into_iter();
    all.map(|of| PoseLine {
        topic: match of.child.as_str() {
            "" => of.topic,
            child => format!("{}#{child}", of.topic),
        },
        poses: of.count,
        extent_m: of.extent_m,
        norms: of.norms,
        not_finite: of.not_finite,
        frame_ids: of.frames.into_iter().collect(),
    })
    .collect()
}

fn topics(recording: &Recording) -> Vec<TopicLine> {
    let container = recording.container();
    let channels = container.channels().iter().map(|(id, channel)| {
        let schema = container.schema_of(channel);
        (
            *id,
            channel,
            schema.map_or("", |schema| schema.name.as_str()),
        )
    });
    let mut listed: Vec<_> = channels.collect();
    listed.sort_by_key(|(_, channel, schema)| (channel.topic.as_str(), *schema));
    listed.truncate(LISTED);
    let times = listed
        .iter()
        .map(|(id, channel, _)| (*id, Vec::with_capacity(channel.messages as usize)));
    let mut log_times: BTreeMap<u16, Vec<u64>> = times.collect();
    let mut walk = container.walk();
    while let Some(message) = walk.next_message() {
        if let Some(times) = log_times.get_mut(&message.channel_id) {
            times.push(message.log_time);
        }
    }
    let lines = listed.into_iter().map(|(id, channel, schema)| {
        let pace = pace(log_times.remove(&id).unwrap_or_default());
        TopicLine {
            topic: channel.topic.clone(),
            schema: schema.to_owned(),
            encoding: channel.message_encoding.clone(),
            messages: channel.messages,
            rate_hz: pace.rate_hz,
            gaps: pace.gaps,
            longest_gap_s: pace.longest_gap_s,
        }
    });
    lines.collect()
}

#[derive(Default)]
struct MessagePace {
    rate_hz: Option<f64>,
    gaps: usize,
    longest_gap_s: Option<f64>,
}

fn pace(mut log_times: Vec<u64>) -> MessagePace {
    log_times.sort_unstable();
    // In place: there may be very many.
    for at in 1..log_times.len() {
        log_times[at - 1] = log_times[at] - log_times[at - 1];
    }
    log_times.pop();
    let mut intervals = log_times;
    intervals.sort_unstable();
    let Some(longest) = intervals.last() else {
        return MessagePace::default();
    };
    let median = intervals[intervals.len() / 2] as f64;
    let limit = median * GAP_RATIO;
    MessagePace {
        rate_hz: (median > 0.0).then_some(1e9 / median),
        gaps: intervals
            .iter()
            .filter(|interval| **interval as f64 > limit)
            .count(),
        longest_gap_s: Some(*longest as f64 / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pace_is_by_the_median_and_gaps_stand_out() {
        let pace = pace(
            vec![0, 10, 20, 30, 60, 70, 80]
                .into_iter()
                .map(|t| t * 1_000_000)
                .collect(),
        );
        assert_eq!(pace.rate_hz, Some(100.0));
        assert_eq!(pace.gaps, 1);
        assert_eq!(pace.longest_gap_s, Some(0.03));
    }

    #[test]
    fn one_message_has_no_pace() {
        let pace = pace(vec![5]);
        assert!(pace.rate_hz.is_none() && pace.longest_gap_s.is_none() && pace.gaps == 0);
    }
}
