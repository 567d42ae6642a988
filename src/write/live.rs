//! Takes and estimates → iceoryx2. The services are those of [`crate::wire::live`].

use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::ZeroCopySend;

use super::error::WriteError;
use super::estimate::DEFAULT_FRAME_RATE_HZ;
use crate::motion::{Estimate, Scene, Sketch, Verdict};
use crate::sampling::{estimate_frames, zero};
use crate::wire::live::{
    ANSWER_SERVICE, AnswerRecord, CONTROL_SERVICE, Command, ControlRecord, ESTIMATE_SERVICE,
    EstimateRecord, EstimatedPoseRecord, LABEL_SERVICE, LabelRecord, LiveError, LiveService,
    MarkRecord, Node, PoseRecord, Quality, TAKE_SERVICE, TakeRecord, Token, service_name,
};

/// One publisher.
struct PublisherPort<T: core::fmt::Debug + ZeroCopySend + 'static> {
    name: String,
    publisher: Publisher<LiveService, T, ()>,
}

impl<T: core::fmt::Debug + Copy + ZeroCopySend + 'static> PublisherPort<T> {
    fn open(node: &Node, name: &str, quality: Quality) -> Result<Self, LiveError> {
        use iceoryx2::port::backpressure_strategy::BackpressureStrategy;
        let served = node.service::<T>(name, quality)?;
        for shortcoming in &served.shortcomings {
            tracing::warn!(service = name, "made by another: {shortcoming}");
        }
        let publisher = served
            .factory
            .publisher_builder()
            // Where a service was made without overflow: a slow subscriber shall hold up nobody.
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|reason| LiveError::Port {
                service: name.to_owned(),
                reason: format!("{reason:?}"),
            })?;
        Ok(Self {
            name: name.to_owned(),
            publisher,
        })
    }

    /// Sends; to how many.
    fn send(&self, record: T) -> Result<usize, LiveError> {
        self.publisher
            .send_copy(record)
            .map_err(|reason| LiveError::Send {
                service: self.name.clone(),
                reason: format!("{reason:?}"),
            })
    }
}

/// Publishes what trackers, performers and directors do: a recording as a live take.
pub struct TrackerPublisher {
    poses: Vec<PublisherPort<PoseRecord>>,
    marks: PublisherPort<MarkRecord>,
    control: PublisherPort<ControlRecord>,
}

impl TrackerPublisher {
    /// Opens the services of these topics, of the marks and of take control.
    pub fn open(node: &Node, topics: &[String], marks_topic: &str) -> Result<Self, LiveError> {
        let pose = |topic: &String| PublisherPort::open(node, &service_name(topic), Quality::POSES);
        Ok(Self {
            poses: topics.iter().map(pose).collect::<Result<_, _>>()?,
            marks: PublisherPort::open(node, &service_name(marks_topic), Quality::NOTES)?,
            control: PublisherPort::open(node, CONTROL_SERVICE, Quality::NOTES)?,
        })
    }

    /// Sends a sample on the topic of that number; to how many.
    pub fn pose(&self, topic: usize, record: PoseRecord) -> Result<usize, LiveError> {
        self.poses[topic].send(record)
    }

    /// Sends a mark; to how many.
    pub fn mark(&self, record: MarkRecord) -> Result<usize, LiveError> {
        self.marks.send(record)
    }

    /// Sends a command, as somebody who knows that token; to how many.
    pub fn control(
        &self,
        command: Command,
        session: u32,
        sequence: u64,
        now_ns: i64,
        token: Token,
    ) -> Result<usize, LiveError> {
        self.control.send(ControlRecord {
            sequence,
            available_ns: now_ns,
            command: command.number(),
            session,
            token: token.bytes(),
        })
    }
}

/// Publishes what directors say of takes.
pub struct LabelPublisher {
    port: PublisherPort<LabelRecord>,
}

impl LabelPublisher {
    /// Opens `enact/label`.
    pub fn open(node: &Node) -> Result<Self, LiveError> {
        Ok(Self {
            port: PublisherPort::open(node, LABEL_SERVICE, Quality::NOTES)?,
        })
    }

    /// Sends; to how many.
    pub fn send(&self, record: LabelRecord) -> Result<usize, LiveError> {
        self.port.send(record)
    }
}

/// Publishes what becomes of takes, and what the daemon says in words.
pub struct TakePublisher {
    port: PublisherPort<TakeRecord>,
    answers: PublisherPort<AnswerRecord>,
    answered: u64,
}

impl TakePublisher {
    /// Opens `enact/take` and `enact/answer`.
    pub fn open(node: &Node) -> Result<Self, LiveError> {
        Ok(Self {
            port: PublisherPort::open(node, TAKE_SERVICE, Quality::NOTES)?,
            answers: PublisherPort::open(node, ANSWER_SERVICE, Quality::TEXTS)?,
            answered: 0,
        })
    }

    /// Sends a JSON object, with the session and sequence number of the command that it answers.
    pub fn answer(
        &mut self,
        now_ns: i64,
        asked: Option<(u32, u64)>,
        json: &str,
    ) -> Result<(), LiveError> {
        self.answered += 1;
        for part in AnswerRecord::parts(self.answered, now_ns, asked, json) {
            self.answers.send(part)?;
        }
        Ok(())
    }

    /// Sends; to how many.
    pub fn send(&self, record: TakeRecord) -> Result<usize, LiveError> {
        self.port.send(record)
    }
}

/// What is said with an estimate besides what is in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EstimateOccasion {
    /// The take, counted from 1; 0 of a recording.
    pub take: u64,
    /// Marks that it rests on.
    pub marks: u64,
    /// Whether the take is over.
    pub is_final: bool,
    /// When it was ready \[ns since 1970\].
    pub now_ns: i64,
}

/// Publishes estimates of a scene.
pub struct EstimatePublisher {
    estimates: PublisherPort<EstimateRecord>,
    frames: Vec<PublisherPort<EstimatedPoseRecord>>,
    sequence: u64,
}

impl EstimatePublisher {
    /// Opens `enact/estimate` and `enact/estimate/<body>/pose` of every body.
    pub fn open(node: &Node, scene: &Scene) -> Result<Self, LiveError> {
        let frames = scene.links.iter().map(|body| {
            let name = service_name(&super::topics::estimate_pose(&body.name));
            PublisherPort::open(node, &name, Quality::FRAMES)
        });
        Ok(Self {
            frames: frames.collect::<Result<_, _>>()?,
            estimates: PublisherPort::open(node, ESTIMATE_SERVICE, Quality::NOTES)?,
            sequence: 0,
        })
    }

    /// Sends an estimate: its numbers, then the motion of every body at
    /// [`DEFAULT_FRAME_RATE_HZ`] and at its events. More frames than a service buffers are not
    /// sent: a motion that ran away.
    pub fn send(
        &mut self,
        occasion: EstimateOccasion,
        scene: &Scene,
        sketch: &Sketch,
        estimate: &Estimate,
    ) -> Result<(), WriteError> {
        let zero = zero(estimate, sketch);
        let mut bodies = Vec::new();
        for link in scene.links.keys() {
            let rate_hz = DEFAULT_FRAME_RATE_HZ;
            let samples = estimate_frames(scene, estimate, link, zero, rate_hz).unwrap_or_default();
            let fits = samples.len() <= Quality::FRAMES.buffer;
            bodies.push(if fits { samples } else { Vec::new() });
        }
        let (residual_m, residual_rad) = estimate.residual_rms();
        let record = EstimateRecord {
            sequence: self.sequence,
            available_ns: occasion.now_ns,
            take: occasion.take,
            marks: occasion.marks,
            origin_ns: zero.0,
            frames: bodies.iter().map(|samples| samples.len() as u64).sum(),
            objective: estimate.objective,
            physical_s: duration_s(estimate),
            residual_m,
            residual_rad,
            iterations: estimate.counters.iterations as u64,
            verdict: match estimate.verdict {
                Verdict::Failed => 0,
                Verdict::Plausible => 1,
                Verdict::Physical => 2,
            },
            is_final: u32::from(occasion.is_final),
        };
        self.sequence += 1;
        self.estimates.send(record)?;
        for (port, samples) in self.frames.iter().zip(&bodies) {
            for (index, sample) in samples.iter().enumerate() {
                port.send(EstimatedPoseRecord {
                    estimate: record.sequence,
                    take: occasion.take,
                    index: index as u64,
                    count: samples.len() as u64,
                    sample_ns: sample.stamp.0,
                    position_m: sample.position_m.into(),
                    quaternion_xyzw: sample.quaternion_xyzw,
                })?;
            }
        }
        Ok(())
    }
}

fn duration_s(estimate: &Estimate) -> f64 {
    estimate
        .extent_s()
        .map_or(0.0, |[start_s, end_s]| (end_s - start_s).max(0.0))
}
