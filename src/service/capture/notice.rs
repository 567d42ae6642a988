//! The queue to the publisher thread, and its entries.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::time::Instant;

use super::event::CaptureEvent;
use super::metrics::Metrics;
use super::seldom::Seldom;
use crate::ingest::live::ControlRecord;
use crate::pipeline::Outcome;
use crate::write::live::EstimateOccasion;

/// Greatest number of notices in the queue.
const NOTICES: usize = 256;

/// The last estimate, for viewers.
pub(super) type Shown = Option<Arc<Outcome>>;

/// An event to report and to publish.
pub(super) struct Notice {
    pub(super) said: CaptureEvent,
    /// Session and sequence number of the command that it answers.
    pub(super) asked: Option<(u32, u64)>,
    /// An estimate to publish with it.
    pub(super) outcome: Option<(EstimateOccasion, Box<Outcome>)>,
    /// Whether it repeats an earlier answer that the client did not receive.
    pub(super) is_repeated: bool,
}

impl Notice {
    pub(super) fn of(said: CaptureEvent) -> Self {
        Self {
            said,
            asked: None,
            outcome: None,
            is_repeated: false,
        }
    }

    pub(super) fn asked(said: CaptureEvent, asked: Option<&ControlRecord>) -> Self {
        Self {
            asked: asked.map(|command| (command.session, command.sequence)),
            ..Self::of(said)
        }
    }

    pub(super) fn estimated(
        said: CaptureEvent,
        occasion: EstimateOccasion,
        outcome: Outcome,
    ) -> Self {
        Self {
            outcome: Some((occasion, Box::new(outcome))),
            ..Self::of(said)
        }
    }
}

/// The sending end of the queue.
#[derive(Clone)]
pub(super) struct Speaker {
    queue: SyncSender<Notice>,
    metrics: Arc<Metrics>,
    complaint: Arc<Seldom>,
}

/// A queue to the publisher.
pub(super) fn queue(metrics: &Arc<Metrics>) -> (Speaker, Receiver<Notice>) {
    let (queue, notices) = sync_channel(NOTICES);
    let metrics = Arc::clone(metrics);
    let complaint = Arc::default();
    let speaker = Speaker {
        queue,
        metrics,
        complaint,
    };
    (speaker, notices)
}

impl Speaker {
    /// Sends a notice; waits while the queue is full. Does nothing once the publisher has ended.
    pub(super) fn say(&self, notice: Notice) {
        if self.queue.send(notice).is_ok() {
            self.metrics.notices_waiting.put();
        }
    }

    /// Sends a notice without waiting: where the queue is full it is dropped and logged.
    pub(super) fn say_at_once(&self, notice: Notice) {
        match self.queue.try_send(notice) {
            Ok(()) => self.metrics.notices_waiting.put(),
            Err(TrySendError::Full(notice) | TrySendError::Disconnected(notice)) => {
                if let Some(more) = self.complaint.due(Instant::now()) {
                    let lost = &notice.said;
                    tracing::error!(?lost, more, "nobody listens to what is said");
                }
            }
        }
    }
}
