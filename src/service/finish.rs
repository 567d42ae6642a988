//! What all drivers share: find the scene, run the pipeline, write the file, report.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, bail};

use super::as_read::AsRead;
use super::deadline::Deadline;
use super::provenance::provenance;
use super::refusal::Refusal;
use super::stopwatch::Stopwatch;
use super::working::Working;
use crate::config::scene_from_toml;
use crate::ingest::{Recording, SCENE_NAME, TakeReport, is_pipe, listed, read_text};
use crate::motion::Scene;
use crate::pipeline::{Outcome, Pipeline};
use crate::report::{Circumstances, Provenance, RecordingReport, Reported, Spent};
use crate::write::{DEFAULT_FRAME_RATE_HZ, DEFAULT_WORLD_FRAME, EstimateFile, write_estimate};

/// A recording and the scene with which it is read.
pub(super) struct Opened {
    pub(super) recording: Recording,
    pub(super) scene: AsRead,
    /// The text of the scene, unchanged.
    pub(super) scene_toml: Vec<u8>,
    /// The file of the scene; none: it is attached to the recording.
    pub(super) scene_file: Option<PathBuf>,
    /// When reading and estimating must end.
    pub(super) deadline: Deadline,
}

/// Reads a recording, as long as there is time, and does something with it. Where that fails of a recording that is
/// damaged, the damage is named first: what is missing may be in what could not be read.
pub(super) fn with_recording<T>(
    input: &Path,
    deadline: Deadline,
    act: impl FnOnce(Recording) -> anyhow::Result<T>,
) -> anyhow::Result<T> {
    let recording = Recording::open_until(input, deadline.instant())?;
    deadline.check(input)?;
    let damages = recording.container().damages();
    let first = damages.first().iter().find(|_| damages.is_loss());
    let damaged = first.map(|damage| {
        let path = input.display();
        format!("{path}: the file is damaged, {damage}; `enact inspect` lists what could be read")
    });
    let result = act(recording);
    match damaged {
        Some(damaged) => result.context(damaged),
        None => result,
    }
}

/// Opens a recording, as long as there is time. The scene is that of `scene_file` if given, otherwise the attached one.
pub(super) fn open(
    input: &Path,
    scene_file: Option<&Path>,
    deadline: Deadline,
) -> anyhow::Result<Opened> {
    let recording = Recording::open_until(input, deadline.instant())?;
    deadline.check(input)?;
    opened(recording, scene_file, deadline)
}

/// [`open`] of what is read.
pub(super) fn opened(
    recording: Recording,
    scene_file: Option<&Path>,
    deadline: Deadline,
) -> anyhow::Result<Opened> {
    let (scene, scene_toml) = match scene_file {
        Some(file) => {
            let text = read_text(file)
                .with_context(|| format!("{}: cannot read the scene", file.display()))?;
            let scene = scene_from_toml(&text)
                .map_err(|error| error.in_file(file.display().to_string()))?;
            (scene, text.into_bytes())
        }
        None => {
            let scene = attached_scene(&recording)?;
            let text = recording.only_scene()?.unwrap_or_default();
            (scene, text.to_vec())
        }
    };
    Ok(Opened {
        recording,
        scene: AsRead::of(scene),
        scene_toml,
        scene_file: scene_file.map(Path::to_owned),
        deadline,
    })
}

/// The scene that the recording carries.
pub(super) fn attached_scene(recording: &Recording) -> anyhow::Result<Scene> {
    let path = recording.path().display();
    let Some(bytes) = recording.only_scene()? else {
        let attachments = recording.container().attachments().iter();
        let named = attachments.map(|attachment| attachment.name.clone());
        let named: BTreeSet<String> = named.collect();
        let others = match named.is_empty() {
            true => String::new(),
            false => format!(" (attached are {})", listed(&named)),
        };
        bail!("{path}: no {SCENE_NAME} attached{others}, expected one or --scene FILE");
    };
    let text = std::str::from_utf8(bytes)
        .with_context(|| format!("{path}: the attached {SCENE_NAME} is not UTF-8"))?;
    let in_file = format!("{path}#{SCENE_NAME}");
    Ok(scene_from_toml(text).map_err(|error| error.in_file(in_file))?)
}

/// `tip.mcap` → `tip.estimate.mcap`, beside it or in another folder.
pub(super) fn output_path(input: &Path, folder: Option<&Path>) -> anyhow::Result<PathBuf> {
    if is_pipe(input) {
        bail!("-: stdin has no name, expected one for the estimate: -o FILE, or -o - for stdout");
    }
    let Some(stem) = input.file_stem() else {
        bail!("{}: expected the name of a file", input.display());
    };
    let mut name = stem.to_owned();
    name.push(".estimate.mcap");
    let folder = folder.unwrap_or_else(|| input.parent().unwrap_or(Path::new("")));
    Ok(folder.join(name))
}

/// `tip.estimate.mcap` → `tip.estimate.csv`, beside it.
pub fn beside(input: &Path, ending: &str) -> anyhow::Result<PathBuf> {
    if is_pipe(input) {
        bail!("-: stdin has no name, expected one for the output: -o FILE, or -o - for stdout");
    }
    Ok(input.with_extension(ending))
}

/// Estimates the events that were pushed, writes the estimate, and returns the report.
pub(super) fn finish(
    opened: &Opened,
    pipeline: &Pipeline,
    take: &TakeReport,
    output: &Path,
    working: &Working,
) -> anyhow::Result<RecordingReport> {
    finished(opened, pipeline, take, output, working).map(|(report, _)| report)
}

/// [`finish`], which returns the estimate too.
pub(super) fn finished(
    opened: &Opened,
    pipeline: &Pipeline,
    take: &TakeReport,
    output: &Path,
    working: &Working,
) -> anyhow::Result<(RecordingReport, Outcome)> {
    let recording = &opened.recording;
    opened.deadline.check(recording.path())?;
    let reading_seconds = opened.deadline.elapsed().as_secs_f64();
    let deadline = opened.deadline.with_time_to_write();
    let mut stopwatch = Stopwatch::start(deadline, working);
    let outcome = match pipeline.finish(&mut stopwatch) {
        Ok(outcome) => outcome,
        Err(error) => {
            let refusal = Refusal::new(pipeline, error, &mut stopwatch);
            return Err(refusal).with_context(|| recording.path().display().to_string());
        }
    };
    if opened.deadline.is_told() {
        opened.deadline.check(recording.path())?;
    }
    let ended_early = stopwatch.has_ended_it();
    let (whole_seconds, phase_seconds) = stopwatch.stop();
    tracing::info!(
        recording = %recording.path().display(),
        verdict = outcome.estimate.verdict.as_str(),
        iterations = outcome.estimate.counters.iterations,
        "estimated"
    );
    working.now("writing");
    let writing = Instant::now();
    let ended_after_s = opened.deadline.limit_s().filter(|_| ended_early);
    write_outcome(opened, pipeline, take, &outcome, ended_after_s, output)?;
    let lost = lost(take);
    let circumstances = Circumstances {
        recording: recording.path().display().to_string(),
        output: output.display().to_string(),
        spent: Spent::of(whole_seconds, &phase_seconds)
            .with_files(reading_seconds, writing.elapsed().as_secs_f64()),
        phase_seconds,
        ended_early,
        lost,
        warnings: [warnings(take), mark_notes(&outcome)].concat(),
    };
    let report = RecordingReport::new(&reported(&outcome), circumstances);
    Ok((report, outcome))
}

/// Writes what came in and the estimate of it; after which time that was ended, if it was.
pub(super) fn write_outcome(
    opened: &Opened,
    pipeline: &Pipeline,
    take: &TakeReport,
    outcome: &Outcome,
    ended_after_s: Option<f64>,
    output: &Path,
) -> anyhow::Result<()> {
    let recording = &opened.recording;
    let scene_file = opened.scene_file.as_deref();
    let made_of: Vec<&Path> = [recording.path()].into_iter().chain(scene_file).collect();
    let written = write_estimate(
        output,
        &EstimateFile {
            input: recording.container(),
            made_of: &made_of,
            of: reported(outcome),
            scene_toml: &opened.scene_toml,
            provenance: Some(&Provenance {
                ended_after_s,
                ..provenance(recording, &opened.scene_toml, scene_file, pipeline)
            }),
            world_frame: world_frame(take),
            log_offset_ns: take.log_offset_ns.unwrap_or(0),
            frame_rate_hz: DEFAULT_FRAME_RATE_HZ,
        },
    )?;
    tracing::info!(
        output = %output.display(),
        copied = written.copied,
        added = written.added,
        "written"
    );
    Ok(())
}

/// What reports of an outcome are about.
pub(super) fn reported(outcome: &Outcome) -> Reported<'_> {
    Reported {
        scene: &outcome.scene,
        inferred: &outcome.inferred,
        sketch: &outcome.sketch,
        counts: &outcome.counts,
        estimate: &outcome.estimate,
        verification: outcome.verification.as_ref(),
        settled: outcome.settled.as_ref(),
        diagnoses: &outcome.diagnoses,
        seen: &outcome.seen,
        freed: &outcome.freed,
        rest: outcome.rest.as_ref(),
    }
}

/// The frame in which poses are given, if they agree on one with a name.
fn world_frame(take: &TakeReport) -> &str {
    match take.frame_ids.first() {
        Some(frame) if take.frame_ids.len() == 1 && !frame.is_empty() => frame,
        _ => DEFAULT_WORLD_FRAME,
    }
}

/// Parts of the recording that could not be read.
pub(super) fn lost(take: &TakeReport) -> Vec<String> {
    let damages = &take.damages;
    let mut lost: Vec<String> = damages.first().iter().map(ToString::to_string).collect();
    if damages.count() > lost.len() {
        lost.push(format!("{} more damages", damages.count() - lost.len()));
    }
    for topic in take.topics.iter().filter(|topic| topic.undecodable > 0) {
        let reason = topic.first_error.as_ref().map(ToString::to_string);
        lost.push(format!(
            "{} of {} messages on {} cannot be decoded: {}",
            topic.undecodable,
            topic.messages,
            topic.topic,
            reason.unwrap_or_default()
        ));
    }
    lost.extend(take.mixed.iter().cloned());
    if take.beyond_limit > 0 {
        lost.push(format!(
            "{} messages on the scene's topics were not read: of a recording of {} bytes at most {} \
             samples are",
            take.beyond_limit, take.bytes, take.sample_limit
        ));
    }
    lost
}

/// Parts of the recording that were read with reservations.
pub(super) fn warnings(take: &TakeReport) -> Vec<String> {
    let mut warnings = Vec::new();
    for topic in take.topics.iter().filter(|t| t.stamped_by_log_time > 0) {
        warnings.push(format!(
            "{} of {} on {} have no stamp of their own: log time was taken",
            topic.stamped_by_log_time, topic.events, topic.topic
        ));
    }
    warnings.extend(take.notes.iter().cloned());
    if take.frame_ids.len() > 1 {
        warnings.push(format!(
            "poses are given in {} frames ({}), taken as one",
            take.frame_ids.len(),
            listed(&take.frame_ids)
        ));
    }
    warnings
}

/// Notes on marks that are not the performer's; their events are those of the scene that was estimated.
fn mark_notes(outcome: &Outcome) -> Vec<String> {
    let changes = &outcome.counts.marks;
    let placed = |events: &[usize]| {
        let placed = events.iter().map(|event| {
            let acted_s = outcome.sketch.marks_s[*event];
            format!("{:?} at {acted_s:.3} s", outcome.scene.events[*event].name)
        });
        placed.collect::<Vec<_>>().join(", ")
    };
    let mut notes = Vec::new();
    if !changes.proposed.is_empty() {
        notes.push(format!(
            "no marks for some events, put where the stream suggests: {}",
            placed(&changes.proposed)
        ));
    }
    if !changes.moved.is_empty() {
        notes.push(format!(
            "marks far from any kink, put where the stream suggests: {}",
            placed(&changes.moved)
        ));
    }
    if !changes.late.is_empty() {
        notes.push(format!(
            "marks outside the data, put at its end: {}",
            placed(&changes.late)
        ));
    }
    if changes.ignored > 0 {
        notes.push(format!("{} marks stand for no event", changes.ignored));
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_are_named_after_inputs() {
        for (input, folder, output) in [
            ("a/tip.mcap", None, "a/tip.estimate.mcap"),
            ("tip.mcap", None, "tip.estimate.mcap"),
            ("a/tip", Some("out"), "out/tip.estimate.mcap"),
            ("a/b.c.mcap", Some("out"), "out/b.c.estimate.mcap"),
        ] {
            assert_eq!(
                output_path(Path::new(input), folder.map(Path::new)).unwrap(),
                Path::new(output)
            );
        }
        assert!(output_path(Path::new("/"), None).is_err());
    }
}
