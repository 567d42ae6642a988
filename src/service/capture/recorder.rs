//! The thread that journals. It hands all other work to other threads without waiting.

mod intervals;
mod state;
mod takes;

use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use super::event::CaptureEvent;
use super::notice::Notice;
use super::take::{OpenTake, now_ns};
use crate::ingest::live::{Arrival, Arrived, Command, ControlRecord};
use crate::motion::{Scene, Stamp};
use intervals::STATUS;
pub(super) use state::Recorder;
use state::RecorderState;
use takes::journal;

/// Most of what the acting page sends that is taken in before other trackers are listened to again.
const ACTED: usize = 512;

impl Recorder {
    /// Journals arrivals until the queue is closed, then closes the take.
    pub(super) fn run(mut self, queue: &Receiver<Vec<Arrival>>, start_now: bool) {
        let mut state = RecorderState::new(&self);
        if start_now {
            self.start(&mut state, None);
        }
        let tick = self.settings.chunk.min(STATUS) / 20;
        loop {
            match queue.recv_timeout(tick) {
                Ok(batch) => {
                    self.metrics.batches_waiting.take();
                    let last = batch.last().map(|arrival| arrival.at.elapsed());
                    state.behind = last.unwrap_or_default();
                    batch.iter().for_each(|arrival| {
                        self.take_in(&mut state, arrival);
                        self.show(arrival);
                    });
                }
                Err(RecvTimeoutError::Timeout) => state.behind = Duration::ZERO,
                Err(RecvTimeoutError::Disconnected) => break,
            }
            for turn in 0..ACTED {
                // Orders of the operator wait for nobody.
                while let Ok(order) = self.orders.try_recv() {
                    self.take_in(&mut state, &order);
                    self.show(&order);
                }
                let Ok(acted) = self.acted.try_recv() else {
                    break;
                };
                if turn == 0 {
                    state.behind = state.behind.max(acted.at.elapsed());
                }
                self.take_in(&mut state, &acted);
                self.show(&acted);
            }
            self.tick(&mut state, Instant::now());
        }
        if state.take.is_some() {
            self.stop(&mut state, None);
        }
    }

    /// Shows an arrival to viewers, in a take or not.
    fn show(&mut self, arrival: &Arrival) {
        let Some(feed) = &mut self.feed else {
            return;
        };
        match &arrival.what {
            Arrived::Pose { stream, record, .. } => feed.pose(arrival.at, *stream, record),
            Arrived::Mark(record) => {
                if let Some(mark) = record.mark(Stamp(now_ns())) {
                    feed.mark(mark);
                }
            }
            Arrived::Label(_) | Arrived::Control(_) => {}
        }
    }

    fn take_in(&self, state: &mut RecorderState, arrival: &Arrival) {
        match &arrival.what {
            Arrived::Control(record) => {
                self.control(state, record);
                self.say_status(state, Instant::now());
                return;
            }
            Arrived::Label(record) => {
                let taken = match &mut state.take {
                    Some(take) => take.label.take(record),
                    None => Err("no take runs".to_owned()),
                };
                if let Err(why) = taken {
                    let text = format!("a label was refused: {why}");
                    let warning = CaptureEvent::Warning { text };
                    self.publisher.say_at_once(Notice::of(warning));
                }
                return;
            }
            Arrived::Pose { stream, record, .. } => {
                state.pulses[*stream].sample(arrival.at, record);
            }
            Arrived::Mark(_) => {}
        }
        let Some(take) = &mut state.take else {
            state.outside += 1;
            return state.preroll.keep(arrival.clone());
        };
        state.preroll.pass(arrival);
        if let Err(error) = journal(take, arrival) {
            self.give_up(state, &error);
        }
    }

    /// Executes a command. One that is repeated gets the same answer again and is not executed
    /// twice.
    fn control(&self, state: &mut RecorderState, record: &ControlRecord) {
        let asked = Some(record);
        let mut answered = state.answered.iter();
        if let Some((_, said)) = answered.find(|(answered, _)| answered == record) {
            return self.publisher.say_at_once(Notice {
                is_repeated: true,
                ..Notice::asked(said.clone(), asked)
            });
        }
        let runs = state.take.is_some();
        let command = Command::of(record.command);
        let directs = command.is_some_and(|command| command != Command::Ask);
        if directs && !self.token.lets_in(&record.token) {
            let reason = "without the daemon's token nobody directs it: `enact take` reads it from a file of the user \
                          who runs the daemon, or from --token FILE";
            let said = CaptureEvent::Refused {
                command: record.command,
                reason: reason.to_owned(),
            };
            return self.publisher.say_at_once(Notice::asked(said, asked));
        }
        match command {
            Some(Command::Start) => {
                if runs {
                    self.stop(state, asked);
                }
                self.start(state, asked);
            }
            Some(Command::Stop) if runs => self.stop(state, asked),
            Some(Command::Discard) if runs => self.discard(state, asked),
            Some(Command::Ask) => {
                let said = self.asked(state);
                self.publisher.say_at_once(Notice::asked(said, asked));
            }
            command => {
                let reason = match command {
                    Some(_) => "no take runs",
                    None => "no such command",
                };
                let said = CaptureEvent::Refused {
                    command: record.command,
                    reason: reason.to_owned(),
                };
                self.publisher.say_at_once(Notice::asked(said, asked));
            }
        }
    }

    /// How everything stands.
    fn asked(&self, state: &mut RecorderState) -> CaptureEvent {
        let now = Instant::now();
        let known = state.known_until(now);
        let take = state.take.as_ref();
        let mut troubles = self.metrics.health.troubles(now);
        troubles.extend(take.and_then(OpenTake::lost));
        CaptureEvent::Asked {
            take: take.map(|take| take.number),
            messages: take.map_or(0, |take| take.journal.messages()),
            scene: self.scene.name.clone(),
            events: event_names(&self.scene),
            trackers: state
                .pulses
                .iter_mut()
                .map(|pulse| pulse.state(known))
                .collect(),
            troubles,
            page: self.page.clone(),
        }
    }
}

/// Names that marks may have.
pub(super) fn event_names(scene: &Scene) -> Vec<String> {
    scene
        .events
        .iter()
        .map(|event| event.name.clone())
        .collect()
}

#[cfg(test)]
mod tests;
