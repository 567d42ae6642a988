//! Files of other programs become recordings: tables of poses, and parts of recordings.

mod kind;
mod names;
mod recordings;
mod told;
mod tracked;

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow, bail, ensure};
use serde::Serialize;

use self::kind::ImportKind;
use self::names::{Named, listed, name_of_file, topics};
use self::told::{ToldImport, told};
use super::folders::recordings_in;
use super::guard::Inputs;
use super::mark::{check_event, stamp_of};
use super::working::Working;
use crate::config::scene_from_toml;
use crate::ingest::table::{PoseTable, Preset, TableOptions, read_table};
use crate::ingest::{CapturedSession, ListedMark, SCENE_NAME, read_text, read_whole};
use crate::motion::{Holds, Mark, PoseSample, Scene, Sees, Stamp};
use crate::write::{DEFAULT_WORLD_FRAME, RecordingWriter};

/// The input of [`import`].
#[derive(Clone, Debug)]
pub struct ImportJob {
    /// Tables of poses, or recordings of one bag, or the folder of that.
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
    let files = recordings_in(&job.inputs)?;
    let inputs = files.iter().chain(&job.scene);
    Inputs::of(inputs.map(PathBuf::as_path)).keep_from(&job.output)?;
    let scene = job.scene.as_deref().map(read_scene).transpose()?;
    if let (Some(start_s), Some(end_s)) = (job.start_s, job.end_s) {
        ensure!(
            start_s <= end_s,
            "--start {start_s} is after --end {end_s}, expected it before"
        );
    }
    let working = Working::begin("reading");
    let mut tables = Vec::new();
    let mut recordings = Vec::new();
    for input in &files {
        working.now(input.display().to_string());
        let bytes =
            read_whole(input).with_context(|| format!("{}: cannot read", input.display()))?;
        match kind::of(input, bytes)? {
            ImportKind::Table(text) => {
                let mut table = read_table(input, &text.text, &job.options)?;
                table.notes.extend(text.note);
                tables.push((input, table));
            }
            ImportKind::Captured(session) => {
                let table = session_table(input, session, &job.options)?;
                tables.push((input, table));
            }
            ImportKind::Recording(bytes) => recordings.push((input.clone(), bytes)),
        }
    }
    working.now("writing");
    if let (Some((recording, _)), Some((table, _))) = (recordings.first(), tables.first()) {
        bail!(
            "{} is a recording and {} a table, expected files of one kind: import the table first, then both recordings",
            recording.display(),
            table.display()
        );
    }
    if !recordings.is_empty() {
        return recordings::recordings(job, recordings, scene.as_ref());
    }
    one_zero(&mut tables);
    recording(job, &tables, scene.as_ref())
}

/// The poses of a captured session, y up unless it is said otherwise, with its presses.
fn session_table(
    input: &Path,
    mut session: CapturedSession,
    options: &TableOptions,
) -> anyhow::Result<PoseTable> {
    let preset = options.preset.or(Preset::named("y-up"));
    let mut buttons: Vec<&str> = Vec::new();
    for column in &options.mark_columns {
        ensure!(
            column.level.is_none(),
            "{}: says itself when a button goes down, expected --mark-column {} without a level",
            input.display(),
            column.name
        );
        buttons.push(&column.name);
    }
    let options = TableOptions {
        preset,
        mark_columns: Vec::new(),
        ..options.clone()
    };
    let mut table = read_table(input, &session.table, &options)?;
    let presses = session.presses_of(&buttons);
    let presses_ms = presses.map_err(|why| anyhow!("{}: {why}", input.display()))?;
    table.kind = session.kind;
    table.notes.extend(session.notes);
    let stamp = |ms: f64| Stamp((1e6 * ms).round() as i64);
    table.presses = presses_ms.into_iter().map(stamp).collect();
    Ok(table)
}

/// Tables that count frames or rows begin together, at the first of all: what was seen later in one of them stays later.
fn one_zero(tables: &mut [(&PathBuf, PoseTable)]) {
    let zeros: Option<Vec<Stamp>> = tables.iter().map(|(_, table)| table.zero).collect();
    let Some(first) = zeros.and_then(|zeros| zeros.into_iter().min()) else {
        return;
    };
    for (_, table) in tables {
        let samples = table.bodies.iter_mut().flat_map(|body| &mut body.samples);
        let marks = table.marks.iter_mut().map(|(_, stamp)| stamp);
        let marks = marks.chain(&mut table.presses);
        for stamp in samples.map(|sample| &mut sample.stamp).chain(marks) {
            stamp.0 = stamp.0.saturating_sub(first.0);
        }
    }
}

/// What speaks against files on one clock: one of them is long over when another begins.
fn apart(tables: &[(&PathBuf, PoseTable)]) -> Option<String> {
    let span = |table: &PoseTable| -> Option<[Stamp; 2]> {
        let stamps = || {
            table
                .bodies
                .iter()
                .flat_map(|body| &body.samples)
                .map(|sample| sample.stamp)
        };
        Some([stamps().min()?, stamps().max()?])
    };
    let spans: Vec<(&PathBuf, [Stamp; 2])> = tables
        .iter()
        .filter_map(|(file, table)| Some((*file, span(table)?)))
        .collect();
    let longest_s = spans
        .iter()
        .map(|(_, [first, last])| last.seconds_since(*first))
        .fold(0.0, f64::max);
    let gap = |(file, of): &(&PathBuf, [Stamp; 2]), (other, to): &(&PathBuf, [Stamp; 2])| {
        let gap_s = to[0].seconds_since(of[1]);
        (gap_s > longest_s.max(1.0)).then(|| {
            format!(
                "{} begins {gap_s:.3} s after {} ends: are their clocks different? Expected files on one clock, or each \
                 imported by itself",
                other.display(),
                file.display()
            )
        })
    };
    spans
        .iter()
        .find_map(|of| spans.iter().find_map(|to| gap(of, to)))
}

fn read_scene(file: &Path) -> anyhow::Result<(Scene, String)> {
    let text =
        read_text(file).with_context(|| format!("{}: cannot read the scene", file.display()))?;
    let scene =
        scene_from_toml(&text).map_err(|error| error.in_file(file.display().to_string()))?;
    Ok((scene, text))
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
        .collect();
    let (named, never): (Vec<Named>, Vec<Named>) = named
        .into_iter()
        .partition(|named| !named.body.samples.is_empty());
    let names: Vec<(&str, Holds)> = named
        .iter()
        .map(|named| (named.name.as_str(), named.body.samples[0].holds))
        .collect();
    let scene_read = scene.map(|(scene, _)| scene);
    let topics = topics(&names, &job.topics, scene_read)?;
    let mut of_all = ToldImport::default();
    of_all.against.extend(apart(tables));
    if !never.is_empty() {
        let never: Vec<&str> = never.iter().map(|named| named.name.as_str()).collect();
        of_all
            .notes
            .push(format!("never seen, and left out: {}", listed(&never)));
    }
    let strangers = names
        .iter()
        .zip(&topics)
        .filter(|(_, topic)| topic.is_none());
    let strangers: Vec<&str> = strangers.map(|((name, _), _)| *name).collect();
    if !strangers.is_empty() {
        of_all.notes.push(format!(
            "left out, as the scene has no bodies of these names (--topic NAME=TOPIC takes them): {}",
            listed(&strangers)
        ));
    }
    let named: Vec<(&Named, &String)> = named
        .iter()
        .zip(&topics)
        .filter_map(|(named, topic)| Some((named, topic.as_ref()?)))
        .collect();
    let samples = named.iter().flat_map(|(named, _)| &named.body.samples);
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
    marks.extend(marks_of_heads(tables, &marks, scene_read, &mut of_all));
    let is_within = |sample: &&PoseSample| {
        let time_s = sample.stamp.seconds_since(origin);
        job.start_s.is_none_or(|start_s| time_s >= start_s)
            && job.end_s.is_none_or(|end_s| time_s <= end_s)
    };
    let mut entries: Vec<(Stamp, Entry)> = Vec::new();
    let mut bodies = Vec::new();
    let mut left_out = 0;
    for (named, topic) in &named {
        let mut samples: Vec<&PoseSample> = named.body.samples.iter().filter(is_within).collect();
        left_out += (named.body.samples.len() - samples.len()) as u64;
        samples.sort_by_key(|sample| sample.stamp);
        let mut told = told(named, &samples, scene_read);
        told.against.extend(unseen(named, topic, scene_read));
        bodies.push(line(named, topic, &samples, &told, origin));
        of_all.add(told);
        entries.extend(
            samples
                .iter()
                .map(|of| (of.stamp, Entry::Pose(topic.as_str(), of))),
        );
    }
    ensure!(
        !entries.is_empty(),
        "no pose is within --start and --end; the files have {:.3} s",
        named
            .iter()
            .flat_map(|(named, _)| &named.body.samples)
            .map(|sample| sample.stamp.seconds_since(origin))
            .fold(0.0, f64::max)
    );
    entries.extend(marks.iter().map(|mark| (mark.stamp, Entry::Mark(mark))));
    entries.sort_by_key(|(stamp, _)| *stamp);
    let marks_topic = scene.map_or("/marks", |(scene, _)| scene.marks_topic.as_str());
    let files = tables.iter().map(|(file, _)| file.as_path());
    let made_of: Vec<&Path> = files.chain(job.scene.as_deref()).collect();
    let mut writer = RecordingWriter::create_of(&job.output, &made_of)?;
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
        against: [notes(&|table| table.against.clone()), of_all.against].concat(),
        warnings: [notes(&|table| table.notes.clone()), of_all.notes].concat(),
        lost: notes(&|table| table.lost.clone()),
    })
}

/// The marks that the files have themselves. Of a scene, those of its events are taken, as long as none is set by hand.
fn marks_of_heads(
    tables: &[(&PathBuf, PoseTable)],
    by_hand: &[Mark],
    scene: Option<&Scene>,
    told: &mut ToldImport,
) -> Vec<Mark> {
    let mut marks = Vec::new();
    for (name, stamp) in tables.iter().flat_map(|(_, table)| &table.marks) {
        let is_known = scene.is_none_or(|scene| scene.has_event_named(name));
        let is_set = by_hand.iter().any(|mark| mark.event.as_ref() == Some(name));
        if is_known && !is_set {
            let event = Some(name.clone());
            marks.push(Mark {
                stamp: *stamp,
                event,
            });
            continue;
        }
        let why = match is_set {
            true => "--mark sets it",
            false => "the scene has no event of that name; --mark TIME:EVENT sets one",
        };
        told.notes
            .push(format!("the file's event {name:?} is left out: {why}"));
    }
    // A press is of the next event, in order; who says marks by hand wants those.
    if by_hand.is_empty() {
        let presses = tables.iter().flat_map(|(_, table)| &table.presses);
        marks.extend(presses.map(|stamp| Mark {
            stamp: *stamp,
            event: None,
        }));
    }
    if !marks.is_empty() {
        told.notes
            .push(format!("{} events of the files are marks", marks.len()));
    }
    marks
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
    told: &ToldImport,
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
        absent: named.body.unseen.count(),
        rate_hz: told.rate_hz,
        duration_s,
        extent_m,
        flights: flights.collect(),
    }
}
