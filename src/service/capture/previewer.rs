//! The thread that estimates the running take: previews.
//!
//! At most one message waits; events that come meanwhile are in the next message, and one estimate
//! is made of all of them. After a mark it is made at once. Between marks the thread rests as long
//! as the last estimate took, so that it never uses more than half a core, and four times as long
//! where the estimate took longer than [`BURDEN`].

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use tokio::sync::watch;

use super::estimator::occasion;
use super::event::CaptureEvent;
use super::metrics::Metrics;
use super::notice::{Notice, Shown, Speaker};
use crate::motion::{Observer, Scene, TakeEvent};
use crate::pipeline::{Outcome, Preview};
use crate::report::{Reported, gravest, plain};
use crate::service::finish::reported;
use crate::service::panics::guarded;
use crate::service::provenance::scene_provenance;
use crate::service::words;
use crate::write::show::Showing;

/// After an estimate that takes longer than this, the thread rests four times as long.
const BURDEN: Duration = Duration::from_millis(50);

/// A message to the thread.
pub(super) enum PreviewInput {
    /// Events since the last message.
    Events {
        /// The take; another number begins another take.
        take: u64,
        /// Marks in it so far.
        marks: u64,
        /// Samples and marks, in order.
        events: Vec<TakeEvent>,
    },
    /// The take is over, or too long to be followed: its samples need not be kept.
    Over,
}

/// The inputs of the thread.
pub(super) struct Previewer {
    pub(super) scene: Scene,
    pub(super) publisher: Speaker,
    pub(super) shown: watch::Sender<Shown>,
    pub(super) metrics: Arc<Metrics>,
    /// Set once the daemon ends and waits for no estimate any more.
    pub(super) enough: &'static AtomicBool,
}

/// Ends an estimate when it is told to.
struct Until<'a>(&'a AtomicBool);

impl Observer for Until<'_> {
    fn should_stop(&mut self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// A take that is followed.
struct PreviewFollowing {
    take: u64,
    preview: Preview,
    marks: u64,
    /// Number of marks in the last estimate.
    told: u64,
    /// Whether there are events that no estimate contains.
    is_due: bool,
}

impl Previewer {
    /// Follows takes until the queue is closed.
    pub(super) fn run(self, queue: &Receiver<PreviewInput>) {
        let mut following: Option<PreviewFollowing> = None;
        let mut rested = Instant::now();
        loop {
            let is_due = following.as_ref().is_some_and(|f| f.is_due);
            let received = if is_due {
                queue.recv_timeout(rested.saturating_duration_since(Instant::now()))
            } else {
                queue.recv().map_err(|_| RecvTimeoutError::Disconnected)
            };
            match received {
                Ok(message) => self.take_in(&mut following, message),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            if self.enough.load(Ordering::Relaxed) {
                continue;
            }
            let Some(following) = following.as_mut().filter(|f| f.is_due) else {
                continue;
            };
            if following.marks > following.told || Instant::now() >= rested {
                let took = self.estimate(following);
                let rest = if took > BURDEN { 4 * took } else { took };
                rested = Instant::now() + rest;
            }
        }
    }

    fn take_in(&self, following: &mut Option<PreviewFollowing>, message: PreviewInput) {
        self.metrics.previews_waiting.take();
        let PreviewInput::Events {
            take,
            marks,
            events,
        } = message
        else {
            *following = None;
            return;
        };
        let new = || PreviewFollowing {
            take,
            preview: Preview::new(self.scene.clone()),
            marks: 0,
            told: 0,
            is_due: false,
        };
        let following = match following {
            Some(following) if following.take == take => following,
            _ => following.insert(new()),
        };
        following.is_due |= !events.is_empty();
        following.marks = marks;
        for event in events {
            following.preview.push(event);
        }
    }

    /// Keeps the motion so far for the pages: they play it from the end of the take until the checked one is there.
    fn play(&self, take: u64, outcome: &Outcome) {
        let provenance = scene_provenance(&outcome.scene, outcome.estimate.verdict.as_str());
        let showing = Showing::new(&Reported {
            settled: None,
            rest: None,
            ..reported(outcome)
        });
        match showing {
            Ok(showing) => {
                if let Some(glb) = showing.glb(&outcome.scene, &provenance) {
                    self.metrics.history.keep_so_far(take, glb);
                }
            }
            Err(error) => tracing::debug!(take, %error, "not played"),
        }
    }

    /// Makes an estimate, shows it, and publishes it after a mark; returns how long it took.
    fn estimate(&self, following: &mut PreviewFollowing) -> Duration {
        let (take, marks) = (following.take, following.marks);
        following.is_due = false;
        let begun = Instant::now();
        let outcome = guarded(|| {
            let previewed = following.preview.estimate(&mut Until(self.enough))?;
            Ok(previewed.map(|previewed| (previewed.is_warm, previewed.outcome.clone())))
        });
        let took = begun.elapsed();
        match outcome {
            Ok(Some((is_warm, outcome))) => {
                self.metrics.preview(is_warm, took);
                self.shown.send_replace(Some(Arc::new(outcome.clone())));
                if marks > following.told {
                    following.told = marks;
                    self.play(take, &outcome);
                    let said = CaptureEvent::SoFar {
                        take,
                        marks,
                        verdict: outcome.estimate.verdict.as_str(),
                        doubt: gravest(&outcome.scene, &outcome.estimate.doubts),
                        seconds: took.as_secs_f64(),
                    };
                    let occasion = occasion(take, marks, false);
                    self.publisher
                        .say(Notice::estimated(said, occasion, outcome));
                }
            }
            Ok(None) => {}
            // Expected with the first samples, and with those right after a mark.
            Err(error) => {
                self.metrics.no_preview();
                // It may name a mark, as it came.
                let error = words(&error);
                let error = plain(&error);
                tracing::debug!(take, marks, %error, "no estimate so far");
            }
        }
        took
    }
}
