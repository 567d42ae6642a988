//! Directs a running daemon: one command, mark or label, and the daemon's answer in words.

use std::path::PathBuf;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use serde::Deserialize;

use super::capture::{TrackerState, now_ns};
use crate::ingest::live::{
    AnswerListener, Command, LabelRecord, MarkRecord, NO_TIME, Node, Token, running_daemon,
    token_of_daemon,
};
use crate::write::{LabelPublisher, TrackerPublisher};

/// Interval of polling for the answer.
const POLL: Duration = Duration::from_millis(1);

/// Interval of repeating a command without an answer: it may be lost, or the daemon may not listen
/// yet. The daemon executes it once.
const REPEAT: Duration = Duration::from_millis(100);

/// Who waits for an estimate asks so often whether the daemon is still there.
const STILL_THERE: Duration = Duration::from_secs(2);

/// Without a daemon on this machine, how long one that is reached through a tunnel is waited for.
const ELSEWHERE: Duration = Duration::from_secs(1);

/// A command to the daemon.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Begin a take.
    Start,
    /// End the take and estimate it.
    Stop {
        /// What is said of the take.
        label: Label,
        /// Wait for its estimate.
        waits: bool,
    },
    /// End the take and move it aside.
    Discard,
    /// Report the state.
    Ask,
    /// An event of the scene happens now: this one, or the next one in order.
    Mark(Option<String>),
}

/// What is said of a take.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Label {
    /// Its name.
    pub name: Option<String>,
    /// A note.
    pub note: Option<String>,
    /// 1 (bad) to 5 (good).
    pub rating: Option<u32>,
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
    /// File with the daemon's token, for a daemon elsewhere; by default that of the daemon on this machine.
    pub token: Option<PathBuf>,
    /// How long to wait for an answer.
    pub patience: Duration,
}

/// What the daemon says.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum DaemonAnswer {
    /// How everything stands.
    Asked {
        /// Number of the running take, if there is one.
        take: Option<u64>,
        /// Samples and marks in it.
        messages: u64,
        /// Name of the scene.
        scene: String,
        /// Names of its events.
        events: Vec<String>,
        /// How its trackers stand.
        trackers: Vec<TrackerState>,
        /// What keeps takes from being written.
        troubles: Vec<String>,
        /// Address of the operator's page.
        #[serde(default)]
        page: Option<String>,
    },
    /// A take has begun.
    Started {
        /// Number of the take.
        take: u64,
        /// Topics on which nothing comes.
        unheard: Vec<String>,
        /// What may keep it from being written.
        #[serde(default)]
        troubles: Vec<String>,
    },
    /// A take is over.
    Closed {
        /// Number of the take.
        take: u64,
        /// Samples and marks in it.
        messages: u64,
        /// Its file.
        recording: String,
    },
    /// A take is moved aside.
    Discarded {
        /// Number of the take.
        take: u64,
        /// Its file; none where it could not be moved, and is where it was.
        #[serde(default)]
        recording: Option<String>,
    },
    /// A take could not be recorded.
    Broken {
        /// Number of the take.
        take: u64,
        /// The error.
        error: String,
    },
    /// A take is estimated.
    Estimated {
        /// Number of the take.
        take: u64,
        /// The file with the estimate.
        output: String,
        /// `physical`, `plausible` or `failed`.
        verdict: String,
        /// Whether nothing speaks against it.
        is_good: bool,
        /// Why the estimation ended.
        reason: String,
        /// What speaks against it, the gravest first.
        doubts: Vec<String>,
    },
    /// A take has no estimate.
    NotEstimated {
        /// Number of the take.
        take: u64,
        /// Its file.
        recording: String,
        /// The error.
        error: String,
    },
    /// The command cannot be obeyed.
    Refused {
        /// Why.
        reason: String,
    },
    /// Anything else.
    #[serde(other)]
    Other,
}

/// Directs the daemon; what it answered, and where an estimate was waited for what became of it.
/// What cannot be obeyed in the daemon's state is refused without being sent. Fails where no answer
/// comes in time.
pub fn direct(job: &DirectJob) -> anyhow::Result<Vec<DaemonAnswer>> {
    let at_ns = now_ns();
    let mut talk = Talk::begin(job, at_ns)?;
    let mut state = talk.ask(Command::Ask)?;
    if let (
        DaemonAnswer::Asked {
            page: Some(page), ..
        },
        Some(token),
    ) = (&mut state, &talk.token)
    {
        *page = operators_link(page, token);
    }
    if let Some(reason) = refusal(&job.direction, &state) {
        return Ok(vec![DaemonAnswer::Refused { reason }]);
    }
    let command = match &job.direction {
        Direction::Ask => return Ok(vec![state]),
        Direction::Start => Command::Start,
        Direction::Discard => Command::Discard,
        Direction::Stop { label, .. } => {
            talk.label(label)?;
            Command::Stop
        }
        // What was sent before a command has arrived when its answer comes.
        Direction::Mark(event) => {
            talk.mark(event.as_deref().unwrap_or_default(), at_ns)?;
            Command::Ask
        }
    };
    let answer = talk.ask(command)?;
    let waits = matches!(job.direction, Direction::Stop { waits: true, .. });
    match answer {
        DaemonAnswer::Closed { take, .. } if waits => {
            let estimated = talk.estimate_of(take)?;
            Ok(vec![answer, estimated])
        }
        answer => Ok(vec![answer]),
    }
}

/// The link to the operator's page by which it may direct: what is after `#` stays in the browser.
pub(super) fn operators_link(address: &str, token: &Token) -> String {
    format!("{address}/#token={}", token.text())
}

/// Why the daemon could not obey in that state, if it could not.
fn refusal(direction: &Direction, state: &DaemonAnswer) -> Option<String> {
    let DaemonAnswer::Asked {
        take,
        scene,
        events,
        ..
    } = state
    else {
        return None;
    };
    match (direction, take) {
        (Direction::Ask, _) | (Direction::Start, None) => None,
        (Direction::Start, Some(take)) => {
            Some(format!("take {take} runs: stop or discard it first"))
        }
        (_, None) => Some("no take runs".to_owned()),
        (Direction::Mark(Some(event)), _) if !events.contains(event) => {
            let known = events.join(", ");
            Some(format!(
                "scene {scene:?} has no event {event:?}, only {known}"
            ))
        }
        _ => None,
    }
}

/// A conversation with the daemon.
struct Talk<'a> {
    job: &'a DirectJob,
    answers: AnswerListener,
    publisher: TrackerPublisher,
    labels: LabelPublisher,
    /// The daemon's token, if it is known.
    token: Option<Token>,
    session: u32,
    sequence: u64,
    /// What was heard that answers another command, or none.
    heard: Vec<DaemonAnswer>,
}

/// The token that a job knows.
fn token(job: &DirectJob) -> anyhow::Result<Option<Token>> {
    let Some(file) = &job.token else {
        return Ok(token_of_daemon(job.iceoryx2.as_deref())?);
    };
    let read = Token::read(file);
    let read = read.with_context(|| format!("{}: cannot read the token", file.display()))?;
    Ok(Some(read))
}

impl<'a> Talk<'a> {
    fn begin(job: &'a DirectJob, at_ns: i64) -> anyhow::Result<Self> {
        let node = Node::join("enact take", job.iceoryx2.as_deref())?;
        Ok(Self {
            job,
            answers: AnswerListener::open(&node)?,
            publisher: TrackerPublisher::open(&node, &[], &job.marks_topic)?,
            labels: LabelPublisher::open(&node)?,
            token: token(job)?,
            // Processes that ask at the same time differ by their ids.
            session: std::process::id(),
            sequence: at_ns as u64,
            heard: Vec::new(),
        })
    }

    fn mark(&self, event: &str, at_ns: i64) -> anyhow::Result<()> {
        let hearers = self.publisher.mark(MarkRecord {
            sequence: 0,
            available_ns: now_ns(),
            sample_ns: at_ns,
            device_ns: NO_TIME,
            event: MarkRecord::event_bytes(event),
            flags: 0,
            session: self.session,
        })?;
        if hearers == 0 {
            let topic = &self.job.marks_topic;
            bail!("nobody listens on {topic:?}: is it the scene's marks_topic? Give --topic");
        }
        Ok(())
    }

    fn label(&self, label: &Label) -> anyhow::Result<()> {
        if *label == Label::default() {
            return Ok(());
        }
        let text = |text: &Option<String>| text.clone().unwrap_or_default();
        let (name, note) = (text(&label.name), text(&label.note));
        let rating = label.rating.unwrap_or(0);
        let record = LabelRecord::new(self.session, now_ns(), &name, &note, rating);
        let hearers = self.labels.send(record)?;
        if hearers == 0 {
            bail!("nobody listens to what is said of takes");
        }
        Ok(())
    }

    /// Sends a command until it is answered.
    fn ask(&mut self, command: Command) -> anyhow::Result<DaemonAnswer> {
        self.sequence += 1;
        let (session, sequence, at_ns) = (self.session, self.sequence, now_ns());
        let (begun, mut asked) = (Instant::now(), None::<Instant>);
        while begun.elapsed() < self.job.patience {
            if asked.is_none_or(|at| at.elapsed() > REPEAT) {
                let token = self.token.unwrap_or(Token::NONE);
                let hearers = self
                    .publisher
                    .control(command, session, sequence, at_ns, token)?;
                asked = (hearers > 0).then(Instant::now);
            }
            while let Some(answered) = self.answers.receive()? {
                let answer = serde_json::from_str(&answered.json)
                    .context("the daemon's answer is not understood: is it another version?")?;
                if (answered.session, answered.sequence) == (session, sequence) {
                    return Ok(answer);
                }
                self.heard.push(answer);
            }
            let is_lonely = asked.is_none() && begun.elapsed() > ELSEWHERE;
            if is_lonely && running_daemon(self.job.iceoryx2.as_deref())?.is_none() {
                bail!("no daemon runs: start `enact capture SCENE`; `enact doctor` says more");
            }
            thread::sleep(POLL);
        }
        bail!("no answer of the daemon: `enact doctor` says more")
    }

    /// Waits for what becomes of a take, as long as the daemon is there.
    fn estimate_of(&mut self, take: u64) -> anyhow::Result<DaemonAnswer> {
        loop {
            let asked = Instant::now();
            while asked.elapsed() < STILL_THERE {
                let is_it = |answer: &DaemonAnswer| {
                    matches!(answer, DaemonAnswer::Estimated { take: of, .. }
                        | DaemonAnswer::NotEstimated { take: of, .. } if *of == take)
                };
                if let Some(at) = self.heard.iter().position(is_it) {
                    return Ok(self.heard.swap_remove(at));
                }
                self.heard.clear();
                while let Some(answered) = self.answers.receive()? {
                    self.heard.extend(serde_json::from_str(&answered.json));
                }
                thread::sleep(POLL);
            }
            self.ask(Command::Ask)?;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(take: Option<u64>) -> DaemonAnswer {
        DaemonAnswer::Asked {
            take,
            messages: 0,
            scene: "x".to_owned(),
            events: vec!["bounce".to_owned(), "landing".to_owned()],
            trackers: Vec::new(),
            troubles: Vec::new(),
            page: None,
        }
    }

    #[test]
    fn what_cannot_be_obeyed_is_refused_with_why() {
        let stop = Direction::Stop {
            label: Label::default(),
            waits: false,
        };
        let mark = |name: &str| Direction::Mark(Some(name.to_owned()));
        for (direction, take, why) in [
            (Direction::Start, Some(3), Some("take 3 runs")),
            (Direction::Start, None, None),
            (stop.clone(), None, Some("no take runs")),
            (stop, Some(1), None),
            (Direction::Mark(None), None, Some("no take runs")),
            (Direction::Mark(None), Some(1), None),
            (mark("bounce"), Some(1), None),
            (
                mark("bonce"),
                Some(1),
                Some("no event \"bonce\", only bounce, landing"),
            ),
            (Direction::Ask, None, None),
        ] {
            let refused = refusal(&direction, &state(take));
            assert_eq!(refused.is_some(), why.is_some(), "{direction:?}");
            assert!(
                refused
                    .unwrap_or_default()
                    .contains(why.unwrap_or_default())
            );
        }
    }
}
