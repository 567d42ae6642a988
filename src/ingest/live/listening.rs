//! The subscribers of a scene.

use std::time::Instant;

use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::ZeroCopySend;

use super::answer_parts::{AnswerParts, Answered};
use crate::motion::{Scene, TrackIndex};
use crate::wire::live::{
    ANSWER_SERVICE, AnswerRecord, CONTROL_SERVICE, ControlRecord, LABEL_SERVICE, LabelRecord,
    LiveError, LiveService, MarkRecord, Node, PoseRecord, Quality, TAKE_SERVICE, TakeRecord,
    service_name,
};

/// Greatest number of samples taken from one service at a time: the rest stays in its buffer until
/// the other services were read.
const AT_ONCE: usize = 4096;

/// A record that arrived.
#[derive(Clone, Debug, PartialEq)]
pub enum Arrived {
    /// A reading on one of the scene's streams, in the order of [`stream_topics`].
    Pose {
        /// Index of the stream.
        stream: usize,
        /// As sent.
        record: PoseRecord,
        /// The buffer was full, or nearly: missing sequence numbers were likely lost there.
        is_overflow: bool,
    },
    /// A mark.
    Mark(MarkRecord),
    /// What a director says of the take.
    Label(Box<LabelRecord>),
    /// A command.
    Control(ControlRecord),
}

/// A record with its arrival.
#[derive(Clone, Debug, PartialEq)]
pub struct Arrival {
    /// When it was taken from iceoryx2.
    pub at: Instant,
    /// The record.
    pub what: Arrived,
}

/// A stream of poses of a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StreamTopic {
    /// The track.
    pub track: TrackIndex,
    /// Index of the stream among the track's.
    pub stream: usize,
    /// The topic.
    pub topic: String,
}

/// All streams of a scene, track by track.
pub fn stream_topics(scene: &Scene) -> Vec<StreamTopic> {
    let streams = |track| (0..scene.streams(track)).map(move |stream| (track, stream));
    scene
        .tracks
        .keys()
        .flat_map(streams)
        .map(|(track, stream)| StreamTopic {
            track,
            stream,
            topic: scene.stream_topic(track, stream),
        })
        .collect()
}

/// One subscriber and the size of its buffer.
struct SubscriberPort<T: core::fmt::Debug + ZeroCopySend + 'static> {
    name: String,
    subscriber: Subscriber<LiveService, T, ()>,
    buffer: usize,
}

/// The subscribers of a scene. They stay on the thread that opened them.
pub struct Listening {
    poses: Vec<SubscriberPort<PoseRecord>>,
    marks: SubscriberPort<MarkRecord>,
    labels: SubscriberPort<LabelRecord>,
    control: SubscriberPort<ControlRecord>,
    shortcomings: Vec<String>,
}

impl Listening {
    /// Makes or opens the services of a scene and subscribes to them.
    pub fn open(node: &Node, scene: &Scene) -> Result<Self, LiveError> {
        let mut shortcomings = Vec::new();
        let mut poses = Vec::new();
        for stream in stream_topics(scene) {
            let name = service_name(&stream.topic);
            poses.push(port(node, &name, Quality::POSES, &mut shortcomings)?);
        }
        let marks = service_name(&scene.marks_topic);
        Ok(Self {
            poses,
            marks: port(node, &marks, Quality::NOTES, &mut shortcomings)?,
            labels: port(node, LABEL_SERVICE, Quality::NOTES, &mut shortcomings)?,
            control: port(node, CONTROL_SERVICE, Quality::NOTES, &mut shortcomings)?,
            shortcomings,
        })
    }

    /// Where services made by other processes have less quality than wanted, in words with figures.
    pub fn shortcomings(&self) -> &[String] {
        &self.shortcomings
    }

    /// Takes the poses, marks and labels that have arrived. Those of one service are in order.
    pub fn take(&self, into: &mut Vec<Arrival>) -> Result<(), LiveError> {
        for (stream, port) in self.poses.iter().enumerate() {
            let before = into.len();
            port.take(into, |record| Arrived::Pose {
                stream,
                record,
                is_overflow: false,
            })?;
            let is_full = into.len() - before >= port.buffer.min(AT_ONCE);
            if is_full {
                for arrival in &mut into[before..] {
                    if let Arrived::Pose { is_overflow, .. } = &mut arrival.what {
                        *is_overflow = true;
                    }
                }
            }
        }
        self.marks.take(into, Arrived::Mark)?;
        self.labels
            .take(into, |record| Arrived::Label(Box::new(record)))
    }

    /// Takes the commands that have arrived. Samples sent before a command have arrived when the
    /// command has: take the samples after it.
    pub fn take_control(&self, into: &mut Vec<Arrival>) -> Result<(), LiveError> {
        self.control.take(into, Arrived::Control)
    }
}

/// Subscriber to the states of takes.
pub struct TakeListener {
    takes: SubscriberPort<TakeRecord>,
}

impl TakeListener {
    /// Subscribes to `enact/take`.
    pub fn open(node: &Node) -> Result<Self, LiveError> {
        Ok(Self {
            takes: port(node, TAKE_SERVICE, Quality::NOTES, &mut Vec::new())?,
        })
    }

    /// The next record, if there is one.
    pub fn next(&self) -> Result<Option<TakeRecord>, LiveError> {
        self.takes.next()
    }
}

/// Subscriber to what a daemon says in words.
pub struct AnswerListener {
    answers: SubscriberPort<AnswerRecord>,
    parts: AnswerParts,
}

impl AnswerListener {
    /// Subscribes to `enact/answer`.
    pub fn open(node: &Node) -> Result<Self, LiveError> {
        Ok(Self {
            answers: port(node, ANSWER_SERVICE, Quality::TEXTS, &mut Vec::new())?,
            parts: AnswerParts::default(),
        })
    }

    /// The next whole answer, if there is one. One of which a part was lost, or that is not UTF-8,
    /// is left out.
    pub fn receive(&mut self) -> Result<Option<Answered>, LiveError> {
        while let Some(record) = self.answers.next()? {
            if let Some(answered) = self.parts.take(&record) {
                return Ok(Some(answered));
            }
        }
        Ok(None)
    }
}

fn port<T: core::fmt::Debug + ZeroCopySend + 'static>(
    node: &Node,
    name: &str,
    wanted: Quality,
    shortcomings: &mut Vec<String>,
) -> Result<SubscriberPort<T>, LiveError> {
    let served = node.service::<T>(name, wanted)?;
    let of_service = served.shortcomings.iter();
    shortcomings.extend(of_service.map(|what| format!("service {name}, made by another: {what}")));
    let buffer = served.buffer();
    let subscriber = served
        .factory
        .subscriber_builder()
        .buffer_size(buffer)
        .create()
        .map_err(|reason| LiveError::Port {
            service: name.to_owned(),
            reason: format!("{reason:?}"),
        })?;
    Ok(SubscriberPort {
        name: name.to_owned(),
        subscriber,
        buffer,
    })
}

impl<T: core::fmt::Debug + Copy + ZeroCopySend + 'static> SubscriberPort<T> {
    fn take(&self, into: &mut Vec<Arrival>, what: impl Fn(T) -> Arrived) -> Result<(), LiveError> {
        for _ in 0..AT_ONCE {
            let Some(record) = self.next()? else {
                break;
            };
            into.push(Arrival {
                at: Instant::now(),
                what: what(record),
            });
        }
        Ok(())
    }

    fn next(&self) -> Result<Option<T>, LiveError> {
        let sample = self
            .subscriber
            .receive()
            .map_err(|reason| LiveError::Receive {
                service: self.name.clone(),
                reason: format!("{reason:?}"),
            })?;
        Ok(sample.map(|sample| *sample))
    }
}
