//! Sends one command or one mark to a running daemon and waits for its answer.

use std::path::PathBuf;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::bail;

use super::capture::now_ns;
use crate::ingest::live::{
    Command, MarkRecord, NO_TIME, Node, TakeListener, TakeRecord, TakeState,
};
use crate::write::TrackerPublisher;

/// Interval of polling for the answer.
const POLL: Duration = Duration::from_millis(1);

/// Interval of repeating a command without an answer: it may be lost, or the daemon may not listen
/// yet. The daemon executes it once.
const REPEAT: Duration = Duration::from_millis(100);

/// A command to the daemon.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Begin a take.
    Start,
    /// End the take and estimate it.
    Stop,
    /// End the take and remove it.
    Discard,
    /// Report the state.
    Ask,
    /// An event of the scene happens now: this one, or the next one in order.
    Mark(Option<String>),
}

/// The input of [`direct`].
#[derive(Clone, Debug)]
pub struct DirectJob {
    /// The command.
    pub direction: Direction,
    /// Topic of marks.
    pub marks_topic: String,
    /// Configuration of iceoryx2; by default where iceoryx2 looks for it.
    pub iceoryx2: Option<PathBuf>,
    /// How long to wait for the answer.
    pub patience: Duration,
}

/// The answer of the daemon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// The take it concerns; 0: none.
    pub take: u64,
    /// Samples and marks in it.
    pub messages: u64,
    /// Its state; `None` for a state of a newer daemon that is unknown here.
    pub state: Option<TakeState>,
}

/// Sends a command and waits for the answer. A mark is stamped at once, and has reached the daemon
/// when the answer comes. Fails where no answer comes in time.
pub fn direct(job: &DirectJob) -> anyhow::Result<Answer> {
    let at_ns = now_ns();
    let begun = Instant::now();
    let node = Node::join("enact take", job.iceoryx2.as_deref())?;
    let answers = TakeListener::open(&node)?;
    let publisher = TrackerPublisher::open(&node, &[], &job.marks_topic)?;
    // Processes that ask at the same time differ by their ids.
    let session = std::process::id();
    let mut is_marked = false;
    let mut asked: Option<Instant> = None;
    let (event, command) = match &job.direction {
        Direction::Start => (None, Command::Start),
        Direction::Stop => (None, Command::Stop),
        Direction::Discard => (None, Command::Discard),
        Direction::Ask => (None, Command::Ask),
        Direction::Mark(event) => (Some(event.as_deref().unwrap_or_default()), Command::Ask),
    };
    while begun.elapsed() < job.patience {
        if let Some(event) = event
            && !is_marked
        {
            is_marked = publisher.mark(mark(event, at_ns, session))? > 0;
        }
        // The mark first: samples sent before a command have arrived when the command has.
        let is_due = asked.is_none_or(|at| at.elapsed() > REPEAT);
        if (is_marked || event.is_none()) && is_due {
            let hearers = publisher.control(command, session, at_ns as u64, at_ns)?;
            asked = (hearers > 0).then(Instant::now);
        }
        while let Some(record) = answers.next()? {
            if (record.control_session, record.control_sequence) == (session, at_ns as u64) {
                return Ok(answer(&record));
            }
        }
        thread::sleep(POLL);
    }
    bail!("no answer: is `enact capture` there? `enact doctor` says who is")
}

fn mark(event: &str, at_ns: i64, session: u32) -> MarkRecord {
    MarkRecord {
        sequence: 0,
        available_ns: now_ns(),
        sample_ns: at_ns,
        device_ns: NO_TIME,
        event: MarkRecord::event_bytes(event),
        flags: 0,
        session,
    }
}

fn answer(record: &TakeRecord) -> Answer {
    Answer {
        take: record.take,
        messages: record.messages,
        state: TakeState::of(record.state),
    }
}
