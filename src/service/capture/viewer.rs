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
//! While a tracker is silent that was not, viewers show a warning.
//!
//! Viewers can only read, and cannot touch recording: their number is bounded ([`gate`](super::gate)),
//! and so is the memory of all together ([`hub`]). A page in a browser must be one that may watch
//! ([`Origins`]). The protocol is in [`websocket`].

#[cfg(any(test, fuzzing))]
pub(super) mod audience;
mod hub;
mod websocket;

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::net::{TcpListener, TcpSocket};
use tokio::sync::mpsc::error::TrySendError;
use tokio::sync::{Semaphore, mpsc, watch};
use typed_index_collections::TiVec;

use super::event::Status;
use super::gate::{Gate, GatePlaces};
use super::metrics::Metrics;
use super::notice::Shown;
use super::origin::Origins;
use super::presence::Presence;
use super::take::now_ns;
use crate::ingest::live::{PoseRecord, StreamTopic};
use crate::motion::{LinkIndex, Mark, PoseSample, Scene, Stamp, Verdict};
use crate::pipeline::Outcome;
use crate::report::Reported;
use crate::service::finish::reported;
use crate::write::show::{self, Showing, ShownTopic};
use crate::write::topics;
use hub::{ChannelNumber, Hub};
use websocket::Server;

/// Greatest number of live samples in the queue.
const FEED: usize = 256;

/// The system's buffer for what is sent to a viewer, which it doubles.
const SEND_BYTES: u32 = 128 << 10;

/// Connections that wait to be accepted.
const BACKLOG: u32 = 1024;

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
    status: watch::Receiver<Status>,
    hub: Arc<Hub>,
    channels: ViewerChannels,
    /// The estimate that is played, and its start.
    showing: Option<Showing>,
    begun: Instant,
}

struct ViewerChannels {
    trackers: Vec<ChannelNumber>,
    marks: ChannelNumber,
    /// Channels of the estimate and of the sketch, link by link.
    links: TiVec<LinkIndex, [ChannelNumber; 2]>,
    transforms: ChannelNumber,
    scene: ChannelNumber,
    report: ChannelNumber,
    time_map: ChannelNumber,
}

/// Serves viewers on an address, in tasks of its own; returns the recorder's end of the queue and
/// the bound address.
pub(super) async fn serve(
    address: SocketAddr,
    (scene, streams): (&Scene, &[StreamTopic]),
    (places, origins): (GatePlaces, Origins),
    (estimates, status): (watch::Receiver<Shown>, watch::Receiver<Status>),
    metrics: Arc<Metrics>,
) -> std::io::Result<(Feed, SocketAddr)> {
    let listener = listen(address)?;
    let address = listener.local_addr()?;
    let mut hub = Hub::new(format!("enact: {}", scene.name), &metrics);
    let channels = ViewerChannels::new(&mut hub, scene, streams);
    let hub = Arc::new(hub);
    let (sender, feed) = mpsc::channel(FEED);
    let viewer = Viewer {
        channels,
        scene: scene.clone(),
        streams: streams.to_vec(),
        feed,
        estimates,
        status,
        hub: Arc::clone(&hub),
        showing: None,
        begun: Instant::now(),
    };
    let gate = Gate::new("viewers", places.waiting, &metrics);
    let server = Arc::new(Server {
        hub,
        gate: Arc::clone(&gate),
        places: Arc::new(Semaphore::new(places.viewers)),
        origins,
    });
    tokio::spawn(gate.keep(listener, move |stream, waiting| {
        Arc::clone(&server).serve(stream, waiting)
    }));
    tokio::spawn(viewer.run());
    let feed = Feed {
        sender,
        shown: Vec::new(),
        metrics,
    };
    Ok((feed, address))
}

/// Listens with small buffers: what a viewer does not read must not fill the system's memory.
fn listen(address: SocketAddr) -> std::io::Result<TcpListener> {
    let socket = match address {
        SocketAddr::V4(_) => TcpSocket::new_v4()?,
        SocketAddr::V6(_) => TcpSocket::new_v6()?,
    };
    socket.set_reuseaddr(true)?;
    socket.set_send_buffer_size(SEND_BYTES)?;
    socket.bind(address)?;
    socket.listen(BACKLOG)
}

impl ViewerChannels {
    fn new(hub: &mut Hub, scene: &Scene, streams: &[StreamTopic]) -> Self {
        let mut poses = |topic: &str| hub.open(ShownTopic::poses(topic));
        let trackers = streams.iter().map(|stream| poses(&stream.topic)).collect();
        let links = scene.links.iter().map(|link| {
            let estimate = poses(&topics::estimate_pose(&link.name));
            [estimate, poses(&topics::sketch_pose(&link.name))]
        });
        Self {
            trackers,
            links: links.collect(),
            marks: hub.open(ShownTopic::marks(&scene.marks_topic)),
            transforms: hub.open(ShownTopic::transforms()),
            scene: hub.open(ShownTopic::scene()),
            report: hub.open(ShownTopic::report()),
            time_map: hub.open(ShownTopic::time_map()),
        }
    }

    /// Whether a viewer has subscribed to a topic of the estimate.
    fn are_watched(&self, hub: &Hub) -> bool {
        let alone = [&self.transforms, &self.report, &self.time_map];
        let all = alone.into_iter().chain(self.links.iter().flatten());
        all.into_iter().any(|channel| hub.has_subscribers(*channel))
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
                self.log(self.channels.trackers[stream], show::pose(&sample));
                if let Some(sample) = show::given_pose(&self.scene, track, &sample) {
                    let frames = [(
                        topics::live_frame(&self.scene.link_seen_by(track).name),
                        sample,
                    )];
                    self.log(self.channels.transforms, show::transforms(&frames));
                }
            }
            Live::Mark(mark) => self.log(self.channels.marks, show::mark(&mark)),
        }
    }

    fn log(&self, channel: ChannelNumber, message: Option<Vec<u8>>) {
        // Stamps before 1970 or after 2106 cannot be encoded.
        if let Some(message) = message {
            self.hub.log(channel, message);
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
                self.hub.log(self.channels.report, showing.report.clone());
                self.hub
                    .log(self.channels.time_map, showing.time_map.clone());
                self.showing = Some(showing);
            }
            Err(error) => tracing::debug!(%error, "not shown"),
        }
    }

    /// Sends the current frame of the motion, if a client watches.
    fn frame(&mut self) {
        if !self.channels.are_watched(&self.hub) {
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
                self.log(*channel, show::pose(&sample));
                frames.push((name, sample));
            }
        }
        self.log(self.channels.transforms, show::transforms(&frames));
    }

    fn again(&self) {
        for tracker in &self.status.borrow().trackers {
            let is_silent = tracker.state == Presence::Silent;
            let warning = is_silent.then(|| format!("{}: its tracker fell silent", tracker.topic));
            self.hub.warn(&tracker.topic, warning.as_deref());
        }
        if self.hub.has_subscribers(self.channels.scene) {
            let scene = show::scene(&self.scene, Stamp(now_ns()));
            self.log(self.channels.scene, scene);
        }
        if let Some(showing) = &self.showing {
            self.hub.log(self.channels.report, showing.report.clone());
            self.hub
                .log(self.channels.time_map, showing.time_map.clone());
        }
    }
}
