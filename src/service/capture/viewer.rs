//! Serves Foxglove and Lichtblick by WebSocket while a performer acts.
//!
//! | topic | what |
//! |---|---|
//! | `/tracker/<body>/pose` | poses of the tracker, at 60 Hz at most, take or no take |
//! | `/marks` | marks as they come |
//! | `/estimate/<body>/pose`, `/sketch/<body>/pose` | the last estimate and the performance at its physical times, repeated in real time |
//! | `/tf` | frames `<body>_live`, `<body>_estimate`, `<body>_sketch` |
//! | `/scene` | bodies, ghosts, the static world; again every second, for late viewers |
//! | `/estimate/report`, `/estimate/time_map` | the last estimate in numbers; again every second |
//!
//! The protocol is that of the `foxglove` crate, which serves `foxglove.sdk.v1` and `v1.1`, refuses
//! clients that ask for neither, and keeps a queue of 1024 messages for every client, of which the
//! oldest are dropped first. Clients can only read: no capability is offered.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use foxglove::{Context, RawChannel, Schema};
use tokio::sync::mpsc::error::TrySendError;
use tokio::sync::{mpsc, watch};
use typed_index_collections::TiVec;

use super::metrics::Metrics;
use super::notice::Shown;
use super::take::now_ns;
use crate::ingest::live::{PoseRecord, StreamTopic};
use crate::motion::{LinkIndex, Mark, PoseSample, Scene, Stamp, Verdict};
use crate::pipeline::Outcome;
use crate::report::Reported;
use crate::service::finish::reported;
use crate::write::show::{self, Showing, ShownTopic};
use crate::write::topics;

/// Greatest number of live samples in the queue.
const FEED: usize = 256;

/// Interval of frames of the motion, and least interval of a tracker's poses.
const FRAME: Duration = Duration::from_micros(16_667);

/// Interval at which static contents are sent again.
const AGAIN: Duration = Duration::from_secs(1);

/// Pause at the end of the motion before it begins again \[s\].
const PAUSE_S: f64 = 0.5;

/// A live sample for viewers.
pub(super) enum Live {
    /// The index of a stream and its reading.
    Pose(usize, PoseSample),
    /// A mark.
    Mark(Mark),
}

/// The recorder's end of the queue; it never waits.
pub(super) struct Feed {
    sender: mpsc::Sender<Live>,
    shown: Vec<Option<Instant>>,
    metrics: Arc<Metrics>,
}

impl Feed {
    /// Shows a valid reading, unless the stream's last one was shown less than a frame before.
    pub(super) fn pose(&mut self, at: Instant, stream: usize, record: &PoseRecord) {
        if self.shown.len() <= stream {
            self.shown.resize(stream + 1, None);
        }
        let last = self.shown[stream];
        if !record.is_valid() || last.is_some_and(|last| at < last + FRAME) {
            return;
        }
        self.shown[stream] = Some(at);
        let sample = PoseSample::new(
            Stamp(now_ns()),
            record.position_m.into(),
            record.quaternion_xyzw,
        );
        self.send(Live::Pose(stream, sample));
    }

    /// Shows a mark at the time of its arrival.
    pub(super) fn mark(&self, mark: Mark) {
        self.send(Live::Mark(mark));
    }

    fn send(&self, live: Live) {
        if let Err(TrySendError::Full(_)) = self.sender.try_send(live) {
            self.metrics.not_shown.add();
        }
    }
}

/// The state of the server and its sources.
pub(super) struct Viewer {
    scene: Scene,
    streams: Vec<StreamTopic>,
    feed: mpsc::Receiver<Live>,
    estimates: watch::Receiver<Shown>,
    channels: ViewerChannels,
    /// The estimate that is played, and its start.
    showing: Option<Showing>,
    begun: Instant,
}

struct ViewerChannels {
    trackers: Vec<Arc<RawChannel>>,
    marks: Arc<RawChannel>,
    /// ViewerChannels of the estimate and of the sketch, link by link.
    links: TiVec<LinkIndex, [Arc<RawChannel>; 2]>,
    transforms: Arc<RawChannel>,
    scene: Arc<RawChannel>,
    report: Arc<RawChannel>,
    time_map: Arc<RawChannel>,
}

/// Serves viewers on an address, in a task of its own; returns the recorder's end of the queue and
/// the bound address.
pub(super) async fn serve(
    address: SocketAddr,
    (scene, streams): (&Scene, &[StreamTopic]),
    estimates: watch::Receiver<Shown>,
    metrics: Arc<Metrics>,
) -> anyhow::Result<(Feed, SocketAddr)> {
    let context = Context::new();
    let server = context
        .websocket_server()
        .name(format!("enact: {}", scene.name))
        .bind(address.ip().to_string(), address.port());
    let (sender, feed) = mpsc::channel(FEED);
    let viewer = Viewer {
        channels: ViewerChannels::new(&context, scene, streams)?,
        scene: scene.clone(),
        streams: streams.to_vec(),
        feed,
        estimates,
        showing: None,
        begun: Instant::now(),
    };
    let handle = server.start().await?;
    let address = SocketAddr::new(address.ip(), handle.port());
    tokio::spawn(async move {
        // The server holds its channels weakly; this keeps them alive.
        let _context = context;
        viewer.run().await
    });
    let feed = Feed {
        sender,
        shown: Vec::new(),
        metrics,
    };
    Ok((feed, address))
}

impl ViewerChannels {
    fn new(context: &Arc<Context>, scene: &Scene, streams: &[StreamTopic]) -> anyhow::Result<Self> {
        let open = |topic: ShownTopic| {
            let schema = topic.schema;
            let channel = context
                .channel_builder(topic.topic)
                .message_encoding(topic.encoding)
                .schema(Schema::new(schema.name, schema.encoding, schema.data));
            channel.build_raw()
        };
        let poses = |topic: &str| open(ShownTopic::poses(topic));
        let link = |name: &str| {
            let estimate = poses(&topics::estimate_pose(name))?;
            Ok([estimate, poses(&topics::sketch_pose(name))?])
        };
        let trackers = streams.iter().map(|stream| poses(&stream.topic));
        let links = scene.links.iter().map(|of| link(&of.name));
        Ok(Self {
            trackers: trackers.collect::<Result<_, _>>()?,
            marks: open(ShownTopic::marks(&scene.marks_topic))?,
            links: links.collect::<Result<_, foxglove::FoxgloveError>>()?,
            transforms: open(ShownTopic::transforms())?,
            scene: open(ShownTopic::scene())?,
            report: open(ShownTopic::report())?,
            time_map: open(ShownTopic::time_map())?,
        })
    }

    /// Whether a client has subscribed to a topic of the estimate.
    fn are_watched(&self) -> bool {
        let alone = [&self.transforms, &self.report, &self.time_map];
        let all = alone.into_iter().chain(self.links.iter().flatten());
        all.into_iter().any(|channel| channel.has_sinks())
    }
}

fn log(channel: &RawChannel, message: Option<Vec<u8>>) {
    // Stamps before 1970 or after 2106 cannot be encoded.
    if let Some(message) = message {
        channel.log(&message);
    }
}

impl Viewer {
    /// Shows arrivals and the motion until the runtime ends.
    async fn run(mut self) -> std::convert::Infallible {
        let mut frames = tokio::time::interval(FRAME);
        frames.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Skip);
        let mut again = tokio::time::interval(AGAIN);
        loop {
            tokio::select! {
                // Closed once the recorder has ended; estimates may still come.
                Some(live) = self.feed.recv() => self.live(live),
                _ = frames.tick() => self.frame(),
                _ = again.tick() => self.again(),
            }
        }
    }

    fn live(&self, live: Live) {
        match live {
            Live::Pose(stream, sample) => {
                let track = self.streams[stream].track;
                log(&self.channels.trackers[stream], show::pose(&sample));
                if let Some(sample) = show::given_pose(&self.scene, track, &sample) {
                    let frames = [(
                        topics::live_frame(&self.scene.link_seen_by(track).name),
                        sample,
                    )];
                    log(&self.channels.transforms, show::transforms(&frames));
                }
            }
            Live::Mark(mark) => log(&self.channels.marks, show::mark(&mark)),
        }
    }

    /// Switches to a new estimate, if there is one, at the same phase of playing. A failed estimate
    /// has no motion.
    fn estimate(&mut self) {
        if !self.estimates.has_changed().unwrap_or(false) {
            return;
        }
        let outcome = self.estimates.borrow_and_update().clone();
        let is_motion = |of: &Arc<Outcome>| of.estimate.verdict != Verdict::Failed;
        let Some(outcome) = outcome.filter(is_motion) else {
            return;
        };
        let showing = Showing::new(&Reported {
            settled: None,
            rest: None,
            ..reported(&outcome)
        });
        match showing {
            Ok(showing) => {
                self.channels.report.log(&showing.report);
                self.channels.time_map.log(&showing.time_map);
                self.showing = Some(showing);
            }
            Err(error) => tracing::debug!(%error, "not shown"),
        }
    }

    /// Sends the current frame of the motion, if a client watches.
    fn frame(&mut self) {
        if !self.channels.are_watched() {
            return;
        }
        self.estimate();
        let Some(showing) = &self.showing else {
            return;
        };
        let period_s = showing.duration_s() + PAUSE_S;
        let time_s = self.begun.elapsed().as_secs_f64() % period_s;
        let now = Stamp(now_ns());
        let mut frames = Vec::new();
        for (index, link) in self.scene.links.iter_enumerated() {
            let names = [
                topics::estimate_frame(&link.name),
                topics::sketch_frame(&link.name),
            ];
            let poses = showing.at(index, time_s, now).into_iter();
            for ((name, sample), channel) in names
                .into_iter()
                .zip(poses)
                .zip(&self.channels.links[index])
            {
                let Some(sample) = sample else { continue };
                log(channel, show::pose(&sample));
                frames.push((name, sample));
            }
        }
        log(&self.channels.transforms, show::transforms(&frames));
    }

    fn again(&self) {
        if self.channels.scene.has_sinks() {
            log(
                &self.channels.scene,
                show::scene(&self.scene, Stamp(now_ns())),
            );
        }
        if let Some(showing) = &self.showing {
            self.channels.report.log(&showing.report);
            self.channels.time_map.log(&showing.time_map);
        }
    }
}
