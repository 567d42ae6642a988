//! The thread that publishes on iceoryx2, forwards events to the account, and removes resources of
//! killed peers.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, TrySendError};
use std::time::{Duration, Instant};

use super::event::CaptureEvent;
use super::health::HealthPart;
use super::metrics::Metrics;
use super::notice::Notice;
use super::seldom::Seldom;
use super::take::now_ns;
use crate::ingest::live::{
    CONTROL_SERVICE, LiveError, Node, TAKE_SERVICE, service_name, stream_topics,
};
use crate::motion::Scene;
use crate::write::{EstimatePublisher, TakePublisher};

/// Interval of searching for killed peers: until then their publishers occupy places.
const BURY: Duration = Duration::from_secs(1);

/// The inputs of the thread.
pub(super) struct Publisher {
    pub(super) scene: Scene,
    pub(super) iceoryx2: Option<PathBuf>,
    pub(super) said: SyncSender<CaptureEvent>,
    pub(super) metrics: Arc<Metrics>,
    pub(super) complaint: Seldom,
    /// Receives once whether the services are open.
    pub(super) opened: Sender<Result<(), LiveError>>,
}

impl Publisher {
    /// Opens the services and publishes notices until the queue is closed.
    pub(super) fn run(self, queue: &Receiver<Notice>) {
        let open = || {
            let node = Node::join("enact capture, out", self.iceoryx2.as_deref())?;
            let takes = TakePublisher::open(&node)?;
            let estimates = EstimatePublisher::open(&node, &self.scene)?;
            Ok((node, takes, estimates))
        };
        let (node, mut takes, mut estimates) = match open() {
            Ok(all) => {
                let _ = self.opened.send(Ok(()));
                all
            }
            Err(error) => {
                let _ = self.opened.send(Err(error));
                return;
            }
        };
        let services = self.services();
        let (mut sequence, mut buried) = (0, Instant::now());
        loop {
            match queue.recv_timeout(BURY) {
                Ok(notice) => {
                    self.metrics.notices_waiting.take();
                    self.tell(notice, &mut takes, &mut estimates, &mut sequence);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            if buried.elapsed() >= BURY {
                let (cleared, failed) = node.bury();
                if cleared + failed > 0 {
                    tracing::info!(cleared, failed, "peers were killed");
                }
                let gone = node.gone(services.iter().map(String::as_str));
                let trouble = gone.first().map(|first| {
                    let more = gone.len() - 1;
                    format!(
                        "service {first:?} and {more} more are gone, so that trackers do not find \
                         them: restart the daemon"
                    )
                });
                self.metrics.health.say(HealthPart::Services, trouble);
                buried = Instant::now();
            }
        }
    }

    /// The services that trackers and directors must find.
    fn services(&self) -> Vec<String> {
        let topics = stream_topics(&self.scene).into_iter();
        let mut services: Vec<String> = topics.map(|of| service_name(&of.topic)).collect();
        services.push(service_name(&self.scene.marks_topic));
        services.extend([CONTROL_SERVICE, TAKE_SERVICE].map(str::to_owned));
        services
    }

    fn tell(
        &self,
        notice: Notice,
        takes: &mut TakePublisher,
        estimates: &mut EstimatePublisher,
        sequence: &mut u64,
    ) {
        if !notice.is_repeated {
            self.metrics.said(&notice.said);
            self.metrics.history.said(&notice.said);
        }
        if let Some((occasion, outcome)) = &notice.outcome {
            let (sketch, estimate) = (&outcome.sketch, &outcome.estimate);
            if let Err(error) = estimates.send(*occasion, &outcome.scene, sketch, estimate) {
                tracing::warn!(%error, "an estimate was not published");
            }
        }
        if let Some(record) = notice.said.record(notice.asked, *sequence, now_ns()) {
            *sequence += 1;
            if let Err(error) = takes.send(record) {
                tracing::warn!(%error, "the state of a take was not published");
            }
        }
        let answer = notice.said.answer();
        let answered = answer.map(|json| takes.answer(now_ns(), notice.asked, &json));
        if let Some(Err(error)) = answered
            && let Some(more) = self.complaint.due(Instant::now())
        {
            tracing::warn!(%error, more, "an answer was not published");
        }
        if notice.is_repeated {
            return;
        }
        if let Err(TrySendError::Full(said)) = self.said.try_send(notice.said)
            && let Some(more) = self.complaint.due(Instant::now())
        {
            tracing::error!(lost = ?said, more, "the account is not read");
        }
    }
}
