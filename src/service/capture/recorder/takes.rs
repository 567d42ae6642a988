//! How a take begins and ends.

use std::path::PathBuf;
use std::time::Instant;

use super::super::estimator::FinishedTake;
use super::super::event::CaptureEvent;
use super::super::health::HealthPart;
use super::super::naming::{DISCARDED, take_path};
use super::super::notice::Notice;
use super::super::take::{OpenTake, now_ns};
use super::state::{Recorder, RecorderState};
use crate::ingest::live::{Arrival, Arrived, Command, ControlRecord};
use crate::write::WriteError;

/// Greatest number of messages of a take that the daemon estimates; `enact process` estimates
/// larger ones.
const FINAL_MESSAGES: u64 = 2_000_000;

/// Number of commands whose answers are kept to be repeated.
const ANSWERS: usize = 16;

impl Recorder {
    /// Begins a take; where it is known that none can be written, none is begun.
    pub(super) fn start(&self, state: &mut RecorderState, asked: Option<&ControlRecord>) {
        if let Some(reason) = self.metrics.health.of_folder(&self.settings.folder) {
            let said = CaptureEvent::Refused {
                command: Command::Start.number(),
                reason,
            };
            return self.answer(state, said, asked);
        }
        state.takes += 1;
        let begun = Instant::now();
        state.preroll.forget(begun);
        let path = take_path(&self.settings.folder, state.takes, now_ns());
        let (scene, toml) = (&self.scene, &self.scene_toml);
        match OpenTake::begin(
            state.takes,
            &path,
            scene,
            toml,
            &self.topics,
            &self.settings,
            &|stream| state.preroll.before(stream),
        ) {
            Ok(mut take) => {
                (state.followed, state.is_over) = (Some(0), false);
                let kept = state.preroll.take(begun);
                let pulses = state.pulses.iter();
                let unheard = pulses.filter(|pulse| !pulse.is_sending());
                self.metrics.health.say(HealthPart::Take, None);
                let said = CaptureEvent::Started {
                    troubles: self.metrics.health.troubles(begun),
                    take: state.takes,
                    recording: path.display().to_string(),
                    unheard: unheard.map(|pulse| pulse.topic().to_owned()).collect(),
                    before: kept.len() as u64,
                };
                self.answer(state, said, asked);
                take.is_catching_up = true;
                let caught_up = kept.iter().try_for_each(|arrival| {
                    state.preroll.pass(arrival);
                    journal(&mut take, arrival)
                });
                take.is_catching_up = false;
                state.take = Some(take);
                if let Err(error) = caught_up {
                    self.give_up(state, &error);
                }
            }
            Err(error) => {
                self.is_broken(state.takes, &error.to_string());
                let said = CaptureEvent::Broken {
                    take: state.takes,
                    recording: path.display().to_string(),
                    messages: 0,
                    error: error.to_string(),
                };
                self.answer(state, said, asked);
            }
        }
    }

    pub(super) fn stop(&self, state: &mut RecorderState, asked: Option<&ControlRecord>) {
        let Some(mut take) = state.take.take() else {
            return;
        };
        self.follow(state, &mut take);
        if let Err(error) = take.note_end() {
            state.take = Some(take);
            return self.give_up(state, &error);
        }
        state.end_of(&take);
        let (number, messages, counts) = (take.number, take.journal.messages(), take.counts());
        let label = take.label.clone();
        let path = take.journal.path().to_owned();
        let part = take.journal.part().to_owned();
        let recording = path.display().to_string();
        if let Err(error) = take.journal.finish() {
            let error = error.to_string();
            self.is_broken(number, &error);
            // Its own name may be that of another file, which came meanwhile.
            let left = if part.exists() { &part } else { &path };
            let said = CaptureEvent::Broken {
                take: number,
                recording: left.display().to_string(),
                messages,
                error,
            };
            return self.answer(state, said, asked);
        }
        let said = CaptureEvent::Closed {
            take: number,
            recording: recording.clone(),
            messages,
            counts,
            label,
        };
        self.answer(state, said, asked);
        let reason = if messages > FINAL_MESSAGES {
            format!("{messages} messages are too many to estimate beside a recording")
        } else {
            match self.finals.try_send(FinishedTake { take: number, path }) {
                Ok(()) => return self.metrics.finals_waiting.put(),
                Err(_) => "too many takes wait for their estimates".to_owned(),
            }
        };
        self.publisher
            .say_at_once(Notice::of(CaptureEvent::NotEstimated {
                take: number,
                error: format!("{reason}: enact process {recording}"),
                recording,
            }));
    }

    /// Ends the take and moves it aside; nothing is deleted.
    pub(super) fn discard(&self, state: &mut RecorderState, asked: Option<&ControlRecord>) {
        let Some(mut take) = state.take.take() else {
            return;
        };
        if let Err(error) = take.note_end() {
            state.take = Some(take);
            return self.give_up(state, &error);
        }
        state.end_of(&take);
        let number = take.number;
        let aside = self.settings.folder.join(DISCARDED);
        let recording = match take.journal.set_aside(&aside) {
            Ok(path) => Some(path.display().to_string()),
            Err(error) => {
                let text = format!("take {number} is not moved aside: {error}");
                let warning = CaptureEvent::Warning { text };
                self.publisher.say_at_once(Notice::of(warning));
                None
            }
        };
        let said = CaptureEvent::Discarded {
            take: number,
            recording,
        };
        self.answer(state, said, asked);
    }

    /// Stops recording after an error: the journal so far becomes a file, if possible.
    pub(super) fn give_up(&self, state: &mut RecorderState, error: &WriteError) {
        let Some(take) = state.take.take() else {
            return;
        };
        state.end_of(&take);
        let (number, messages) = (take.number, take.journal.messages());
        let path = take.journal.path().to_owned();
        let part = take.journal.part().to_owned();
        let (recording, error): (PathBuf, String) = match take.journal.salvage() {
            Ok(()) => (path, error.to_string()),
            Err(worse) => (part, format!("{error}; then {worse}")),
        };
        self.is_broken(number, &error);
        self.publisher.say_at_once(Notice::of(CaptureEvent::Broken {
            take: number,
            recording: recording.display().to_string(),
            messages,
            error,
        }));
    }

    /// Health is bad until a take begins.
    fn is_broken(&self, take: u64, error: &str) {
        let trouble = format!("take {take} could not be recorded: {error}");
        self.metrics.health.say(HealthPart::Take, Some(trouble));
    }

    /// Answers a command that was executed, and keeps the answer.
    fn answer(&self, state: &mut RecorderState, said: CaptureEvent, asked: Option<&ControlRecord>) {
        if let Some(command) = asked {
            state.answered.truncate(ANSWERS - 1);
            state.answered.push_front((*command, said.clone()));
        }
        self.publisher.say_at_once(Notice::asked(said, asked));
    }
}

/// Journals a sample or a mark.
pub(super) fn journal(take: &mut OpenTake, arrival: &Arrival) -> Result<(), WriteError> {
    match &arrival.what {
        Arrived::Pose {
            stream,
            record,
            is_overflow,
        } => take.pose(arrival.at, *stream, record, *is_overflow),
        Arrived::Mark(record) => take.mark(arrival.at, record),
        Arrived::Label(_) | Arrived::Control(_) => Ok(()),
    }
}
