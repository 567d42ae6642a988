//! Written sketches and recordings, one made of the other.

mod keyframes;
mod places;

use std::ffi::OsStr;
use std::iter;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, bail};
use serde::Serialize;

pub use self::keyframes::Density;
use self::keyframes::SketchMotion;
use self::places::placed;
use super::deadline::Deadline;
use super::finish::{lost, open, warnings};
use super::guard::Inputs;
use super::output::write_file_of;
use super::working::Working;
use crate::config::{scene_from_toml, sketch_from_csv, sketch_from_toml};
use crate::ingest::{SCENE_NAME, read_text};
use crate::motion::{Keyframe, Scene, SketchRow, Stamp};
use crate::write::{RecordingWriter, csv_of_sketch, toml_of_sketch};

/// The input of [`sketch`].
#[derive(Clone, Debug)]
pub struct SketchJob {
    /// A written sketch (`.csv`, `.toml`) or a recording (`.mcap`).
    pub input: PathBuf,
    /// The other; beside the input with the other's ending by default.
    pub output: Option<PathBuf>,
    /// Scene file; of a recording its own by default.
    pub scene: Option<PathBuf>,
    /// How many keyframes are made of a recording.
    pub density: Density,
    /// Whether they are of the motion that is estimated from it, instead of what was acted.
    pub is_estimated: bool,
    /// How long reading and estimating may take; no limit by default.
    pub deadline: Option<Duration>,
}

/// The result of [`sketch`].
#[derive(Clone, Debug, Serialize)]
pub struct Sketched {
    /// The file that was read.
    pub input: String,
    /// The file that was written.
    pub output: String,
    /// Name of the scene.
    pub scene: String,
    /// Keyframes.
    pub keyframes: usize,
    /// Marks.
    pub marks: usize,
    /// Parts of the recording that could not be read.
    pub lost: Vec<String>,
    /// What to know.
    pub warnings: Vec<String>,
}

/// The kinds of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SketchKind {
    Csv,
    Toml,
    Recording,
}

impl SketchKind {
    fn of(path: &Path) -> anyhow::Result<Self> {
        match path.extension().and_then(OsStr::to_str) {
            Some("csv") => Ok(Self::Csv),
            Some("toml") => Ok(Self::Toml),
            Some("mcap") => Ok(Self::Recording),
            _ => bail!(
                "{}: expected a name that ends in .csv or .toml, a written sketch, or in .mcap, a \
                 recording",
                path.display()
            ),
        }
    }
}

/// Makes a recording of a written sketch, or a written sketch of a recording.
pub fn sketch(job: &SketchJob) -> anyhow::Result<Sketched> {
    let from = SketchKind::of(&job.input)?;
    let ending = if from == SketchKind::Recording {
        "csv"
    } else {
        "mcap"
    };
    let output = job
        .output
        .clone()
        .unwrap_or_else(|| job.input.with_extension(ending));
    let to = SketchKind::of(&output)?;
    let inputs = iter::once(job.input.as_path()).chain(job.scene.as_deref());
    Inputs::of(inputs).keep_from(&output)?;
    if (from == SketchKind::Recording) == (to == SketchKind::Recording) {
        bail!(
            "{} and {}: expected one recording (.mcap) and one written sketch (.csv, .toml)",
            job.input.display(),
            output.display()
        );
    }
    let working = Working::begin("reading");
    if from == SketchKind::Recording {
        read(job, &output, to, &working)
    } else {
        write(job, &output, from)
    }
}

/// A written sketch becomes a recording.
fn write(job: &SketchJob, output: &Path, kind: SketchKind) -> anyhow::Result<Sketched> {
    let path = job.input.display();
    if job.is_estimated || job.density != Density::All {
        bail!("{path}: is a written sketch, expected a recording to choose keyframes of");
    }
    let Some(scene_file) = &job.scene else {
        bail!("{path}: expected --scene FILE, which says what the bodies and events are");
    };
    let scene_toml = read_text(scene_file)
        .with_context(|| format!("{}: cannot read the scene", scene_file.display()))?;
    let scene = scene_from_toml(&scene_toml)
        .map_err(|error| error.in_file(scene_file.display().to_string()))?;
    let text = read_text(&job.input).with_context(|| format!("{path}: cannot read"))?;
    let rows = match kind {
        SketchKind::Csv => sketch_from_csv(&text, &scene),
        _ => sketch_from_toml(&text, &scene),
    };
    let rows = rows.map_err(|error| error.in_file(path.to_string()))?;
    let placed = placed(&rows, &scene).with_context(|| path.to_string())?;
    let mut recording = RecordingWriter::create_of(output, &[&job.input, scene_file])?;
    recording.attach(SCENE_NAME, "application/toml", scene_toml.as_bytes())?;
    for (log_time, row) in placed {
        match row {
            SketchRow::Keyframe {
                track,
                flight,
                keyframe,
            } => {
                let topic = scene.stream_topic(*track, *flight);
                recording.keyframe(&topic, log_time, keyframe)?;
            }
            SketchRow::Mark(mark) => recording.mark(&scene.marks_topic, log_time, mark)?,
        }
    }
    recording.finish()?;
    let open = rows.iter().filter_map(|row| match row {
        SketchRow::Keyframe {
            track, keyframe, ..
        } => {
            let may_be_open = scene.may_have_open_times(*track);
            let mount = scene.mount(*track);
            let reading = mount.reading_of(keyframe, Stamp(0), may_be_open);
            reading.err()
        }
        SketchRow::Mark(_) => None,
    });
    let mut warnings: Vec<String> = Vec::new();
    for reason in open {
        let warning = format!("`replay` refuses the recording: a keyframe {reason}");
        if !warnings.contains(&warning) {
            warnings.push(warning);
        }
    }
    warnings.extend(of_rows(&scene, &rows));
    Ok(account(job, output, &scene, &rows, Vec::new(), warnings))
}

/// Greatest deviation of a quaternion's norm from 1 of which nothing is said.
const NORM_SAID: f64 = 5e-3;

/// What is to be known of keyframes as they are written: norms, and positions alone.
fn of_rows(scene: &Scene, rows: &[SketchRow]) -> Vec<String> {
    let mut warnings = Vec::new();
    let keyframes = || {
        rows.iter().filter_map(|row| match row {
            SketchRow::Keyframe {
                track, keyframe, ..
            } => Some((*track, keyframe)),
            SketchRow::Mark(_) => None,
        })
    };
    let norms = keyframes().filter_map(|(_, keyframe)| {
        let parts = keyframe.orientation_wxyz?;
        Some(parts.iter().map(|part| part * part).sum::<f64>().sqrt())
    });
    let off: Vec<f64> = norms
        .filter(|norm| (norm - 1.0).abs() > NORM_SAID)
        .collect();
    if let Some(first) = off.first() {
        warnings.push(format!(
            "{} quaternions have a norm other than 1, the first {first:.4}: they are taken as if it were 1",
            off.len()
        ));
    }
    for track in scene.tracks.keys() {
        let mut own = keyframes().filter(|(of, _)| *of == track).peekable();
        let is_point = |keyframe: &Keyframe| keyframe.orientation_wxyz.is_none();
        if own.peek().is_some() && own.all(|(_, keyframe)| is_point(keyframe)) {
            warnings.push(format!(
                "{:?} has positions alone: `replay` takes them for a stream, and leaves out those beside marks; give one \
                 keyframe its orientation, and each counts",
                scene.link_seen_by(track).name
            ));
        }
    }
    warnings
}

/// A recording becomes a written sketch.
fn read(
    job: &SketchJob,
    output: &Path,
    kind: SketchKind,
    working: &Working,
) -> anyhow::Result<Sketched> {
    let deadline = Deadline::begin(job.deadline);
    let opened = open(&job.input, job.scene.as_deref(), deadline)?;
    let scene = opened.scene.for_reading();
    let written = opened.recording.sketch(scene)?;
    let (rows, notes) = match written {
        Some(rows) if !job.is_estimated && job.density == Density::All => {
            (rows, (Vec::new(), Vec::new()))
        }
        _ => {
            let take = opened.recording.take(scene)?;
            let mut notes = (lost(&take.report), warnings(&take.report));
            let motion = if job.is_estimated {
                let (motion, known) =
                    SketchMotion::estimated(scene, take.events, deadline, working)
                        .with_context(|| job.input.display().to_string())?;
                notes.1.extend(known);
                motion
            } else {
                SketchMotion::acted(scene, &take.events)
                    .with_context(|| job.input.display().to_string())?
            };
            (motion.rows(scene, job.density)?, notes)
        }
    };
    let text = match kind {
        SketchKind::Csv => csv_of_sketch(&rows, scene),
        _ => toml_of_sketch(&rows, scene),
    };
    let own = iter::once(job.input.as_path()).chain(job.scene.as_deref());
    let made_of: Vec<&Path> = own.collect();
    write_file_of(output, text.as_bytes(), &made_of)?;
    Ok(account(job, output, scene, &rows, notes.0, notes.1))
}

fn account(
    job: &SketchJob,
    output: &Path,
    scene: &Scene,
    rows: &[SketchRow],
    lost: Vec<String>,
    warnings: Vec<String>,
) -> Sketched {
    let is_mark = |row: &&SketchRow| matches!(row, SketchRow::Mark(_));
    let marks = rows.iter().filter(is_mark).count();
    Sketched {
        input: job.input.display().to_string(),
        output: output.display().to_string(),
        scene: scene.name.clone(),
        keyframes: rows.len() - marks,
        marks,
        lost,
        warnings,
    }
}
