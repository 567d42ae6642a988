//! The thread that publishes on iceoryx2, forwards events to the account, and removes resources of
//! killed peers.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};

use tokio::sync::mpsc::error::TrySendError;

use super::event::CaptureEvent;
use super::metrics::Metrics;
use super::notice::Notice;
use super::take::now_ns;
use crate::ingest::live::{LiveError, Node};
use crate::motion::Scene;
use crate::write::{EstimatePublisher, TakePublisher};

/// Interval of searching for killed peers: until then their publishers occupy places.
const BURY: Duration = Duration::from_secs(1);

/// The inputs of the thread.
pub(super) struct Publisher {
    pub(super) scene: Scene,
    pub(super) iceoryx2: Option<PathBuf>,
    pub(super) said: tokio::sync::mpsc::Sender<CaptureEvent>,
    pub(super) metrics: Arc<Metrics>,
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
        let (node, takes, mut estimates) = match open() {
            Ok(all) => {
                let _ = self.opened.send(Ok(()));
                all
            }
            Err(error) => {
                let _ = self.opened.send(Err(error));
                return;
            }
        };
        let (mut sequence, mut buried) = (0, Instant::now());
        loop {
            match queue.recv_timeout(BURY) {
                Ok(notice) => {
                    self.metrics.notices_waiting.take();
                    self.tell(notice, &takes, &mut estimates, &mut sequence);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            if buried.elapsed() >= BURY {
                let (cleared, failed) = node.bury();
                if cleared + failed > 0 {
                    tracing::info!(cleared, failed, "peers were killed");
                }
                buried = Instant::now();
            }
        }
    }

    fn tell(
        &self,
        notice: Notice,
        takes: &TakePublisher,
        estimates: &mut EstimatePublisher,
        sequence: &mut u64,
    ) {
        if !notice.is_repeated {
            self.metrics.said(&notice.said);
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
        if notice.is_repeated {
            return;
        }
        if let Err(TrySendError::Full(said)) = self.said.try_send(notice.said) {
            tracing::error!(lost = ?said, "the account is not read");
        }
    }
}
