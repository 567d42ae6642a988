//! The streams of a recording that a calibration is made of.

use std::path::Path;

use anyhow::{Context, bail};

use super::super::finish::{attached_scene, lost, warnings};
use super::CalibrateChoice;
use crate::calibrate::Stream;
use crate::config::{SourceLine, scene_from_toml};
use crate::ingest::{Recording, read_text};
use crate::motion::{PoseSample, Scene, Sees, Stamp, TakeEvent, Track, TrackIndex};
use crate::service::provenance::file_name;

/// Scenes with one and two trackers, by which recordings are read; topics are put in.
const READERS: [&str; 2] = [
    "name = \"calibration\"\n[timing]\nstamps = \"physical\"\n\
     [[body]]\nname = \"one\"\nshape = { kind = \"sphere\", radius_mm = 10 }\nmass_g = 1\n",
    "name = \"calibration\"\n[timing]\nstamps = \"physical\"\n\
     [[body]]\nname = \"one\"\nshape = { kind = \"sphere\", radius_mm = 10 }\nmass_g = 1\n\
     [[body]]\nname = \"other\"\nshape = { kind = \"sphere\", radius_mm = 10 }\nmass_g = 1\n",
];

/// Marks, where no scene says otherwise.
const MARKS_TOPIC: &str = "/marks";

/// One recording, read for a calibration.
pub(super) struct Read {
    /// The recording, as it was named.
    pub(super) file: String,
    pub(super) topics: Vec<String>,
    /// One per topic; times count from the first sample of the first.
    pub(super) streams: Vec<Stream>,
    /// The first poses of the streams, before any part of them was chosen.
    begins_s: Vec<f64>,
    messages: Vec<usize>,
    /// Marks \[s\], in order.
    pub(super) marks_s: Vec<f64>,
    /// The scene, and of it the tracks of the topics, where they were chosen by it.
    pub(super) scene: Option<(Scene, Vec<TrackIndex>)>,
    pub(super) lost: Vec<String>,
    pub(super) warnings: Vec<String>,
}

impl Read {
    /// Track of the first stream, with its scene.
    pub(super) fn track(&self) -> Option<(&Scene, &Track)> {
        let (scene, tracks) = self.scene.as_ref()?;
        Some((scene, &scene.tracks[*tracks.first()?]))
    }

    /// The recording's name without folders, as files that are made of it have it.
    pub(super) fn name(&self) -> String {
        file_name(Path::new(&self.file))
    }

    /// What the calibration says of its streams.
    pub(super) fn sources(&self) -> Vec<SourceLine> {
        let streams = self.streams.iter().enumerate();
        let sources = streams.map(|(at, stream)| {
            let [first_s, last_s] = stream.extent_s();
            SourceLine {
                file: self.name(),
                sha256: None,
                topic: self.topics[at].clone(),
                poses: stream.readings.len(),
                dropped: stream.unusable + stream.repeated,
                first_stamp_ns: stream
                    .origin
                    .0
                    .saturating_add((first_s * 1e9).round() as i64),
                from_s: first_s - self.begins_s[at],
                to_s: last_s - self.begins_s[at],
            }
        });
        sources.collect()
    }

    /// What is to know of the streams.
    pub(super) fn notes(&self) -> Vec<String> {
        let streams = self.streams.iter().zip(&self.topics).zip(&self.messages);
        let dropped = streams.filter_map(|((stream, topic), messages)| {
            let [unusable, repeated] = [stream.unusable, stream.repeated];
            (unusable + repeated > 0).then(|| {
                format!(
                    "{}: of {messages} messages on {topic} {unusable} hold no pose and {repeated} have \
                     the stamp of another: left out",
                    self.name()
                )
            })
        });
        dropped.chain(self.warnings.iter().cloned()).collect()
    }
}

/// Reads as many streams of a recording as are wanted, each with at least so many poses.
pub(super) fn read(
    path: &Path,
    choice: &CalibrateChoice,
    count: usize,
    least: usize,
) -> anyhow::Result<Read> {
    let recording = Recording::open(path)?;
    let file = path.display().to_string();
    let scene = match &choice.scene {
        Some(file) => {
            let text = read_text(file)
                .with_context(|| format!("{}: cannot read the scene", file.display()))?;
            let scene = scene_from_toml(&text);
            Some(scene.map_err(|error| error.in_file(file.display().to_string()))?)
        }
        None if recording.only_scene()?.is_some() => Some(attached_scene(&recording)?),
        None => None,
    };
    let (topics, tracks) =
        choose(&recording, scene.as_ref(), choice, count).with_context(|| file.clone())?;
    let mut reader = scene_from_toml(READERS[count - 1])?;
    for (track, topic) in reader.tracks.iter_mut().zip(&topics) {
        track.topic.clone_from(topic);
    }
    let marks_topic = scene.as_ref().map(|scene| scene.marks_topic.as_str());
    reader.marks_topic = marks_topic.unwrap_or(MARKS_TOPIC).to_owned();
    let take = recording.take(&reader)?;
    let mut samples: Vec<Vec<PoseSample>> = vec![Vec::new(); count];
    let mut marks: Vec<Stamp> = Vec::new();
    for event in take.events {
        match event {
            TakeEvent::Pose { track, sample, .. } => samples[usize::from(track)].push(sample),
            TakeEvent::Mark(mark) => marks.push(mark.stamp),
        }
    }
    let mut streams: Vec<Stream> = Vec::new();
    for (samples, topic) in samples.iter().zip(&topics) {
        let origin = streams.first().map(|first| first.origin);
        let stream = Stream::of(samples, origin, least);
        streams.push(stream.with_context(|| format!("{file}: {topic}"))?);
    }
    let origin = streams[0].origin;
    let mut marks_s: Vec<f64> = marks
        .iter()
        .map(|stamp| (i128::from(stamp.0) - i128::from(origin.0)) as f64 * 1e-9)
        .collect();
    marks_s.sort_by(f64::total_cmp);
    let begins_s: Vec<f64> = streams.iter().map(|stream| stream.extent_s()[0]).collect();
    let part = |stream: Stream| stream.between(choice.from_s, choice.to_s, least);
    let streams = streams.into_iter().map(part).collect::<Result<_, _>>();
    Ok(Read {
        streams: streams.with_context(|| file.clone())?,
        file,
        topics,
        begins_s,
        messages: samples.iter().map(Vec::len).collect(),
        marks_s,
        scene: scene.zip(tracks),
        lost: lost(&take.report),
        warnings: warnings(&take.report),
    })
}

/// The topics that are asked for, else those of a body of the scene, else all that hold poses, if
/// they are as many as are needed; and the scene's tracks of them.
fn choose(
    recording: &Recording,
    scene: Option<&Scene>,
    choice: &CalibrateChoice,
    count: usize,
) -> anyhow::Result<(Vec<String>, Option<Vec<TrackIndex>>)> {
    let present = recording.pose_topics();
    let of_scene = |scene: &Scene| -> Vec<TrackIndex> {
        let tracks = scene.tracks.iter_enumerated();
        let tracks = tracks.filter(|(_, track)| {
            let is_body = |body: &String| *body == scene.links[track.link].name;
            let is_topic = choice.topics.is_empty() || choice.topics.contains(&track.topic);
            track.sees == Sees::Pose && choice.body.as_ref().is_none_or(is_body) && is_topic
        });
        tracks.map(|(index, _)| index).collect()
    };
    if let (Some(body), Some(scene)) = (&choice.body, scene)
        && !scene.links.iter().any(|link| link.name == *body)
    {
        let names: Vec<&str> = scene.links.iter().map(|link| link.name.as_str()).collect();
        bail!(
            "the scene has no body {body:?}, expected one of {}",
            names.join(", ")
        );
    }
    let tracks = scene.map(of_scene).filter(|tracks| tracks.len() == count);
    if !choice.topics.is_empty() {
        if choice.topics.len() != count {
            bail!("{} topics, expected {count}", choice.topics.len());
        }
        // In the order in which they are asked for.
        let tracks = tracks.map(|mut tracks| {
            let place = |track: &TrackIndex| {
                let topic = &scene.expect("tracks are of a scene").tracks[*track].topic;
                choice.topics.iter().position(|of| of == topic)
            };
            tracks.sort_by_key(place);
            tracks
        });
        return Ok((choice.topics.clone(), tracks));
    }
    if let (Some(tracks), Some(scene)) = (tracks, scene) {
        let topics = tracks
            .iter()
            .map(|track| scene.tracks[*track].topic.clone());
        return Ok((topics.collect(), Some(tracks)));
    }
    if scene.is_none() && present.len() == count {
        return Ok((
            present.iter().map(|topic| (*topic).to_owned()).collect(),
            None,
        ));
    }
    let what = if count == 1 {
        "one stream"
    } else {
        "two streams"
    };
    bail!(
        "which {what} of poses? Expected {} among {}",
        if count == 1 {
            "--topic TOPIC (or --body NAME)"
        } else {
            "--topics ONE OTHER"
        },
        if present.is_empty() {
            "none at all".to_owned()
        } else {
            present.join(", ")
        }
    );
}
