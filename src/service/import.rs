//! Files of other programs become recordings: tables of poses, and parts of recordings.

mod kind;
mod names;
mod told;

use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use serde::Serialize;

use self::kind::Kind;
use self::names::{Named, name_of_file, topics};
use self::told::{Told, told};
use super::finish::check_distinct;
use super::mark::{check_event, stamp_of};
use super::working::Working;
use crate::config::scene_from_toml;
use crate::ingest::table::{PoseTable, TableOptions, read_table};
use crate::ingest::{ListedMark, Recording, SCENE_NAME, read_whole, regular};
use crate::motion::{Holds, Mark, PoseSample, Scene, Sees, Stamp};
use crate::write::{DEFAULT_WORLD_FRAME, RecordingWriter, write_part};

/// The input of [`import`].
#[derive(Clone, Debug)]
pub struct ImportJob {
    /// Tables of poses, or one recording.
    pub inputs: Vec<PathBuf>,
    /// The recording to be made.
    pub output: PathBuf,
    /// Scene file; it travels in the recording.
    pub scene: Option<PathBuf>,
    /// How the tables are read.
    pub options: TableOptions,
    /// Topics of the bodies, in order, or `NAME=TOPIC`.
    pub topics: Vec<String>,
    /// Marks: when, and of which event.
    pub marks: Vec<ListedMark>,
    /// Poses before are left out [s since the first].
    pub start_s: Option<f64>,
    /// Poses after are left out [s since the first].
    pub end_s: Option<f64>,
}

/// The result of [`import`].
#[derive(Clone, Debug, Serialize)]
pub struct Imported {
    /// The files that were read, with what they are.
    pub inputs: Vec<InputLine>,
    /// The file that was written.
    pub output: String,
    /// Name of the scene that is attached to it.
    pub scene: Option<String>,
    /// What was taken from the tables.
    pub bodies: Vec<BodyLine>,
    /// Messages that were copied from a recording.
    pub copied: Option<u64>,
    /// Messages or poses outside of what was cut out.
    pub left_out: u64,
    /// Marks that were added.
    pub marks: usize,
    /// What speaks against how the files were read.
    pub against: Vec<String>,
    /// What was guessed, and what is left aside.
    pub warnings: Vec<String>,
    /// Parts that could not be read.
    pub lost: Vec<String>,
}

/// A file that was read.
#[derive(Clone, Debug, Serialize)]
pub struct InputLine {
    /// The file.
    pub file: String,
    /// What it is.
    pub kind: String,
}

/// A body that was read.
#[derive(Clone, Debug, Serialize)]
pub struct BodyLine {
    /// Its name in the file, or the file's.
    pub name: String,
    /// Where it is in the recording.
    pub topic: String,
    /// Its poses there.
    pub poses: usize,
    /// Rows in which it has none.
    pub absent: usize,
    /// Rate by the median interval.
    pub rate_hz: Option<f64>,
    /// From its first pose to its last.
    pub duration_s: f64,
    /// Least and greatest coordinate of each axis, z up.
    pub extent_m: [[f64; 2]; 3],
    /// Free flights that the path shows.
    pub flights: Vec<FlightLine>,
}

/// A free flight, told by the path alone.
#[derive(Clone, Debug, Serialize)]
pub struct FlightLine {
    /// Since the first pose of the files.
    pub begin_s: f64,
    /// Since the first pose of the files.
    pub end_s: f64,
    /// How it falls.
    pub acceleration_m_s2: [f64; 3],
}

/// Makes a recording.
///
/// Fails where a file is none that can be read, which says what to do instead, where a table has no poses, or
/// bodies cannot be told apart or assigned to the scene's.
pub fn import(job: &ImportJob) -> anyhow::Result<Imported> {
    for input in job.inputs.iter().chain(&job.scene) {
        check_distinct(input, &job.output)?;
    }
    let scene = job.scene.as_deref().map(read_scene).transpose()?;
    if let (Some(start_s), Some(end_s)) = (job.start_s, job.end_s) {
        ensure!(
            start_s <= end_s,
            "--start {start_s} is after --end {end_s}, expected it before"
        );
    }
    let working = Working::begin("reading");
    let mut tables = Vec::new();
    for input in &job.inputs {
        working.now(input.display().to_string());
        let bytes =
            read_whole(input).with_context(|| format!("{}: cannot read", input.display()))?;
        match kind::of(input, bytes)? {
            Kind::Table(text) => tables.push((input, read_table(input, &text, &job.options)?)),
            Kind::Recording(bytes) => {
                ensure!(
                    job.inputs.len() == 1,
                    "{}: is a recording, expected it alone: only tables are put together",
                    input.display()
                );
                return part(job, input, bytes, scene.as_ref());
            }
        }
    }
    working.now("writing");
    recording(job, &tables, scene.as_ref())
}

fn read_scene(file: &Path) -> anyhow::Result<(Scene, String)> {
    let text = regular::read_text(file)
        .with_context(|| format!("{}: cannot read the scene", file.display()))?;
    let scene =
        scene_from_toml(&text).map_err(|error| error.in_file(file.display().to_string()))?;
    Ok((scene, text))
}

/// The part of a recording that is wanted, with the scene.
fn part(
    job: &ImportJob,
    input: &Path,
    bytes: Vec<u8>,
    scene: Option<&(Scene, String)>,
) -> anyhow::Result<Imported> {
    let path = input.display();
    ensure!(
        job.options == TableOptions::default() && job.topics.is_empty() && job.marks.is_empty(),
        "{path}: is a recording: only --scene, --start and --end apply to it (marks are added by `enact mark`)"
    );
    let recording = Recording::from_bytes(input, bytes)?;
    let container = recording.container();
    let Some((first, _)) = container.log_times() else {
        bail!("{path}: has no messages");
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
    if scene.is_none() && recording.scene_toml().is_none() {
        warnings.push(format!(
            "no {SCENE_NAME} is attached: --scene FILE attaches one"
        ));
    }
    let copied = write_part(&job.output, container, input, from..=to, scene_toml)?;
    let damages = container.damages();
    Ok(Imported {
        inputs: vec![InputLine {
            file: path.to_string(),
            kind: "a recording".to_owned(),
        }],
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

/// The recording of what is in tables.
fn recording(
    job: &ImportJob,
    tables: &[(&PathBuf, PoseTable)],
    scene: Option<&(Scene, String)>,
) -> anyhow::Result<Imported> {
    let named: Vec<Named> = tables
        .iter()
        .flat_map(|(file, table)| {
            table.bodies.iter().map(|body| Named {
                name: body.name.clone().unwrap_or_else(|| name_of_file(file)),
                table,
                body,
            })
        })
        .filter(|named| !named.body.samples.is_empty())
        .collect();
    let names: Vec<(&str, Holds)> = named
        .iter()
        .map(|named| (named.name.as_str(), named.body.samples[0].holds))
        .collect();
    let topics = topics(&names, &job.topics, scene.map(|(scene, _)| scene))?;
    let samples = named.iter().flat_map(|named| &named.body.samples);
    // Every table has a pose.
    let origin = samples.map(|sample| sample.stamp).min().unwrap_or(Stamp(0));
    let mut marks = Vec::new();
    for (time, event) in &job.marks {
        if let (Some(event), Some((scene, _))) = (event, scene) {
            check_event(event, scene)?;
        }
        let stamp = stamp_of(*time, origin)?;
        let event = event.clone();
        marks.push(Mark { stamp, event });
    }
    let is_within = |sample: &&PoseSample| {
        let time_s = sample.stamp.seconds_since(origin);
        job.start_s.is_none_or(|start_s| time_s >= start_s)
            && job.end_s.is_none_or(|end_s| time_s <= end_s)
    };
    let mut entries: Vec<(Stamp, Entry)> = Vec::new();
    let mut bodies = Vec::new();
    let mut of_all = Told::default();
    let mut left_out = 0;
    for (named, topic) in named.iter().zip(&topics) {
        let mut samples: Vec<&PoseSample> = named.body.samples.iter().filter(is_within).collect();
        left_out += (named.body.samples.len() - samples.len()) as u64;
        samples.sort_by_key(|sample| sample.stamp);
        let mut told = told(named, &samples);
        let scene = scene.map(|(scene, _)| scene);
        told.against.extend(unseen(named, topic, scene));
        bodies.push(line(named, topic, &samples, &told, origin));
        of_all.add(told);
        entries.extend(samples.iter().map(|of| (of.stamp, Entry::Pose(topic, of))));
    }
    ensure!(
        !entries.is_empty(),
        "no pose is within --start and --end; the files have {:.3} s",
        named
            .iter()
            .flat_map(|named| &named.body.samples)
            .map(|sample| sample.stamp.seconds_since(origin))
            .fold(0.0, f64::max)
    );
    entries.extend(marks.iter().map(|mark| (mark.stamp, Entry::Mark(mark))));
    entries.sort_by_key(|(stamp, _)| *stamp);
    let marks_topic = scene.map_or("/marks", |(scene, _)| scene.marks_topic.as_str());
    let mut writer = RecordingWriter::create(&job.output)?;
    if let Some((_, text)) = scene {
        writer.attach(SCENE_NAME, "application/toml", text.as_bytes())?;
    }
    for (stamp, entry) in &entries {
        match entry {
            Entry::Pose(topic, sample) => {
                writer.pose(topic, DEFAULT_WORLD_FRAME, *stamp, sample)?;
            }
            Entry::Mark(mark) => writer.mark(marks_topic, *stamp, mark)?,
        }
    }
    writer.finish()?;
    let of_file = |file: &Path, note: &String| match tables.len() {
        1 => note.clone(),
        _ => format!("{}: {note}", file.display()),
    };
    let notes = |of: &dyn Fn(&PoseTable) -> Vec<String>| -> Vec<String> {
        let all = tables.iter().flat_map(|(file, table)| {
            let notes = of(table);
            notes
                .into_iter()
                .map(|note| of_file(file, &note))
                .collect::<Vec<_>>()
        });
        all.collect()
    };
    Ok(Imported {
        inputs: tables
            .iter()
            .map(|(file, table)| InputLine {
                file: file.display().to_string(),
                kind: table.kind.clone(),
            })
            .collect(),
        output: job.output.display().to_string(),
        scene: scene.map(|(scene, _)| scene.name.clone()),
        bodies,
        copied: None,
        left_out,
        marks: marks.len(),
        against: of_all.against,
        warnings: [notes(&|table| table.notes.clone()), of_all.notes].concat(),
        lost: notes(&|table| table.lost.clone()),
    })
}

/// Whether the scene wants more of a body than points, in words.
fn unseen(named: &Named, topic: &str, scene: Option<&Scene>) -> Option<String> {
    let track = scene?.tracks.iter().find(|track| track.topic == topic)?;
    let holds = named.body.samples.first()?.holds;
    let is_enough = holds == Holds::Pose || track.sees == Sees::Point;
    (!is_enough).then(|| {
        format!(
            "{}: has points alone, and the scene's track {:?} sees more; expected sees = \"point\" in a [[body.track]]",
            named.name, track.name
        )
    })
}

enum Entry<'a> {
    Pose(&'a str, &'a PoseSample),
    Mark(&'a Mark),
}

fn line(
    named: &Named,
    topic: &str,
    samples: &[&PoseSample],
    told: &Told,
    origin: Stamp,
) -> BodyLine {
    let mut extent_m = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    for sample in samples {
        for (of, at) in extent_m.iter_mut().zip(sample.position_m.iter()) {
            *of = [of[0].min(*at), of[1].max(*at)];
        }
    }
    let time_s = |index: usize| samples[index].stamp.seconds_since(origin);
    let flights = told.flights.iter().map(|fall| FlightLine {
        begin_s: time_s(fall.samples.start),
        end_s: time_s(fall.samples.end - 1),
        acceleration_m_s2: fall.acceleration.into(),
    });
    let duration_s = match samples {
        [first, .., last] => last.stamp.seconds_since(first.stamp),
        _ => 0.0,
    };
    BodyLine {
        name: named.name.clone(),
        topic: topic.to_owned(),
        poses: samples.len(),
        absent: named.body.absent,
        rate_hz: told.rate_hz,
        duration_s,
        extent_m,
        flights: flights.collect(),
    }
}
