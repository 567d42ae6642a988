//! Publishing recordings, performances and loads as live takes.

mod fault;
mod load;
mod play;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use clap::Parser;
use enact::ingest::live::{Command, Node, TakeListener, Token, token_of_daemon};
use enact::write::TrackerPublisher;

use crate::perform::wish::{Manner, Motion, Wanted};
use fault::Faults;
pub use play::Sent;

/// Publish a recording, or a performance made on the spot, as a live take.
#[derive(Parser)]
pub struct Arguments {
    /// The recording, with a scene attached
    #[arg(required_unless_present_any = ["load", "perform", "bounces"])]
    recording: Option<PathBuf>,
    /// Scene file [default: the one attached]
    #[arg(long)]
    scene: Option<PathBuf>,
    /// In place of a recording: act this motion, now, in the manner that `--seed` and the knobs
    /// say
    #[arg(long, value_enum, conflicts_with_all = ["recording", "scene", "load"])]
    perform: Option<Motion>,
    /// Or a cube with this many bounces
    #[arg(long, conflicts_with_all = ["recording", "scene", "load", "perform"])]
    bounces: Option<usize>,
    /// In place of a recording: this many trackers, `t1`, `t2`, …, each on a circle
    #[arg(long, conflicts_with_all = ["recording", "scene"])]
    load: Option<usize>,
    /// Names of the trackers of a load
    #[arg(long, value_delimiter = ',')]
    names: Vec<String>,
    /// Length of a load
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// 1 is real time, 0 as fast as it goes
    #[arg(long, default_value_t = 1.0)]
    rate: f64,
    /// Start a take before and stop it after
    #[arg(long)]
    take: bool,
    /// Move the stamps of a recording to now, as those of a performance are
    #[arg(long)]
    now: bool,
    /// Leave the driver's times out: only the device clock is said
    #[arg(long)]
    no_sample_time: bool,
    /// Seconds to wait for an answer of the daemon
    #[arg(long, default_value_t = 10.0)]
    wait: f64,
    /// Configuration file of iceoryx2
    #[arg(long)]
    iceoryx2: Option<PathBuf>,
    #[command(flatten)]
    faults: Faults,
    #[command(flatten)]
    manner: Manner,
}

/// Publishes what is asked for; what was sent.
pub fn run(arguments: &Arguments) -> anyhow::Result<Sent> {
    let node = Node::join("enact tracker", arguments.iceoryx2.as_deref())?;
    let motion = arguments.perform.map(Wanted::Motion);
    match (
        arguments.load,
        motion.or(arguments.bounces.map(Wanted::Bounces)),
    ) {
        (Some(trackers), _) => load::run(arguments, &node, trackers),
        (None, Some(wanted)) => play::perform(arguments, &node, wanted),
        (None, None) => {
            let recording = arguments.recording.as_ref();
            let recording = recording.context("expected a recording, --perform or --load")?;
            play::recording(arguments, &node, recording)
        }
    }
}

/// How often a command is repeated that has no answer.
const REPEAT: Duration = Duration::from_millis(100);

/// Sends commands, and waits until they are answered: what was sent before is then taken.
struct Director<'a> {
    publisher: &'a TrackerPublisher,
    answers: TakeListener,
    session: u32,
    sequence: u64,
    wait: Duration,
    token: Token,
}

impl<'a> Director<'a> {
    fn new(
        arguments: &Arguments,
        node: &Node,
        publisher: &'a TrackerPublisher,
        session: u32,
    ) -> anyhow::Result<Self> {
        Ok(Self {
            publisher,
            answers: TakeListener::open(node)?,
            session,
            sequence: 0,
            wait: Duration::try_from_secs_f64(arguments.wait)?,
            token: token_of_daemon(arguments.iceoryx2.as_deref())?.unwrap_or(Token::NONE),
        })
    }

    /// Begins: with a take if one is wanted. Fails where no daemon answers.
    fn begin(&mut self, arguments: &Arguments) -> anyhow::Result<()> {
        self.say(Command::Ask)?;
        if arguments.take {
            self.say(Command::Start)?;
        }
        Ok(())
    }

    /// Ends as it began. Without a take of ours it does not matter whether somebody listens.
    fn end(&mut self, arguments: &Arguments) -> anyhow::Result<()> {
        if arguments.take {
            return self.say(Command::Stop);
        }
        if let Err(error) = self.say(Command::Ask) {
            eprintln!("{error:#}");
        }
        Ok(())
    }

    /// Says it until it is answered: who hears may be a tunnel that leads nowhere yet, or that loses
    /// it. The daemon obeys the same command once.
    fn say(&mut self, command: Command) -> anyhow::Result<()> {
        self.sequence += 1;
        let (session, sequence, begun) = (self.session, self.sequence, Instant::now());
        let asked_ns = now_ns();
        let mut heard: Option<Instant> = None;
        while begun.elapsed() < self.wait {
            if heard.is_none_or(|at| at.elapsed() > REPEAT) {
                let subscribers = self
                    .publisher
                    .control(command, session, sequence, asked_ns, self.token)?;
                heard = (subscribers > 0).then(Instant::now);
            }
            while let Some(answer) = self.answers.next()? {
                if (answer.control_session, answer.control_sequence) == (session, sequence) {
                    return Ok(());
                }
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        bail!("no answer to {command:?}: is `enact capture` there?")
    }
}

fn now_ns() -> i64 {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    since.map_or(0, |since| since.as_nanos() as i64)
}

/// Of its own for every start.
fn session() -> u32 {
    (now_ns() / 1000) as u32 ^ std::process::id()
}

/// Waits for that many seconds after `begun`.
fn wait_until(begun: Instant, due_s: f64) {
    let due = Duration::try_from_secs_f64(due_s).unwrap_or_default();
    std::thread::sleep(due.saturating_sub(begun.elapsed()));
}

fn read(path: &std::path::Path) -> anyhow::Result<String> {
    std::fs::read_to_string(path).with_context(|| path.display().to_string())
}
