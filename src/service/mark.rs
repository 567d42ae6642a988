//! Proposes marks for a recording from its streams.

use std::path::PathBuf;

use anyhow::{Context, bail};
use serde::Serialize;

use super::finish::{check_distinct, lost, open, warnings};
use crate::motion::{Mark, Stamp};
use crate::pipeline::{MarkProposal, Pipeline};
use crate::write::write_marks;

/// The input of [`mark`].
#[derive(Clone, Debug)]
pub struct MarkJob {
    /// The recording.
    pub input: PathBuf,
    /// File for a copy with the marks, if one is wanted.
    pub output: Option<PathBuf>,
    /// Scene file; the recording's own scene by default.
    pub scene: Option<PathBuf>,
    /// Collisions of each body; as many as the scene has by default.
    pub count: Option<usize>,
}

/// The result of [`mark`].
#[derive(Clone, Debug, Serialize)]
pub struct Marked {
    /// The file that was read.
    pub recording: String,
    /// Name of the scene.
    pub scene: String,
    /// Proposed marks in order of time.
    pub proposals: Vec<ProposalLine>,
    /// Marks that were in the recording; the proposals do not depend on them.
    pub marks: usize,
    /// Parts of the recording that could not be read.
    pub lost: Vec<String>,
    /// Parts of it that were read with reservations.
    pub warnings: Vec<String>,
    /// The file that was written.
    pub output: Option<String>,
}

/// A proposed mark.
#[derive(Clone, Debug, Serialize)]
pub struct ProposalLine {
    /// Time since the first sample.
    pub time_s: f64,
    /// Time on the clock of the samples.
    pub stamp_ns: i64,
    /// The event; `None` where another count was asked for than the scene has.
    pub event: Option<String>,
    /// The body whose motion has the kink; `None` for start and end.
    pub body: Option<String>,
    /// Gain of the cut over that of a superfluous one; `None` for start and end.
    pub score: Option<f64>,
}

/// Proposes marks, and writes a copy of the recording with them.
///
/// Fails where no proposal can be made, because a stream is too short or more are asked for than
/// fit, and where a copy is wanted of a recording that already has marks.
pub fn mark(job: &MarkJob) -> anyhow::Result<Marked> {
    if let Some(output) = &job.output {
        check_distinct(&job.input, output)?;
    }
    let opened = open(&job.input, job.scene.as_deref())?;
    let path = opened.recording.path().display().to_string();
    let take = opened.recording.take(&opened.scene)?;
    let pipeline = Pipeline::of(opened.scene.clone(), take.events);
    let marks = pipeline.marks();
    let proposals = pipeline.propose(job.count).with_context(|| path.clone())?;
    let found = proposals.iter().filter(|p| p.track.is_some()).count();
    let collisions = opened
        .scene
        .events
        .iter()
        .filter(|e| e.kind.collision().is_some());
    let wanted = job
        .count
        .map_or(collisions.count(), |n| n * opened.scene.links.len());
    if found < wanted {
        bail!("{path}: the streams are too short for {wanted} collisions, or they are too many");
    }
    if let Some(output) = &job.output {
        if marks > 0 {
            bail!("{path}: has {marks} marks already, expected none to add the proposals to it");
        }
        let offset_ns = take.report.log_offset_ns.unwrap_or(0);
        let timed = |proposal: &MarkProposal| {
            let event = proposal
                .event
                .map(|event| opened.scene.events[event].name.clone());
            let mark = Mark {
                stamp: proposal.stamp,
                event,
            };
            (Stamp(proposal.stamp.0.saturating_add(offset_ns)), mark)
        };
        let marks: Vec<(Stamp, Mark)> = proposals.iter().map(timed).collect();
        let (container, topic) = (opened.recording.container(), &opened.scene.marks_topic);
        write_marks(output, container, &job.input, topic, &marks)?;
    }
    let scene = &opened.scene;
    let lines = proposals.iter().map(|proposal| ProposalLine {
        time_s: proposal.time_s,
        stamp_ns: proposal.stamp.0,
        event: proposal.event.map(|event| scene.events[event].name.clone()),
        body: proposal
            .track
            .map(|track| scene.link_seen_by(track).name.clone()),
        score: proposal.score,
    });
    Ok(Marked {
        recording: path,
        scene: scene.name.clone(),
        proposals: lines.collect(),
        marks,
        lost: lost(&take.report),
        warnings: warnings(&take.report),
        output: job
            .output
            .as_ref()
            .map(|output| output.display().to_string()),
    })
}
