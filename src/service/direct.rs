//! Directing a daemon from outside: one command, or one mark, and its answer.

use std::path::PathBuf;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::bail;

use super::capture::now_ns;
use crate::ingest::live::{
    Command, MarkRecord, NO_TIME, Node, TakeListener, TakeRecord, TakeState,
};
use crate::write::TrackerPublisher;

/// How often the answer is looked for.
const POLL: Duration = Duration::from_millis(1);

/// How often a command is repeated that has no answer: what carries it may lose it, or lead nowhere
/// yet. The daemon obeys once.
const REPEAT: Duration = Duration::from_millis(100);

/// What is wanted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Begin a take.
    Start,
    /// End it and estimate it.
    Stop,
    /// End it and remove it.
    Discard,
    /// Say how it stands.
    Ask,
    /// An event of the scene happens now: this one, or the next one in order.
    Mark(Option<String>),
}

/// Whom to direct, and how.
#[derive(Clone, Debug)]
pub struct DirectJob {
    /// What is wanted.
    pub direction: Direction,
    /// Topic of marks.
    pub marks_topic: String,
    /// Configuration of iceoryx2; by default where iceoryx2 looks for it.
    pub iceoryx2: Option<PathBuf>,
    /// How long to wait for the answer.
    pub patience: Duration,
}

/// What the daemon answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// The take it concerns; 0: none.
    pub take: u64,
    /// Samples and marks in it.
    pub messages: u64,
    /// Where it stands; `None` where a newer daemon says what we do not know.
    pub state: Option<TakeState>,
}

/// Sends what is wanted and waits for the answer. A mark is stamped at once, and is with the
/// daemon when the answer comes. Fails where none comes.
pub fn direct(job: &DirectJob) -> anyhow::Result<Answer> {
    let at_ns = now_ns();
    let begun = Instant::now();
    let node = Node::join("enact take", job.iceoryx2.as_deref())?;
    let answers = TakeListener::open(&node)?;
    let publisher = TrackerPublisher::open(&node, &[], &job.marks_topic)?;
    // Whoever asks at one time as another process is another process.
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
        // The mark first: what was sent before a command is there when the command is.
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
