//! What the other threads give the publisher, and the queue to it.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};

use super::event::CaptureEvent;
use super::metrics::Metrics;
use crate::ingest::live::ControlRecord;
use crate::pipeline::Outcome;
use crate::write::live::EstimateOccasion;

/// Notices that may wait.
const NOTICES: usize = 256;

/// The last estimate, for those who show it.
pub(super) type Shown = Option<Arc<Outcome>>;

/// Something to say, and to publish.
pub(super) struct Notice {
    pub(super) said: CaptureEvent,
    /// Publisher and number of the command that brought it about, to answer it by.
    pub(super) asked: Option<(u32, u64)>,
    /// An estimate to publish with it.
    pub(super) outcome: Option<(EstimateOccasion, Box<Outcome>)>,
    /// Whether it was said before, and whoever asked has not heard it.
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

/// The speakers' end of the queue.
#[derive(Clone)]
pub(super) struct Speaker {
    queue: SyncSender<Notice>,
    metrics: Arc<Metrics>,
}

/// A queue to the publisher.
pub(super) fn queue(metrics: &Arc<Metrics>) -> (Speaker, Receiver<Notice>) {
    let (queue, notices) = sync_channel(NOTICES);
    let metrics = Arc::clone(metrics);
    (Speaker { queue, metrics }, notices)
}

impl Speaker {
    /// Says it; waits where the queue is full. A publisher that is gone has nobody left to tell.
    pub(super) fn say(&self, notice: Notice) {
        if self.queue.send(notice).is_ok() {
            self.metrics.notices_waiting.put();
        }
    }

    /// The same for whoever must not wait: what has no room is dropped and logged.
    pub(super) fn say_at_once(&self, notice: Notice) {
        match self.queue.try_send(notice) {
            Ok(()) => self.metrics.notices_waiting.put(),
            Err(TrySendError::Full(notice) | TrySendError::Disconnected(notice)) => {
                tracing::error!(lost = ?notice.said, "nobody listens to what is said");
            }
        }
    }
}
