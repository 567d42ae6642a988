//! Publishing recordings and loads as live takes.

mod fault;
mod load;
mod play;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use clap::Parser;
use enact::ingest::live::{Command, Node, TakeListener};
use enact::write::TrackerPublisher;

use fault::Faults;
pub use play::Sent;

/// Publish a recording as a live take.
#[derive(Parser)]
pub struct Arguments {
    /// The recording, with a scene attached
    #[arg(required_unless_present = "load")]
    recording: Option<PathBuf>,
    /// Scene file [default: the one attached]
    #[arg(long)]
    scene: Option<PathBuf>,
    /// In place of a recording: this many trackers, `t1`, `t2`, …, each on a circle
    #[arg(long, conflicts_with_all = ["recording", "scene"])]
    load: Option<usize>,
    /// Names of the trackers of a load
    #[arg(long, value_delimiter = ',')]
    names: Vec<String>,
    /// Samples per second of every tracker of a load
    #[arg(long, default_value_t = 1000.0)]
    rate_hz: f64,
    /// Length of a load
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// 1 is real time, 0 as fast as it goes
    #[arg(long, default_value_t = 1.0)]
    rate: f64,
    /// Start a take before and stop it after
    #[arg(long)]
    take: bool,
    /// Move the stamps of a recording to now
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
}

/// Publishes what is asked for; what was sent.
pub fn run(arguments: &Arguments) -> anyhow::Result<Sent> {
    let node = Node::join("enact tracker", arguments.iceoryx2.as_deref())?;
    match (arguments.load, &arguments.recording) {
        (Some(trackers), _) => load::run(arguments, &node, trackers),
        (None, Some(recording)) => play::run(arguments, &node, recording),
        (None, None) => bail!("expected a recording or --load"),
    }
}

/// Sends commands, and waits until they are answered: what was sent before is then taken.
struct Director<'a> {
    publisher: &'a TrackerPublisher,
    answers: TakeListener,
    session: u32,
    sequence: u64,
    wait: Duration,
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
        })
    }

    /// Begins: with a take if one is wanted. Fails where no daemon answers.
    fn begin(&mut self, arguments: &Arguments) -> anyhow::Result<()> {
        self.say(if arguments.take {
            Command::Start
        } else {
            Command::Ask
        })
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

    /// Repeats until it is answered: nobody hears what was said before they subscribed.
    fn say(&mut self, command: Command) -> anyhow::Result<()> {
        self.sequence += 1;
        let (session, sequence, begun) = (self.session, self.sequence, Instant::now());
        let mut is_heard = false;
        while begun.elapsed() < self.wait {
            if !is_heard {
                let heard = self
                    .publisher
                    .control(command, session, sequence, now_ns())?;
                is_heard = heard > 0;
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
