//! What the operator's page and the acting page direct: the same commands, marks and labels that come over iceoryx2.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::SyncSender;
use std::time::Instant;

use serde::Deserialize;
use tokio::sync::watch;

use super::event::Status;
use super::recorder::event_names;
use super::take::now_ns;
use crate::ingest::live::{
    Arrival, Arrived, Command, ControlRecord, LabelRecord, MarkRecord, NO_TIME, PoseRecord, Token,
};
use crate::motion::Scene;

/// An order, as the page sends it.
#[derive(Debug, Deserialize)]
#[serde(tag = "command", rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum DirectorOrder {
    /// Begin a take.
    Start,
    /// End the take and estimate it.
    Stop(TakeRemarks),
    /// End the take and move it aside.
    Discard,
    /// An event happens now: this one, or the next one in order.
    Mark {
        /// Its name.
        #[serde(default)]
        event: String,
    },
}

/// What is said of a take as it ends.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TakeRemarks {
    /// Its name.
    #[serde(default)]
    pub(super) name: String,
    /// A note on it.
    #[serde(default)]
    pub(super) note: String,
    /// Its rating, 1 to 5; 0: none.
    #[serde(default)]
    pub(super) rating: u32,
}

/// When a marked event happened, as far as it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct MarkTimes {
    /// On this machine's clock \[ns since 1970\]; none: on arrival.
    pub(super) sample_ns: Option<i64>,
    /// On the clock of who says it \[ns\].
    pub(super) device_ns: Option<i64>,
}

/// A page's end of a queue to the recorder.
pub(super) struct Director {
    events: Vec<String>,
    orders: SyncSender<Arrival>,
    status: watch::Receiver<Status>,
    sequence: AtomicU64,
    token: Token,
}

impl Director {
    pub(super) fn new(
        scene: &Scene,
        orders: SyncSender<Arrival>,
        status: watch::Receiver<Status>,
        token: Token,
    ) -> Self {
        Self {
            events: event_names(scene),
            orders,
            status,
            sequence: AtomicU64::new(0),
            token,
        }
    }

    /// Whether a request may direct: its header `Authorization` is `Bearer` and the daemon's token.
    pub(super) fn knows(&self, authorization: Option<&str>) -> bool {
        let given = authorization.and_then(|given| given.strip_prefix("Bearer "));
        let token = given.and_then(Token::of_text);
        token.is_some_and(|token| self.token.lets_in(&token.bytes()))
    }

    /// Names of the scene's events.
    pub(super) fn events(&self) -> &[String] {
        &self.events
    }

    /// Hands an order on. Fails, in words, where it cannot be obeyed.
    pub(super) fn order(&self, order: &DirectorOrder) -> Result<(), String> {
        let runs = self.status.borrow().take.is_some();
        if runs == matches!(order, DirectorOrder::Start) {
            let why = if runs { "a take runs" } else { "no take runs" };
            return Err(why.to_owned());
        }
        match order {
            DirectorOrder::Start => self.command(Command::Start),
            DirectorOrder::Discard => self.command(Command::Discard),
            DirectorOrder::Stop(TakeRemarks { name, note, rating }) => {
                if *rating > 5 {
                    return Err(format!("the rating is {rating}, expected 1 to 5"));
                }
                let label = LabelRecord::new(0, now_ns(), name, note, *rating);
                self.send(Arrived::Label(Box::new(label)))?;
                self.command(Command::Stop)
            }
            DirectorOrder::Mark { event } => self.mark(event, MarkTimes::default()),
        }
    }

    /// Hands a mark on, with what is known of its time. Fails, in words, where no take runs or the scene has no such
    /// event.
    pub(super) fn mark(&self, event: &str, times: MarkTimes) -> Result<(), String> {
        if self.status.borrow().take.is_none() {
            return Err("no take runs".to_owned());
        }
        if !event.is_empty() && !self.events.iter().any(|known| known == event) {
            let known = self.events.join(", ");
            return Err(format!(
                "no event {event:?} in the scene, which has {known}"
            ));
        }
        self.send(Arrived::Mark(MarkRecord {
            sequence: self.next(),
            available_ns: now_ns(),
            sample_ns: times.sample_ns.unwrap_or(NO_TIME),
            device_ns: times.device_ns.unwrap_or(NO_TIME),
            event: MarkRecord::event_bytes(event),
            flags: 0,
            session: 0,
        }))
    }

    /// Hands a reading on, or drops it where the recorder does not keep up: the hole in its numbers is counted.
    pub(super) fn pose(&self, stream: usize, record: PoseRecord) {
        let _ = self.send(Arrived::Pose {
            stream,
            record,
            is_overflow: false,
        });
    }

    fn command(&self, command: Command) -> Result<(), String> {
        self.send(Arrived::Control(ControlRecord {
            sequence: self.next(),
            available_ns: now_ns(),
            command: command.number(),
            session: 0,
            token: self.token.bytes(),
        }))
    }

    fn next(&self) -> u64 {
        self.sequence.fetch_add(1, Ordering::Relaxed)
    }

    fn send(&self, what: Arrived) -> Result<(), String> {
        let at = Instant::now();
        let sent = self.orders.try_send(Arrival { at, what });
        sent.map_err(|_| "the recorder does not keep up".to_owned())
    }
}
