//! Recordings that are imported: a part of one, or several of one bag as one.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};

use super::{ImportJob, Imported, InputLine};
use crate::ingest::table::TableOptions;
use crate::ingest::{Recording, SCENE_NAME};
use crate::motion::Scene;
use crate::write::{joined, write_part};

/// Between two recordings of one bag is no longer time than this \[s\].
const PAUSE_S: f64 = 10.0;

/// The recording of several, or the part of one that is wanted, with the scene.
pub(super) fn recordings(
    job: &ImportJob,
    inputs: Vec<(PathBuf, Vec<u8>)>,
    scene: Option<&(Scene, String)>,
) -> anyhow::Result<Imported> {
    for (path, _) in &inputs {
        ensure!(
            job.options == TableOptions::default() && job.topics.is_empty() && job.marks.is_empty(),
            "{}: is a recording: only --scene, --start and --end apply to it (marks are added by `enact mark`)",
            path.display()
        );
    }
    let count = inputs.len();
    let mut opened = Vec::new();
    for (at, (path, bytes)) in inputs.iter().enumerate() {
        if let Some((same, _)) = inputs[..at].iter().find(|(_, other)| other == bytes) {
            bail!(
                "{} and {} have the same bytes, expected each recording once",
                same.display(),
                path.display()
            );
        }
        let recording = Recording::from_bytes(path, bytes.clone())?;
        opened.push(recording);
    }
    drop(inputs);
    if count == 1 {
        let recording = opened.pop().context("one recording")?;
        return part(job, &recording, &[recording.path()], scene);
    }
    opened.sort_by_key(|recording| recording.container().log_times());
    let mut against = Vec::new();
    for pair in opened.windows(2) {
        let [before, after] = pair else {
            continue;
        };
        let times = before
            .container()
            .log_times()
            .zip(after.container().log_times());
        let pause_s = times.map_or(0.0, |((_, end), (begin, _))| {
            (i128::from(begin) - i128::from(end)) as f64 * 1e-9
        });
        if pause_s > PAUSE_S {
            against.push(format!(
                "{} begins {pause_s:.1} s after {} ends: are both of one bag?",
                after.path().display(),
                before.path().display()
            ));
        }
    }
    let containers: Vec<_> = opened
        .iter()
        .map(|of| (of.path().to_owned(), of.container()))
        .collect();
    let joined = joined(&containers)?;
    let mut lost = Vec::new();
    for recording in &opened {
        let damages = recording.container().damages();
        lost.extend(
            damages
                .first()
                .iter()
                .map(|damage| format!("{}: {damage}", recording.path().display())),
        );
    }
    let together = Recording::from_bytes(opened[0].path(), joined.bytes)?;
    let files: Vec<&Path> = opened.iter().map(Recording::path).collect();
    let mut imported = part(job, &together, &files, scene)?;
    imported.warnings.push(format!(
        "{count} recordings are put together in order of log time"
    ));
    if joined.doubles > 0 {
        imported.warnings.push(format!(
            "{} messages are in several of them, and once in the recording",
            joined.doubles
        ));
    }
    imported.against.extend(against);
    imported.lost.extend(lost);
    Ok(imported)
}

/// The part of a recording that is wanted, with the scene.
fn part(
    job: &ImportJob,
    recording: &Recording,
    files: &[&Path],
    scene: Option<&(Scene, String)>,
) -> anyhow::Result<Imported> {
    let (input, container) = (recording.path(), recording.container());
    let Some((first, _)) = container.log_times() else {
        bail!("{}: has no messages", input.display());
    };
    let at = |seconds: f64| first.saturating_add((seconds * 1e9).round().max(0.0) as u64);
    let from = job.start_s.map_or(0, at);
    let to = job.end_s.map_or(u64::MAX, at);
    let scene_toml = scene.map(|(_, text)| text.clone().into_bytes());
    let mut warnings = Vec::new();
    if let Some((scene, _)) = scene
        && let Err(error) = recording.source(scene)
    {
        warnings.push(format!("the scene does not match: {error}"));
    }
    if scene.is_none() && recording.only_scene()?.is_none() {
        warnings.push(format!(
            "no {SCENE_NAME} is attached: --scene FILE attaches one"
        ));
    }
    let made_of: Vec<&Path> = files.iter().copied().chain(job.scene.as_deref()).collect();
    let copied = write_part(&job.output, container, &made_of, from..=to, scene_toml)?;
    let damages = container.damages();
    let inputs = files.iter().map(|file| InputLine {
        file: file.display().to_string(),
        kind: "a recording".to_owned(),
    });
    Ok(Imported {
        inputs: inputs.collect(),
        output: job.output.display().to_string(),
        scene: scene.map(|(scene, _)| scene.name.clone()),
        bodies: Vec::new(),
        copied: Some(copied),
        left_out: container.message_count().saturating_sub(copied),
        marks: 0,
        against: Vec::new(),
        warnings,
        lost: damages.first().iter().map(ToString::to_string).collect(),
    })
}
