//! Assigns the channels of a recording to the bodies and marks of a scene.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::error::IngestError;
use super::frames::frame_name;
use crate::motion::{Mount, Scene, Timing, TrackIndex};
use crate::wire::container::{Channel, Container};
use crate::wire::decode::{MARK_SCHEMAS, MarkFormat, POSE_SCHEMAS, PoseFormat};
use crate::wire::{FramedPose, KEYFRAME_SCHEMA};

/// Separates a topic from the name of a frame or pose on it.
const CHILD_SEPARATOR: char = '#';

/// Separates a topic, or the name of a pose on it, from the frame in which poses are given.
const FRAME_SEPARATOR: char = '@';

/// Messages of a topic that are looked at for the names of what is on it.
const NAMED_IN: usize = 100;

/// The use of a channel's messages for the scene.
#[derive(Clone, Debug)]
pub(super) struct RouteFeed {
    pub(super) format: RouteFormat,
    /// Indices of the routes that read them: several tracks may share a topic.
    pub(super) routes: Vec<usize>,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum RouteFormat {
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
    /// The frame in which poses are read, where the scene gives one or the topic has several.
    pub(super) frame: Option<String>,
    /// The children that were seen.
    pub(super) seen: BTreeSet<String>,
    /// How the track's tracker is mounted: a keyframe is a pose of the body.
    pub(super) mount: Option<Mount>,
    /// Whether single readings may have times that are not known.
    pub(super) may_be_open: bool,
}

impl Route {
    /// Whether a pose is of what the route reads, by its name.
    pub(super) fn has_child(&self, pose: &FramedPose) -> bool {
        self.child.as_ref().is_none_or(|child| *child == pose.child)
    }
}

/// What a scene's topic refers to in a recording.
struct Resolved {
    topic: String,
    child: Option<String>,
    frame: Option<String>,
}

/// The routes of a scene's tracks, stream by stream, then the one of its marks, and the feeds by
/// channel. An edited sketch needs no marks.
pub(super) fn routes(
    path: &Path,
    container: &Container,
    scene: &Scene,
    notes: &mut Vec<String>,
) -> Result<(Vec<Route>, BTreeMap<u16, RouteFeed>), IngestError> {
    let mut routes = Vec::new();
    let mut feeds: BTreeMap<u16, RouteFeed> = BTreeMap::new();
    let topics = container.topics();
    let present = || topics.iter().map(|topic| (*topic).to_owned()).collect();
    for index in scene.tracks.keys() {
        check_streams(path, &topics, scene, index)?;
        for stream in 0..scene.streams(index) {
            let wanted = scene.stream_topic(index, stream);
            let Resolved {
                topic,
                child,
                frame,
            } = match resolve(&topics, &wanted) {
                Some(resolved) => resolved,
                None => {
                    let body = &scene.link_seen_by(index).name;
                    elsewhere(path, container, body, &wanted, notes)?
                }
            };
            let format = |name: &str, encoding: &str| match (name, encoding) {
                (KEYFRAME_SCHEMA, "json") => Some(RouteFormat::Keyframes),
                _ => PoseFormat::of(name, encoding).map(RouteFormat::Poses),
            };
            for (id, format) in formats(path, container, &topic, format, POSE_SCHEMAS)? {
                let feed = feeds.entry(id).or_insert_with(|| RouteFeed {
                    format,
                    routes: Vec::new(),
                });
                feed.routes.push(routes.len());
            }
            routes.push(Route {
                track: Some(index),
                stream,
                child,
                frame,
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
    let format =
        |name: &str, encoding: &str| MarkFormat::of(name, encoding).map(RouteFormat::Marks);
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
            RouteFeed {
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
        frame: None,
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
    if scene.timing != Timing::Edited || topic.contains([CHILD_SEPARATOR, FRAME_SEPARATOR]) {
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

/// The recording's topic, and the child on it and the frame, to which a scene's topic refers.
fn resolve(present: &BTreeSet<&str>, topic: &str) -> Option<Resolved> {
    let of_topic = |topic: &str, frame: Option<&str>| {
        let resolved = |topic: &str, child: Option<&str>| Resolved {
            topic: topic.to_owned(),
            child: child.map(str::to_owned),
            frame: frame.map(|frame| frame_name(frame).to_owned()),
        };
        if present.contains(topic) {
            return Some(resolved(topic, None));
        }
        let (base, child) = topic.split_once(CHILD_SEPARATOR)?;
        present.contains(base).then(|| resolved(base, Some(child)))
    };
    let (whole, frame) = match topic.rsplit_once(FRAME_SEPARATOR) {
        Some((whole, frame)) => (whole, Some(frame)),
        None => (topic, None),
    };
    // A name may have the separator in it.
    let as_named = of_topic(topic, None);
    let is_child = as_named.as_ref().is_some_and(|of| of.child.is_some());
    match (as_named, frame) {
        (Some(found), None) => Some(found),
        (Some(found), Some(_)) if !is_child => Some(found),
        (as_named, _) => of_topic(whole, frame).or(as_named),
    }
}

/// Where a body is whose topic is not in the recording: on the only one that names it, where the scene has none of its
/// own for it. Fails else, with where it may be.
fn elsewhere(
    path: &Path,
    container: &Container,
    body: &str,
    wanted: &str,
    notes: &mut Vec<String>,
) -> Result<Resolved, IngestError> {
    let offered = offered(container);
    let named: Vec<&(String, String)> = offered.iter().filter(|(_, child)| child == body).collect();
    if let [(topic, child)] = named[..]
        && wanted == format!("/tracker/{body}/pose")
    {
        notes.push(format!(
            "no topic {wanted}: body {body:?} is taken from {topic}{CHILD_SEPARATOR}{child}, the only place with that name"
        ));
        return Ok(Resolved {
            topic: topic.clone(),
            child: Some(child.clone()),
            frame: None,
        });
    }
    let offers = offered.iter().map(|(topic, child)| match child.as_str() {
        "" => topic.clone(),
        child => format!("{topic}{CHILD_SEPARATOR}{child}"),
    });
    let topics = container.topics();
    Err(IngestError::TopicAbsent {
        path: path.to_owned(),
        body: body.to_owned(),
        topic: wanted.to_owned(),
        present: topics.into_iter().map(str::to_owned).collect(),
        offered: offers.collect(),
    })
}

/// The topics with poses and the names on them, by their first messages; of an estimate none.
fn offered(container: &Container) -> BTreeSet<(String, String)> {
    let is_ours = |topic: &str| topic.starts_with("/estimate/") || topic.starts_with("/sketch/");
    let mut left: BTreeMap<u16, (&str, PoseFormat, usize)> = container
        .channels()
        .iter()
        .filter(|(_, channel)| !is_ours(&channel.topic))
        .filter_map(|(id, channel)| {
            let schema = container.schema_of(channel)?;
            let format = PoseFormat::of(&schema.name, &channel.message_encoding)?;
            Some((*id, (channel.topic.as_str(), format, NAMED_IN)))
        })
        .collect();
    let mut found = BTreeSet::new();
    let mut poses: Vec<FramedPose> = Vec::new();
    let mut walk = container.walk();
    while !left.is_empty()
        && let Some(message) = walk.next_message()
    {
        let Some((topic, format, messages)) = left.get_mut(&message.channel_id) else {
            continue;
        };
        *messages -= 1;
        poses.clear();
        if format.decode(message.data, &mut poses).is_ok() {
            found.extend(
                poses
                    .iter()
                    .map(|pose| ((*topic).to_owned(), pose.child.clone())),
            );
        }
        if *messages == 0 {
            left.remove(&message.channel_id);
        }
    }
    found
}

/// The channels of a topic that can be read. Fails if the topic has channels, but none of these.
fn formats(
    path: &Path,
    container: &Container,
    topic: &str,
    format: impl Fn(&str, &str) -> Option<RouteFormat>,
    supported: &'static str,
) -> Result<Vec<(u16, RouteFormat)>, IngestError> {
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
