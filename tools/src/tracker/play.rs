//! A recording sent as it was recorded, a performance as it is acted.

use std::path::Path;
use std::time::Instant;

use anyhow::Context;
use enact::config::scene_from_toml;
use enact::ingest::Recording;
use enact::ingest::live::{MarkRecord, NO_TIME, Node, PoseRecord, stream_topics};
use enact::motion::{Scene, Stamp, TakeEvent};
use enact::write::TrackerPublisher;
use serde::Serialize;

use super::fault::Faulty;
use super::{Arguments, Director, now_ns, read, session, wait_until};
use crate::perform::wish::Wanted;

/// What was sent.
#[derive(Default, Serialize)]
pub struct Sent {
    /// Samples.
    pub poses: u64,
    /// Marks.
    pub marks: u64,
    /// When the first thing was sent [ns since 1970].
    pub first_ns: Option<i64>,
    /// When the last thing was sent [ns since 1970].
    pub last_ns: Option<i64>,
}

impl Sent {
    /// Something is sent at that time.
    pub fn at(&mut self, now_ns: i64) -> i64 {
        self.first_ns.get_or_insert(now_ns);
        self.last_ns = Some(now_ns);
        now_ns
    }
}

/// What is sent, in that order.
struct Part {
    scene: Scene,
    events: Vec<TakeEvent>,
    /// When each is sent, on the clock of the stamps.
    due: Vec<Stamp>,
    /// Whether stamps become times of now.
    is_now: bool,
}

/// Sends a recording.
pub fn recording(arguments: &Arguments, node: &Node, path: &Path) -> anyhow::Result<Sent> {
    let recording = Recording::open(path)?;
    let text = match &arguments.scene {
        Some(scene) => read(scene)?,
        None => {
            let attached = recording
                .scene_toml()
                .context("no scene attached, expected --scene")?;
            String::from_utf8(attached.to_vec())?
        }
    };
    let scene = scene_from_toml(&text)?;
    let events = recording.take(&scene)?.events;
    let part = Part {
        due: events.iter().map(stamp).collect(),
        scene,
        events,
        is_now: arguments.now,
    };
    send(arguments, node, &part)
}

/// Acts a motion: samples and marks as they reach the tracker, with its latency.
pub fn perform(arguments: &Arguments, node: &Node, wanted: Wanted) -> anyhow::Result<Sent> {
    let (performance, scene_toml) = arguments.manner.perform(wanted)?;
    let part = Part {
        scene: scene_from_toml(&scene_toml)?,
        events: performance.events,
        due: performance.arrivals,
        // A beginning that was asked for is kept.
        is_now: arguments.manner.knobs.start_ns.is_none(),
    };
    send(arguments, node, &part)
}

fn send(arguments: &Arguments, node: &Node, part: &Part) -> anyhow::Result<Sent> {
    let Part {
        scene, events, due, ..
    } = part;
    let topics = stream_topics(scene);
    let names: Vec<String> = topics.iter().map(|topic| topic.topic.clone()).collect();
    let publisher = TrackerPublisher::open(node, &names, &scene.marks_topic)?;
    let session = session();
    let mut director = Director::new(arguments, node, &publisher, session)?;
    director.begin(arguments)?;
    let first = events.iter().map(stamp).min().unwrap_or(Stamp(0));
    let moved_ns = if part.is_now { now_ns() - first.0 } else { 0 };
    let mut sequences = vec![0; topics.len()];
    let mut faulty = Faulty::new(&arguments.faults);
    let mut sent = Sent::default();
    let begun = Instant::now();
    for (event, due) in events.iter().zip(due) {
        if arguments.rate > 0.0 {
            wait_until(begun, due.seconds_since(first) / arguments.rate);
        }
        let sample_ns = stamp(event).0 + moved_ns;
        match event {
            TakeEvent::Pose {
                body,
                stream,
                sample,
            } => {
                let is_it =
                    |t: &enact::ingest::live::StreamTopic| (t.body, t.stream) == (*body, *stream);
                let topic = topics
                    .iter()
                    .position(is_it)
                    .context("a stream of the scene")?;
                let record = PoseRecord {
                    sequence: sequences[topic],
                    available_ns: sent.at(now_ns()),
                    sample_ns: if arguments.no_sample_time {
                        NO_TIME
                    } else {
                        sample_ns
                    },
                    device_ns: sample.stamp.0 - first.0,
                    position_m: sample.position_m.into(),
                    quaternion_xyzw: sample.quaternion_xyzw,
                    flags: 1,
                    session,
                };
                sequences[topic] += 1;
                for (topic, record) in faulty.sent(topic, record) {
                    publisher.pose(topic, record)?;
                    sent.poses += 1;
                }
            }
            TakeEvent::Mark(mark) => {
                publisher.mark(MarkRecord {
                    sequence: sent.marks,
                    available_ns: sent.at(now_ns()),
                    sample_ns: if arguments.no_sample_time {
                        NO_TIME
                    } else {
                        sample_ns
                    },
                    device_ns: NO_TIME,
                    event: MarkRecord::event_bytes(mark.event.as_deref().unwrap_or_default()),
                    flags: 0,
                    session,
                })?;
                sent.marks += 1;
            }
        }
    }
    director.end(arguments)?;
    Ok(sent)
}

fn stamp(event: &TakeEvent) -> Stamp {
    match event {
        TakeEvent::Pose { sample, .. } => sample.stamp,
        TakeEvent::Mark(mark) => mark.stamp,
    }
}
