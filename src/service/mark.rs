//! The marks of a recording: listed, proposed from its streams, changed.

mod draft;
mod edit;
mod phases;

use std::iter;
use std::path::PathBuf;

use anyhow::{Context, bail, ensure};
use serde::Serialize;

pub use self::edit::MarkEdits;
use self::edit::{Edited, edited, present};
pub(super) use self::edit::{check_event, stamp_of};
pub use self::phases::{PhaseProposals, ProposedPhase, proposed_phases};
use super::deadline::Deadline;
use super::finish::{Opened, lost, opened, warnings, with_recording};
use super::guard::Inputs;
use super::inspect::{MarkLine, mark_line};
use super::working::Working;
use crate::ingest::Take;
use crate::motion::{Mark, Stamp, TakeEvent};
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
    /// Whether marks are proposed.
    pub is_proposing: bool,
    /// Collisions of each body that are proposed; as many as the scene has by default.
    pub count: Option<usize>,
    /// What is changed.
    pub edits: MarkEdits,
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
    /// What the streams show besides flights, body by body in order of time.
    pub phases: Vec<ProposedPhase>,
    /// Marks of the events at which what the scene does not say yet begins and ends, in order of time.
    pub phase_marks: Vec<MarkLine>,
    /// Text for the scene that says it.
    pub toml: Option<String>,
    /// The scene with that.
    pub scene_toml: Option<String>,
    /// The marks, as they are with what was changed, in order of time; proposals do not depend on them.
    pub marks: Vec<MarkLine>,
    /// Parts of the recording that could not be read.
    pub lost: Vec<String>,
    /// Parts of it that were read with reservations, and what to know of the marks.
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

/// Lists the marks, proposes some or changes them, and writes a copy of the recording with the result.
///
/// Fails where no proposal can be made, because a stream is too short or more are asked for than
/// fit, where a copy with proposals is wanted of a recording that keeps marks of its own, and where what is
/// to be changed is not there.
pub fn mark(job: &MarkJob) -> anyhow::Result<Marked> {
    if let Some(output) = &job.output {
        let own = iter::once(job.input.as_path()).chain(job.scene.as_deref());
        Inputs::of(own.chain(job.edits.from_file.as_deref())).keep_from(output)?;
    }
    let _working = Working::begin(match job.is_proposing {
        true => "proposing marks",
        false => "reading",
    });
    with_recording(&job.input, Deadline::begin(None), |recording| {
        marked(
            job,
            opened(recording, job.scene.as_deref(), Deadline::begin(None))?,
        )
    })
}

fn marked(job: &MarkJob, opened: Opened) -> anyhow::Result<Marked> {
    let path = opened.recording.path().display().to_string();
    let take = opened.recording.take(opened.scene.for_reading())?;
    let first = first_stamp(&take).with_context(|| format!("{path}: no poses, expected some"))?;
    let edited = edited(
        present(&opened)?,
        &job.edits,
        &opened,
        first,
        take.report.log_offset_ns.unwrap_or(0),
    )
    .with_context(|| path.clone())?;
    let (mut proposals, mut seen) = (Vec::new(), PhaseProposals::default());
    if job.is_proposing {
        let pipeline = opened.scene.pipeline(take.events.clone());
        proposals = proposed(job, &pipeline, &path)?;
        seen = besides_flights(&opened, &pipeline, &proposals, &path)?;
    }
    if let Some(output) = &job.output {
        write(job, output, &opened, &take, &edited, &proposals)?;
    }
    let scene = opened.scene.for_reading();
    let lines = proposals.iter().map(|proposal| ProposalLine {
        time_s: proposal.time_s,
        stamp_ns: proposal.stamp.0,
        event: proposal.event.clone(),
        body: proposal
            .track
            .map(|track| scene.link_seen_by(track).name.clone()),
        score: proposal.score,
    });
    let mut notes = warnings(&take.report);
    let last = stamps(&take).max().unwrap_or(first);
    let outside = edited
        .marks
        .iter()
        .filter(|of| !(first..=last).contains(&of.mark.stamp));
    let outside = outside.count();
    if outside > 0 {
        notes.push(format!(
            "{outside} of the marks are before the first pose or after the last"
        ));
    }
    if job.output.is_some() && !seen.phase_marks.is_empty() {
        notes.push(
            "no marks of phases that the scene does not have are written: propose again with them in it, \
             by --scene"
                .to_owned(),
        );
    }
    Ok(Marked {
        recording: path,
        scene: scene.name.clone(),
        proposals: lines.collect(),
        phases: seen.phases,
        phase_marks: seen
            .phase_marks
            .iter()
            .map(|mark| mark_line(mark, first))
            .collect(),
        toml: seen.toml,
        scene_toml: seen.scene_toml,
        marks: edited
            .marks
            .iter()
            .map(|of| mark_line(&of.mark, first))
            .collect(),
        lost: lost(&take.report),
        warnings: notes,
        output: job
            .output
            .as_ref()
            .map(|output| output.display().to_string()),
    })
}

fn stamps(take: &Take) -> impl Iterator<Item = Stamp> + '_ {
    take.events.iter().filter_map(|event| match event {
        TakeEvent::Pose { sample, .. } => Some(sample.stamp),
        TakeEvent::Mark(_) => None,
    })
}

/// The stamp from which times of marks are counted.
fn first_stamp(take: &Take) -> Option<Stamp> {
    stamps(take).min()
}

/// What the streams show besides flights, with what would say it.
fn besides_flights(
    opened: &Opened,
    pipeline: &Pipeline,
    proposals: &[MarkProposal],
    path: &str,
) -> anyhow::Result<PhaseProposals> {
    let seen = pipeline.seen().with_context(|| path.to_owned())?;
    let text = std::str::from_utf8(&opened.scene_toml).unwrap_or_default();
    let marks = proposals.iter().map(|of| Mark {
        stamp: of.stamp,
        event: of.event.clone(),
    });
    let marks: Vec<Mark> = marks.collect();
    Ok(proposed_phases(
        opened.scene.for_reading(),
        text,
        &seen,
        &marks,
    ))
}

fn proposed(job: &MarkJob, pipeline: &Pipeline, path: &str) -> anyhow::Result<Vec<MarkProposal>> {
    let proposals = pipeline
        .propose(job.count)
        .with_context(|| path.to_owned())?;
    let found = proposals.iter().filter(|p| p.score.is_some()).count();
    // A repeated collision is as many as are looked for.
    let scene = pipeline.scene().with_marks(pipeline.marks());
    let collisions = scene.events.iter();
    let collisions = collisions.filter(|event| event.kind.collision().is_some());
    let wanted = job
        .count
        .map_or(collisions.count(), |n| n * scene.links.len());
    if found < wanted {
        bail!("{path}: the streams are too short for {wanted} collisions, or they are too many");
    }
    Ok(proposals)
}

fn write(
    job: &MarkJob,
    output: &std::path::Path,
    opened: &Opened,
    take: &Take,
    edited: &Edited,
    proposals: &[MarkProposal],
) -> anyhow::Result<()> {
    let path = opened.recording.path().display();
    ensure!(
        job.is_proposing || !job.edits.is_empty(),
        "{path}: nothing to write, expected --propose, --add, --move, --remove, --from or --from-topic"
    );
    let kept = edited.marks.len();
    if job.is_proposing && kept > 0 {
        bail!(
            "{path}: has {kept} marks already, expected none to add the proposals to it; `--remove all` \
             leaves them out"
        );
    }
    let offset_ns = take.report.log_offset_ns.unwrap_or(0);
    let proposed = proposals.iter().map(|proposal| {
        let mark = Mark {
            stamp: proposal.stamp,
            event: proposal.event.clone(),
        };
        (Stamp(proposal.stamp.0.saturating_add(offset_ns)), mark)
    });
    let marks: Vec<(Stamp, Mark)> = edited.added().chain(proposed).collect();
    let (container, topic) = (
        opened.recording.container(),
        &opened.scene.for_reading().marks_topic,
    );
    let without = edited.without.clone();
    write_marks(output, container, &job.input, topic, &marks, without)?;
    Ok(())
}
