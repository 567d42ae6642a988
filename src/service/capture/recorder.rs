//! The thread that journals. It hands all other work to other threads without waiting.

use std::collections::VecDeque;
use std::fs::File;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError};
use std::time::{Duration, Instant};

use tokio::sync::watch;

use super::estimator::Finished;
use super::event::{CaptureEvent, CountsLine, Status};
use super::health::Part;
use super::latency::Latencies;
use super::metrics::Metrics;
use super::naming::{last_number, take_path};
use super::notice::{Notice, Speaker};
use super::preroll::Preroll;
use super::presence::{Presence, Pulse};
use super::previewer::PreviewInput;
use super::seldom::Seldom;
use super::take::{Take, now_ns};
use super::viewer::Feed;
use crate::config::CaptureSettings;
use crate::ingest::live::{Arrival, Arrived, StreamTopic};
use crate::ingest::live::{Command, ControlRecord};
use crate::motion::{Scene, Stamp};
use crate::write::WriteError;

/// Interval of updating the status.
const STATUS: Duration = Duration::from_millis(200);

/// Greatest number of events of a take with previews; longer takes have none.
const SO_FAR_EVENTS: usize = 200_000;

/// Greatest number of messages of a take that the daemon estimates; `enact process` estimates
/// larger ones.
const FINAL_MESSAGES: u64 = 2_000_000;

/// Interval of looking whether trackers are silent.
const LISTEN: Duration = Duration::from_millis(100);

/// Number of commands whose answers are kept to be repeated.
const ANSWERS: usize = 16;

/// The inputs of the thread.
pub(super) struct Recorder {
    pub(super) scene: Scene,
    pub(super) scene_toml: Vec<u8>,
    pub(super) settings: CaptureSettings,
    pub(super) topics: Vec<StreamTopic>,
    pub(super) publisher: Speaker,
    pub(super) so_far: SyncSender<PreviewInput>,
    pub(super) finals: SyncSender<Finished>,
    pub(super) syncer: SyncSender<File>,
    pub(super) status: watch::Sender<Status>,
    pub(super) metrics: Arc<Metrics>,
    /// Queue to the viewers, if they are served.
    pub(super) feed: Option<Feed>,
    /// What the operator's page directs.
    pub(super) orders: Receiver<Arrival>,
}

/// The state of the thread.
struct RecorderState {
    take: Option<Take>,
    takes: u64,
    outside: u64,
    /// Number of events of the running take that the previewer was given; `None` without previews.
    followed: Option<usize>,
    /// Whether the previewer must be told that the take is over.
    is_over: bool,
    /// The last commands that were executed, with their answers.
    answered: VecDeque<(ControlRecord, CaptureEvent)>,
    /// Sums over the takes that are over.
    totals: (CountsLine, Latencies),
    /// The trackers, stream by stream.
    pulses: Vec<Pulse>,
    /// What came in the last seconds, while no take runs.
    preroll: Preroll,
    said: Instant,
    listened: Instant,
    slow_disk: Seldom,
}

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
                    batch.iter().for_each(|arrival| {
                        self.take_in(&mut state, arrival);
                        self.show(arrival);
                    });
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            while let Ok(order) = self.orders.try_recv() {
                self.take_in(&mut state, &order);
                self.show(&order);
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
            Arrived::Control(record) => return self.control(state, record),
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
        match Command::of(record.command) {
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
        let take = state.take.as_ref();
        CaptureEvent::Asked {
            take: take.map(|take| take.number),
            messages: take.map_or(0, |take| take.journal.messages()),
            scene: self.scene.name.clone(),
            events: event_names(&self.scene),
            trackers: state
                .pulses
                .iter_mut()
                .map(|pulse| pulse.state(now))
                .collect(),
            troubles: self.metrics.health.troubles(now),
        }
    }

    fn start(&self, state: &mut RecorderState, asked: Option<&ControlRecord>) {
        state.takes += 1;
        let path = take_path(&self.settings.folder, state.takes, now_ns());
        let (scene, toml) = (&self.scene, &self.scene_toml);
        match Take::begin(
            state.takes,
            &path,
            scene,
            toml,
            &self.topics,
            &self.settings,
        ) {
            Ok(mut take) => {
                (state.followed, state.is_over) = (Some(0), false);
                let kept = state.preroll.take(Instant::now());
                let pulses = state.pulses.iter();
                let unheard = pulses.filter(|pulse| !pulse.is_sending());
                let said = CaptureEvent::Started {
                    take: state.takes,
                    recording: path.display().to_string(),
                    unheard: unheard.map(|pulse| pulse.topic().to_owned()).collect(),
                    before: kept.len() as u64,
                };
                self.metrics.health.say(Part::Take, None);
                self.answer(state, said, asked);
                take.is_catching_up = true;
                let caught_up = kept
                    .iter()
                    .try_for_each(|arrival| journal(&mut take, arrival));
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

    fn stop(&self, state: &mut RecorderState, asked: Option<&ControlRecord>) {
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
            match self.finals.try_send(Finished { take: number, path }) {
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

    fn discard(&self, state: &mut RecorderState, asked: Option<&ControlRecord>) {
        let Some(take) = state.take.take() else {
            return;
        };
        state.end_of(&take);
        let number = take.number;
        if let Err(error) = take.journal.discard() {
            self.publisher
                .say_at_once(Notice::of(CaptureEvent::Warning {
                    text: error.to_string(),
                }));
        }
        self.answer(state, CaptureEvent::Discarded { take: number }, asked);
    }

    /// Answers a command that was executed, and keeps the answer.
    fn answer(&self, state: &mut RecorderState, said: CaptureEvent, asked: Option<&ControlRecord>) {
        if let Some(command) = asked {
            state.answered.truncate(ANSWERS - 1);
            state.answered.push_front((*command, said.clone()));
        }
        self.publisher.say_at_once(Notice::asked(said, asked));
    }

    /// Stops recording after an error: the journal so far becomes a file, if possible.
    fn give_up(&self, state: &mut RecorderState, error: &WriteError) {
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
        self.metrics.health.say(Part::Take, Some(trouble));
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

    /// Everything that is done at intervals.
    fn tick(&self, state: &mut RecorderState, now: Instant) {
        if now.duration_since(state.listened) >= LISTEN {
            state.listened = now;
            self.metrics.health.say(Part::Recorder, None);
            self.listen(state, now);
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
            state.said = now;
            self.status.send_replace(status(state, now));
        }
    }

    /// Asks the syncer to sync the journal, unless a sync is still waiting.
    fn sync(&self, take: &mut Take, now: Instant, slow: &Seldom) {
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
    fn follow(&self, state: &mut RecorderState, take: &mut Take) {
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

impl RecorderState {
    /// No take yet.
    fn new(of: &Recorder) -> Self {
        let now = Instant::now();
        let pulses = of.topics.iter().map(|topic| Pulse::new(&topic.topic, now));
        Self {
            take: None,
            takes: last_number(&of.settings.folder),
            pulses: pulses.collect(),
            preroll: Preroll::new(of.settings.pre_roll),
            listened: now,
            slow_disk: Seldom::default(),
            outside: 0,
            followed: None,
            is_over: false,
            answered: VecDeque::new(),
            totals: Default::default(),
            said: now,
        }
    }

    /// Ends the previews of the take.
    fn unfollow(&mut self) {
        self.is_over |= self.followed.take().is_some();
    }

    /// Adds the counts of a take that is over to the totals.
    fn end_of(&mut self, take: &Take) {
        self.unfollow();
        self.totals.0.add(&take.counts());
        self.totals.1.merge(&take.latencies);
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

/// Journals a sample or a mark.
fn journal(take: &mut Take, arrival: &Arrival) -> Result<(), WriteError> {
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

fn status(state: &mut RecorderState, now: Instant) -> Status {
    let trackers = state.pulses.iter_mut().map(|pulse| pulse.state(now));
    let trackers = trackers.collect();
    let take = state.take.as_ref();
    let (mut totals, mut latency) = state.totals.clone();
    if let Some(take) = take {
        totals.add(&take.counts());
        latency.merge(&take.latencies);
    }
    Status {
        take: take.map(|take| take.number),
        recording: take.map(|take| take.journal.path().display().to_string()),
        messages: take.map_or(0, |take| take.journal.messages()),
        counts: take.map(Take::counts).unwrap_or_default(),
        trackers,
        outside: state.outside,
        totals,
        latency,
    }
}

#[cfg(test)]
mod tests;
