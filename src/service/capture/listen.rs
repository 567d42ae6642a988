//! The thread that polls iceoryx2. It waits only for the recorder's queue.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, SyncSender};
use std::thread;
use std::time::{Duration, Instant};

use super::health::HealthPart;
use super::metrics::Metrics;
use super::seldom::Seldom;
use crate::ingest::live::{Arrival, Arrived, Listening};
use crate::ingest::live::{Command, DaemonLock, LiveError, Node, Token};
use crate::motion::Scene;

/// Polling intervals while samples come, and after none came for [`IDLE_AFTER`].
const POLL: Duration = Duration::from_millis(1);
const POLL_IDLE: Duration = Duration::from_millis(5);
const IDLE_AFTER: Duration = Duration::from_secs(1);

/// Greatest number of arrivals in a batch: the queue is bounded in batches, and must be in memory.
const BATCH: usize = 512;

/// Interval of saying that it polls.
const BEAT: Duration = Duration::from_millis(200);

/// The inputs of the thread.
pub(super) struct Listen {
    pub(super) scene: Scene,
    pub(super) iceoryx2: Option<PathBuf>,
    /// Queue to the recorder; while it is full arrivals wait in the subscribers' buffers.
    pub(super) queue: SyncSender<Vec<Arrival>>,
    pub(super) metrics: Arc<Metrics>,
    /// Set to end.
    pub(super) stop: Arc<AtomicBool>,
    /// The scene file, for those who find the daemon's lock taken.
    pub(super) scene_file: PathBuf,
    /// Receives once whether the services are open.
    pub(super) opened: Sender<Result<OpenedStream, LiveError>>,
}

/// The services are open.
pub(super) struct OpenedStream {
    /// What of them is less than is wanted.
    pub(super) shortcomings: Vec<String>,
    /// What who directs must know.
    pub(super) token: Token,
}

impl Listen {
    /// Opens the services and polls them until it is told to stop; takes the last arrivals before
    /// it ends.
    pub(super) fn run(self) {
        let open = || {
            let node = Node::join("enact capture", self.iceoryx2.as_deref())?;
            let lock = DaemonLock::take(&node, &self.scene_file)?;
            let listening = Listening::open(&node, &self.scene)?;
            Ok((node, lock, listening))
        };
        // Where sending fails the daemon has given up already.
        let (_node, _lock, listening) = match open() {
            Ok((node, lock, listening)) => {
                let opened = OpenedStream {
                    shortcomings: listening.shortcomings().to_vec(),
                    token: lock.token(),
                };
                let _ = self.opened.send(Ok(opened));
                (node, lock, listening)
            }
            Err(error) => {
                let _ = self.opened.send(Err(error));
                return;
            }
        };
        let mut heard = Instant::now();
        let complaint = Seldom::default();
        let (mut beaten, mut trouble) = (None, None);
        loop {
            let is_last = self.stop.load(Ordering::Relaxed);
            let (batch, result) = poll(&listening);
            let now = Instant::now();
            if let Err(error) = result {
                if let Some(more) = complaint.due(now) {
                    tracing::error!(%error, more, "not received");
                }
                trouble = Some(error.to_string());
            }
            if beaten.is_none_or(|at| now.duration_since(at) > BEAT) {
                self.metrics
                    .health
                    .say(HealthPart::Listening, trouble.take());
                beaten = Some(now);
            }
            if !batch.is_empty() {
                heard = Instant::now();
                for part in parts(batch) {
                    self.metrics.batches_waiting.put();
                    if self.queue.send(part).is_err() {
                        return;
                    }
                }
            }
            if is_last {
                return;
            }
            let is_idle = heard.elapsed() > IDLE_AFTER;
            thread::sleep(if is_idle { POLL_IDLE } else { POLL });
        }
    }
}

/// The arrivals in order, in batches of bounded size.
fn parts(batch: Vec<Arrival>) -> impl Iterator<Item = Vec<Arrival>> {
    let mut left = batch.into_iter();
    std::iter::from_fn(move || {
        let part: Vec<Arrival> = left.by_ref().take(BATCH).collect();
        (!part.is_empty()).then_some(part)
    })
}

/// The arrivals of one poll. A take that starts begins with the samples of the same poll; one that
/// stops has all samples sent before the command.
fn poll(listening: &Listening) -> (Vec<Arrival>, Result<(), LiveError>) {
    let (mut samples, mut control) = (Vec::new(), Vec::new());
    let result = listening
        .take(&mut samples)
        .and(listening.take_control(&mut control));
    if control.is_empty() {
        return (samples, result);
    }
    let result = result.and(listening.take(&mut samples));
    let start = Command::Start.number();
    let is_start =
        |arrival: &Arrival| matches!(arrival.what, Arrived::Control(c) if c.command == start);
    let mut batch = Vec::with_capacity(samples.len() + control.len());
    let first = usize::from(control.first().is_some_and(is_start));
    batch.extend(control.drain(..first));
    batch.append(&mut samples);
    batch.append(&mut control);
    (batch, result)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ingest::live::PoseRecord;

    #[test]
    fn what_came_at_once_is_handed_on_in_order_and_in_bounded_batches() {
        let arrival = |sequence| Arrival {
            at: Instant::now(),
            what: Arrived::Pose {
                stream: 0,
                record: PoseRecord::numbered(sequence),
                is_overflow: false,
            },
        };
        let all: Vec<Arrival> = (0..2 * BATCH as u64 + 7).map(arrival).collect();
        let found: Vec<Vec<Arrival>> = parts(all.clone()).collect();
        let sizes: Vec<usize> = found.iter().map(Vec::len).collect();
        assert_eq!(sizes, [BATCH, BATCH, 7]);
        assert_eq!(found.concat(), all);
        assert_eq!(parts(Vec::new()).count(), 0);
    }
}
