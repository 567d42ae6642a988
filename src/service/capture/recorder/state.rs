//! What the recording thread is given, and what it knows.

use std::collections::VecDeque;
use std::fs::File;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender};
use std::time::{Duration, Instant};

use tokio::sync::watch;

use super::super::estimator::FinishedTake;
use super::super::event::{CaptureEvent, CountsLine, Status};
use super::super::latency::Latencies;
use super::super::metrics::Metrics;
use super::super::naming::last_number;
use super::super::notice::Speaker;
use super::super::preroll::Preroll;
use super::super::presence::Pulse;
use super::super::previewer::PreviewInput;
use super::super::seldom::Seldom;
use super::super::take::OpenTake;
use super::super::viewer::Feed;
use crate::config::CaptureSettings;
use crate::ingest::live::{Arrival, ControlRecord, StreamTopic, Token};
use crate::motion::Scene;

/// The inputs of the thread.
pub(in super::super) struct Recorder {
    pub(in super::super) scene: Scene,
    pub(in super::super) scene_toml: Vec<u8>,
    pub(in super::super) settings: CaptureSettings,
    pub(in super::super) topics: Vec<StreamTopic>,
    pub(in super::super) publisher: Speaker,
    pub(in super::super) so_far: SyncSender<PreviewInput>,
    pub(in super::super) finals: SyncSender<FinishedTake>,
    pub(in super::super) syncer: SyncSender<File>,
    pub(in super::super) status: watch::Sender<Status>,
    pub(in super::super) metrics: Arc<Metrics>,
    /// Queue to the viewers, if they are served.
    pub(in super::super) feed: Option<Feed>,
    /// What who directs must know.
    pub(in super::super) token: Token,
    /// Address of the operator's page, if it is served.
    pub(in super::super) page: Option<String>,
    /// What the operator's page directs.
    pub(in super::super) orders: Receiver<Arrival>,
    /// What the acting page sends and directs.
    pub(in super::super) acted: Receiver<Arrival>,
}

/// The state of the thread.
pub(super) struct RecorderState {
    pub(super) take: Option<OpenTake>,
    pub(super) takes: u64,
    pub(super) outside: u64,
    /// Number of events of the running take that the previewer was given; `None` without previews.
    pub(super) followed: Option<usize>,
    /// Whether the previewer must be told that the take is over.
    pub(super) is_over: bool,
    /// The last commands that were executed, with their answers.
    pub(super) answered: VecDeque<(ControlRecord, CaptureEvent)>,
    /// Sums over the takes that are over.
    pub(super) totals: (CountsLine, Latencies),
    /// The trackers, stream by stream.
    pub(super) pulses: Vec<Pulse>,
    /// What came in the last seconds, while no take runs.
    pub(super) preroll: Preroll,
    /// How long ago what is journalled now had arrived.
    pub(super) behind: Duration,
    pub(super) said: Instant,
    pub(super) listened: Instant,
    pub(super) slow_disk: Seldom,
}

impl RecorderState {
    /// No take yet.
    pub(super) fn new(of: &Recorder) -> Self {
        let now = Instant::now();
        let pulses = of.topics.iter().map(|topic| Pulse::new(&topic.topic, now));
        Self {
            take: None,
            takes: last_number(&of.settings.folder),
            pulses: pulses.collect(),
            preroll: Preroll::new(of.settings.pre_roll),
            behind: Duration::ZERO,
            listened: now,
            slow_disk: Seldom::default(),
            outside: 0,
            followed: None,
            is_over: false,
            answered: VecDeque::new(),
            totals: Default::default(),
            said: now,
        }
    }

    /// Ends the previews of the take.
    pub(super) fn unfollow(&mut self) {
        self.is_over |= self.followed.take().is_some();
    }

    /// Adds the counts of a take that is over to the totals.
    pub(super) fn end_of(&mut self, take: &OpenTake) {
        self.unfollow();
        self.totals.0.add(&take.counts());
        self.totals.1.merge(&take.latencies);
    }

    /// The moment of which everything that came is known: trackers that are heard with a delay are
    /// not silent.
    pub(super) fn known_until(&self, now: Instant) -> Instant {
        now.checked_sub(self.behind).unwrap_or(now)
    }

    /// How everything stands, for whoever looks.
    pub(super) fn status(&mut self, now: Instant) -> Status {
        let known = self.known_until(now);
        let trackers = self.pulses.iter_mut().map(|pulse| pulse.state(known));
        let trackers = trackers.collect();
        let take = self.take.as_ref();
        let (mut totals, mut latency) = self.totals.clone();
        if let Some(take) = take {
            totals.add(&take.counts());
            latency.merge(&take.latencies);
        }
        Status {
            take: take.map(|take| take.number),
            recording: take.map(|take| take.journal.path().display().to_string()),
            messages: take.map_or(0, |take| take.journal.messages()),
            counts: take.map(OpenTake::counts).unwrap_or_default(),
            trackers,
            outside: self.outside,
            totals,
            latency,
        }
    }
}
