//! What the recording thread does at intervals: it looks after trackers, syncs, previews and says how it stands.

use std::sync::mpsc::TrySendError;
use std::time::{Duration, Instant};

use super::super::event::CaptureEvent;
use super::super::health::HealthPart;
use super::super::notice::Notice;
use super::super::presence::Presence;
use super::super::previewer::PreviewInput;
use super::super::seldom::Seldom;
use super::super::take::OpenTake;
use super::state::{Recorder, RecorderState};

/// Interval of updating the status.
pub(super) const STATUS: Duration = Duration::from_millis(200);

/// Greatest number of events of a take with previews; longer takes have none.
const SO_FAR_EVENTS: usize = 200_000;

/// A recorder that is further behind what arrives is said to be: samples wait in buffers of 2048 beside
/// a full queue.
const BEHIND: Duration = Duration::from_secs(1);

/// Interval of looking whether trackers are silent.
const LISTEN: Duration = Duration::from_millis(100);

impl Recorder {
    /// Everything that is done at intervals.
    pub(super) fn tick(&self, state: &mut RecorderState, now: Instant) {
        if now.duration_since(state.listened) >= LISTEN {
            state.listened = now;
            let trouble = (state.behind > BEHIND).then(|| {
                let behind_s = state.behind.as_secs_f64();
                format!(
                    "recording is {behind_s:.1} s behind: this machine does not keep up, samples may be lost"
                )
            });
            self.metrics.health.say(HealthPart::Recorder, trouble);
            self.listen(state, state.known_until(now));
        }
        if let Some(mut take) = state.take.take() {
            let ticked = take.tick(now, &self.settings);
            if ticked.is_ok() {
                self.sync(&mut take, now, &state.slow_disk);
                self.follow(state, &mut take);
            }
            state.take = Some(take);
            if let Err(error) = ticked {
                self.give_up(state, &error);
            }
        }
        if state.is_over && self.so_far.try_send(PreviewInput::Over).is_ok() {
            self.metrics.previews_waiting.put();
            state.is_over = false;
        }
        if now.duration_since(state.said) >= STATUS {
            self.say_status(state, now);
        }
    }

    /// Shows how everything stands, which is what orders are checked against.
    pub(super) fn say_status(&self, state: &mut RecorderState, now: Instant) {
        state.said = now;
        self.status.send_replace(state.status(now));
    }

    /// Says which trackers have fallen silent, and which are there again.
    fn listen(&self, state: &mut RecorderState, now: Instant) {
        let take = state.take.as_ref().map(|take| take.number);
        for pulse in &mut state.pulses {
            let Some((presence, seen_s)) = pulse.changed(now) else {
                continue;
            };
            let topic = pulse.topic().to_owned();
            let said = match presence {
                Presence::Silent => CaptureEvent::Silent {
                    topic,
                    take,
                    seen_s,
                },
                Presence::Sending | Presence::Unheard => CaptureEvent::Heard { topic, take },
            };
            self.publisher.say_at_once(Notice::of(said));
        }
    }

    /// Asks the syncer to sync the journal, unless a sync is still waiting.
    fn sync(&self, take: &mut OpenTake, now: Instant, slow: &Seldom) {
        if now.duration_since(take.synced) < self.settings.sync {
            return;
        }
        take.synced = now;
        match take.journal.sync_handle() {
            Ok(file) => {
                if let Err(TrySendError::Full(_)) = self.syncer.try_send(file)
                    && let Some(more) = slow.due(now)
                {
                    tracing::warn!(more, "the disk takes longer than sync_ms to sync");
                }
            }
            Err(error) => {
                if let Some(more) = slow.due(now) {
                    tracing::warn!(%error, more, "not synced");
                }
            }
        }
    }

    /// Hands new events to the previewer. While its queue is full they wait and go with later ones;
    /// takes that grow too long get no more previews.
    pub(super) fn follow(&self, state: &mut RecorderState, take: &mut OpenTake) {
        if let Some(count) = &mut state.followed {
            *count += take.pending.len();
            if *count > SO_FAR_EVENTS {
                state.unfollow();
            }
        }
        if state.followed.is_none() {
            take.pending = Vec::new();
        }
        if take.pending.is_empty() {
            return;
        }
        let message = PreviewInput::Events {
            take: take.number,
            marks: take.marks(),
            events: std::mem::take(&mut take.pending),
        };
        match self.so_far.try_send(message) {
            Ok(()) => self.metrics.previews_waiting.put(),
            Err(TrySendError::Full(PreviewInput::Events { events, .. })) => {
                state.followed = state.followed.map(|count| count - events.len());
                take.pending = events;
            }
            Err(_) => state.followed = None,
        }
    }
}
