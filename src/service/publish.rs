//! Publishes a recording over iceoryx2, as its trackers and a daemon would have.

use std::path::Path;
use std::thread;
use std::time::Duration;

use crate::ingest::live::{
    MarkRecord, NO_TIME, Node, PoseRecord, StreamTopic, TakeRecord, TakeState, stream_topics,
};
use crate::motion::{Scene, Stamp, TakeEvent};
use crate::pipeline::Outcome;
use crate::write::live::EstimateOccasion;
use crate::write::{EstimatePublisher, TakePublisher, TrackerPublisher};

/// Wait at the end, so that polling subscribers read the last samples before the publishers end.
const LINGER: Duration = Duration::from_millis(50);

/// Bit 0 of the flags: valid.
const VALID: u32 = 1;

/// Publishers of the services of a scene.
pub(super) struct Publication {
    _node: Node,
    trackers: TrackerPublisher,
    takes: TakePublisher,
    estimates: EstimatePublisher,
    topics: Vec<StreamTopic>,
    sequences: Vec<u64>,
    marks: u64,
    said: u64,
    session: u32,
}

impl Publication {
    /// Opens the publishers and announces the take, with the number 0, which no daemon uses.
    pub(super) fn begin(scene: &Scene, iceoryx2: Option<&Path>) -> anyhow::Result<Self> {
        let node = Node::join("enact replay", iceoryx2)?;
        let topics = stream_topics(scene);
        let names: Vec<String> = topics.iter().map(|topic| topic.topic.clone()).collect();
        let mut publication = Self {
            trackers: TrackerPublisher::open(&node, &names, &scene.marks_topic)?,
            takes: TakePublisher::open(&node)?,
            estimates: EstimatePublisher::open(&node, scene)?,
            _node: node,
            sequences: vec![0; topics.len()],
            topics,
            marks: 0,
            said: 0,
            session: std::process::id(),
        };
        publication.say(TakeState::Recording)?;
        Ok(publication)
    }

    /// Sends an event of the recording.
    pub(super) fn event(&mut self, log_time: Stamp, event: &TakeEvent) -> anyhow::Result<()> {
        match event {
            TakeEvent::Pose {
                track,
                stream,
                sample,
            } => {
                let is_its = |topic: &StreamTopic| (topic.track, topic.stream) == (*track, *stream);
                let Some(at) = self.topics.iter().position(is_its) else {
                    return Ok(());
                };
                let record = PoseRecord {
                    sequence: self.sequences[at],
                    available_ns: log_time.0,
                    sample_ns: sample.stamp.0,
                    device_ns: NO_TIME,
                    position_m: sample.position_m.into(),
                    quaternion_xyzw: sample.quaternion_xyzw,
                    flags: VALID,
                    session: self.session,
                };
                self.sequences[at] += 1;
                self.trackers.pose(at, record)?;
            }
            TakeEvent::Mark(mark) => {
                let record = MarkRecord {
                    sequence: self.marks,
                    available_ns: log_time.0,
                    sample_ns: mark.stamp.0,
                    device_ns: NO_TIME,
                    event: MarkRecord::event_bytes(mark.event.as_deref().unwrap_or_default()),
                    flags: 0,
                    session: self.session,
                };
                self.marks += 1;
                self.trackers.mark(record)?;
            }
        }
        Ok(())
    }

    /// Sends the estimate, and announces that the take is over.
    pub(super) fn end(mut self, outcome: &Outcome) -> anyhow::Result<()> {
        let occasion = EstimateOccasion {
            take: 0,
            marks: self.marks,
            is_final: true,
            now_ns: super::capture::now_ns(),
        };
        let (scene, sketch) = (&outcome.scene, &outcome.sketch);
        self.estimates
            .send(occasion, scene, sketch, &outcome.estimate)?;
        self.say(TakeState::Estimated)?;
        thread::sleep(LINGER);
        Ok(())
    }

    fn say(&mut self, state: TakeState) -> anyhow::Result<()> {
        self.takes.send(TakeRecord {
            sequence: self.said,
            available_ns: super::capture::now_ns(),
            take: 0,
            messages: self.sequences.iter().sum::<u64>() + self.marks,
            state: state.number(),
            control_session: 0,
            control_sequence: 0,
        })?;
        self.said += 1;
        Ok(())
    }
}
