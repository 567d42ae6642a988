//! Assigns the channels of a recording to the bodies and marks of a scene.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::error::IngestError;
use crate::motion::{Mount, Scene, Timing, TrackIndex};
use crate::wire::KEYFRAME_SCHEMA;
use crate::wire::container::{Channel, Container};
use crate::wire::decode::{MARK_SCHEMAS, MarkFormat, POSE_SCHEMAS, PoseFormat};

/// Separates a topic from the name of a frame or pose on it.
const CHILD_SEPARATOR: char = '#';

/// The use of a channel's messages for the scene.
#[derive(Clone, Debug)]
pub(super) struct Feed {
    pub(super) format: Format,
    /// Indices of the routes that read them: several tracks may share a topic.
    pub(super) routes: Vec<usize>,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Format {
    Poses(PoseFormat),
    /// `enact.Keyframe`: what is known of the body itself.
    Keyframes,
    Marks(MarkFormat),
}

/// One stream's claim to a topic. Routes are numbered as `TakeReport::topics`.
#[derive(Clone, Debug)]
pub(super) struct Route {
    /// The track that it feeds; the marks feed none.
    pub(super) track: Option<TrackIndex>,
    /// Index of the stream among the track's.
    pub(super) stream: usize,
    /// Topic as the scene writes it.
    pub(super) topic: String,
    /// Name of the child frame, where the scene gives one.
    pub(super) child: Option<String>,
    /// The children that were seen.
    pub(super) seen: BTreeSet<String>,
    /// How the track's tracker is mounted: a keyframe is a pose of the body.
    pub(super) mount: Option<Mount>,
    /// Whether single readings may have times that are not known.
    pub(super) may_be_open: bool,
}

/// The routes of a scene's tracks, stream by stream, then the one of its marks, and the feeds by
/// channel. An edited sketch needs no marks.
pub(super) fn routes(
    path: &Path,
    container: &Container,
    scene: &Scene,
) -> Result<(Vec<Route>, BTreeMap<u16, Feed>), IngestError> {
    let mut routes = Vec::new();
    let mut feeds: BTreeMap<u16, Feed> = BTreeMap::new();
    let topics = container.topics();
    let present = || topics.iter().map(|topic| (*topic).to_owned()).collect();
    for index in scene.tracks.keys() {
        check_streams(path, &topics, scene, index)?;
        for stream in 0..scene.streams(index) {
            let wanted = scene.stream_topic(index, stream);
            let (topic, child) =
                resolve(&topics, &wanted).ok_or_else(|| IngestError::TopicAbsent {
                    path: path.to_owned(),
                    body: scene.link_seen_by(index).name.clone(),
                    topic: wanted.clone(),
                    present: present(),
                })?;
            let format = |name: &str, encoding: &str| match (name, encoding) {
                (KEYFRAME_SCHEMA, "json") => Some(Format::Keyframes),
                _ => PoseFormat::of(name, encoding).map(Format::Poses),
            };
            for (id, format) in formats(path, container, topic, format, POSE_SCHEMAS)? {
                let feed = feeds.entry(id).or_insert_with(|| Feed {
                    format,
                    routes: Vec::new(),
                });
                feed.routes.push(routes.len());
            }
            routes.push(Route {
                track: Some(index),
                stream,
                child: child.map(str::to_owned),
                seen: BTreeSet::new(),
                topic: wanted,
                mount: Some(scene.mount(index)),
                may_be_open: scene.may_have_open_times(index),
            });
        }
    }
    let marks = scene.marks_topic.as_str();
    if scene.timing == Timing::Edited && !topics.contains(marks) {
        return Ok((routes, feeds));
    }
    let format = |name: &str, encoding: &str| MarkFormat::of(name, encoding).map(Format::Marks);
    // Marks on another topic suggest a mistake in the scene; a recording may also have no marks.
    let is_marks = |channel: &Channel| {
        let schema = container
            .schema_of(channel)
            .map_or("", |schema| schema.name.as_str());
        format(schema, &channel.message_encoding).is_some()
    };
    // The events of an earlier estimate in the recording are no marks.
    let mut theirs = container
        .channels()
        .values()
        .filter(|c| !c.topic.starts_with("/estimate/"));
    if !topics.contains(marks) && theirs.any(is_marks) {
        return Err(IngestError::MarksAbsent {
            path: path.to_owned(),
            topic: marks.to_owned(),
            present: present(),
        });
    }
    for (id, format) in formats(path, container, marks, format, MARK_SCHEMAS)? {
        feeds.insert(
            id,
            Feed {
                format,
                routes: vec![routes.len()],
            },
        );
    }
    routes.push(Route {
        track: None,
        stream: 0,
        topic: marks.to_owned(),
        child: None,
        seen: BTreeSet::new(),
        mount: None,
        may_be_open: false,
    });
    Ok((routes, feeds))
}

/// Fails where an edited sketch does not have as many segments as the scene's events require.
fn check_streams(
    path: &Path,
    present: &BTreeSet<&str>,
    scene: &Scene,
    track: TrackIndex,
) -> Result<(), IngestError> {
    let topic = &scene.tracks[track].topic;
    // Frames on one topic are known only when their messages are read.
    if scene.timing != Timing::Edited || topic.contains(CHILD_SEPARATOR) {
        return Ok(());
    }
    let numbered = |present: &&str| {
        let number = present.strip_prefix(topic.as_str())?.strip_prefix('/')?;
        number.parse::<usize>().ok()
    };
    let found: Vec<&str> = present
        .iter()
        .copied()
        .filter(|t| numbered(t).is_some())
        .collect();
    let expected = scene.streams(track);
    let is_wanted = |number: usize| (1..=expected).contains(&number);
    if found.len() == expected && found.iter().filter_map(numbered).all(is_wanted) {
        return Ok(());
    }
    Err(IngestError::SegmentCount {
        path: path.to_owned(),
        body: scene.link_seen_by(track).name.clone(),
        topic: topic.clone(),
        expected,
        found: found.into_iter().map(str::to_owned).collect(),
    })
}

/// The recording's topic, and the child on it, to which a scene's topic refers.
fn resolve<'a>(present: &BTreeSet<&str>, topic: &'a str) -> Option<(&'a str, Option<&'a str>)> {
    if present.contains(topic) {
        return Some((topic, None));
    }
    let (base, child) = topic.split_once(CHILD_SEPARATOR)?;
    present.contains(base).then_some((base, Some(child)))
}

/// The channels of a topic that can be read. Fails if the topic has channels, but none of these.
fn formats(
    path: &Path,
    container: &Container,
    topic: &str,
    format: impl Fn(&str, &str) -> Option<Format>,
    supported: &'static str,
) -> Result<Vec<(u16, Format)>, IngestError> {
    let schema_name = |channel: &Channel| {
        container
            .schema_of(channel)
            .map_or(String::new(), |schema| schema.name.clone())
    };
    let mut found = Vec::new();
    let mut refused = None;
    for (&id, channel) in container.channels() {
        if channel.topic != topic {
            continue;
        }
        match format(&schema_name(channel), &channel.message_encoding) {
            Some(format) => found.push((id, format)),
            None => refused = Some(channel),
        }
    }
    match refused {
        Some(channel) if found.is_empty() => {
            let schema = schema_name(channel);
            Err(IngestError::Unsupported {
                path: path.to_owned(),
                topic: topic.to_owned(),
                schema: if schema.is_empty() {
                    "messages without a schema".to_owned()
                } else {
                    schema
                },
                encoding: channel.message_encoding.clone(),
                supported,
            })
        }
        _ => Ok(found),
    }
}
