//! The thread that follows the performance: what the estimate so far is.
//!
//! One message waits at most; what comes meanwhile is in the next one, and of all that it brings
//! one estimate is made. After a mark that is at once; between marks the thread rests as long as
//! the last estimate took, so that it never has more than half a core, and four times as long
//! where that is no longer a preview but a burden.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use tokio::sync::watch;

use super::estimator::{guarded, occasion};
use super::event::CaptureEvent;
use super::metrics::Metrics;
use super::notice::{Notice, Shown, Speaker};
use crate::motion::{Scene, TakeEvent};
use crate::pipeline::Preview;
use crate::report::gravest;
use crate::service::words;

/// An estimate that takes longer is a burden.
const BURDEN: Duration = Duration::from_millis(50);

/// How the performance goes on.
pub(super) enum PreviewInput {
    /// What came since the last message.
    Events {
        /// In which take; one with another number begins.
        take: u64,
        /// Marks in it so far.
        marks: u64,
        /// Samples and marks, in order.
        events: Vec<TakeEvent>,
    },
    /// The take is over, or too long to be followed: its samples need not be kept.
    Over,
}

/// What the thread is given.
pub(super) struct Previewer {
    pub(super) scene: Scene,
    pub(super) publisher: Speaker,
    pub(super) shown: watch::Sender<Shown>,
    pub(super) metrics: Arc<Metrics>,
}

/// A take that is followed.
struct Following {
    take: u64,
    preview: Preview,
    marks: u64,
    /// Marks that the last estimate knew of.
    told: u64,
    /// Something came that no estimate knows of.
    is_due: bool,
}

impl Previewer {
    /// Follows takes until nobody sends any more.
    pub(super) fn run(self, queue: &Receiver<PreviewInput>) {
        let mut following: Option<Following> = None;
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

    fn take_in(&self, following: &mut Option<Following>, message: PreviewInput) {
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
        let new = || Following {
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

    /// Estimates, shows it, and after a mark says it; how long the estimation took.
    fn estimate(&self, following: &mut Following) -> Duration {
        let (take, marks) = (following.take, following.marks);
        following.is_due = false;
        let begun = Instant::now();
        let outcome = guarded(|| {
            let previewed = following.preview.estimate(&mut ())?;
            Ok(previewed.map(|previewed| (previewed.is_warm, previewed.outcome.clone())))
        });
        let took = begun.elapsed();
        match outcome {
            Ok(Some((is_warm, outcome))) => {
                self.metrics.preview(is_warm, took);
                self.shown.send_replace(Some(Arc::new(outcome.clone())));
                if marks > following.told {
                    following.told = marks;
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
            // So it is with the first samples, and with those after a mark.
            Err(error) => {
                self.metrics.no_preview();
                tracing::debug!(take, marks, error = %words(&error), "no estimate so far");
            }
        }
        took
    }
}
