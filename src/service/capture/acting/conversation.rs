//! A page's connection, from the code to its end.

use std::sync::Arc;
use std::time::{Duration, Instant};

use futures_util::{SinkExt, StreamExt};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::task::JoinHandle;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::protocol::CloseFrame;
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;
use tokio_tungstenite::tungstenite::{Bytes, Message};

use super::super::director::MarkTimes;
use super::super::gate::Waiting;
use super::super::presence::Presence;
use super::super::take::now_ns;
use super::allowance::Allowance;
use super::calibration::CalibrationWish;
use super::device_clock::DeviceClock;
use super::greeting::{refusal_text, state_text};
use super::message::{PageReadings, PageText};
use super::stage::{ActingStage, READINGS_PER_SECOND, TEXTS_PER_SECOND};
use crate::ingest::live::{NO_TIME, PoseRecord, Token};

/// How long a page may take to say the code.
const PATIENCE: Duration = Duration::from_secs(2);

/// How long it may take for one message.
const STALL: Duration = Duration::from_secs(10);

/// Interval of pings; a page that has said nothing since the one before the last has gone.
const PING: Duration = Duration::from_secs(3);

/// A stream on which something came within so long is another tracker's \[s\].
const RECENT_S: f64 = 1.0;

/// How much of what was held up may come at once \[s\].
const HELD_UP_S: f64 = 2.0;

/// A page that was let in.
pub(super) struct PageConversation<'a, S> {
    acting: &'a ActingStage,
    socket: WebSocketStream<S>,
    key: Token,
    session: u32,
    clock: DeviceClock,
    readings: Allowance,
    texts: Allowance,
    /// A step of a calibration that is being made: what the page is told of it.
    calibrating: Option<JoinHandle<String>>,
}

/// It is over, with what the page is told of it.
struct PageOver(&'static str);

impl<'a, S: AsyncRead + AsyncWrite + Unpin> PageConversation<'a, S> {
    /// Lets a page in that knows the code, and listens to it until it goes or is sent away.
    pub(super) async fn hold(
        acting: &'a ActingStage,
        mut socket: WebSocketStream<S>,
        waiting: Waiting,
    ) {
        let first = tokio::time::timeout(PATIENCE, socket.next()).await;
        let key = match first {
            Ok(Some(Ok(Message::Text(text)))) => let_in(acting, &text),
            Ok(Some(Ok(_))) => Err("the first message says the code".to_owned()),
            Ok(Some(Err(_)) | None) | Err(_) => return acting.metrics.requests_refused.add(),
        };
        let place = acting.places.try_acquire();
        let key = key.and_then(|key| match &place {
            Ok(_) => Ok(key),
            Err(_) => Err("as many pages act as may: close one".to_owned()),
        });
        let key = match key {
            Ok(key) => key,
            Err(why) => {
                acting.metrics.requests_refused.add();
                let told = async {
                    let _ = socket.send(Message::text(refusal_text(&why))).await;
                    let _ = socket.close(None).await;
                };
                let _ = tokio::time::timeout(PATIENCE, told).await;
                return;
            }
        };
        drop(waiting);
        let now = Instant::now();
        let mut page = Self {
            acting,
            socket,
            key,
            session: acting.session(),
            clock: DeviceClock::default(),
            readings: Allowance::new(READINGS_PER_SECOND, HELD_UP_S * READINGS_PER_SECOND, now),
            texts: Allowance::new(TEXTS_PER_SECOND, HELD_UP_S * TEXTS_PER_SECOND, now),
            calibrating: None,
        };
        let over = page.run().await;
        acting.claims.leave(page.session);
        if let Err(PageOver(why)) = over {
            let close = CloseFrame {
                code: CloseCode::Policy,
                reason: why.into(),
            };
            let _ = tokio::time::timeout(PATIENCE, page.socket.close(Some(close))).await;
        }
    }

    async fn run(&mut self) -> Result<(), PageOver> {
        let mut status = self.acting.status.clone();
        let mut takes = self.acting.metrics.history.changes();
        self.send(self.acting.greeting.text(&self.key)).await?;
        self.say_state().await?;
        let mut pings = tokio::time::interval(PING);
        let mut unanswered = 0;
        loop {
            tokio::select! {
                received = self.socket.next() => {
                    unanswered = 0;
                    let refused = match received {
                        Some(Ok(Message::Binary(bytes))) => self.readings(&bytes)?,
                        Some(Ok(Message::Text(text))) => self.text(&text)?,
                        // The pong goes out before more is read.
                        Some(Ok(Message::Ping(_))) => {
                            self.count_text()?;
                            self.flush().await?;
                            None
                        }
                        Some(Ok(Message::Close(_)) | Err(_)) | None => return Ok(()),
                        Some(Ok(_)) => {
                            self.count_text()?;
                            None
                        }
                    };
                    if let Some(why) = refused {
                        self.send(refusal_text(&why)).await?;
                    }
                }
                // Closed once the recorder has ended.
                changed = status.changed() => {
                    if changed.is_err() {
                        return Err(PageOver("the daemon ends"));
                    }
                    self.say_state().await?;
                }
                Ok(()) = takes.changed() => self.say_state().await?,
                calibrated = ended(&mut self.calibrating) => {
                    self.send(calibrated).await?;
                }
                _ = pings.tick() => {
                    unanswered += 1;
                    if unanswered > 2 {
                        return Err(PageOver("no ping was answered"));
                    }
                    self.sent(Message::Ping(Bytes::new())).await?;
                }
            }
        }
    }

    /// Takes readings in; what is refused, in words.
    fn readings(&mut self, bytes: &[u8]) -> Result<Option<String>, PageOver> {
        let read = match PageReadings::read(bytes) {
            Ok(read) => read,
            Err(error) => return self.count_text().map(|()| Some(error.to_string())),
        };
        if !self.readings.take(read.records.len(), Instant::now()) {
            return Err(PageOver("more readings than a tracker sends"));
        }
        let now = Instant::now();
        if !self.acting.claims.read(read.stream, self.session, now) {
            self.count_text()?;
            return Ok(Some(
                "this page is not the tracker of that stream".to_owned(),
            ));
        }
        let receipt_ns = now_ns();
        for record in read.records {
            if record.device_ns != NO_TIME {
                self.clock.arrived(record.device_ns, receipt_ns);
            }
            let record = PoseRecord {
                available_ns: receipt_ns,
                sample_ns: NO_TIME,
                session: self.session,
                ..record
            };
            self.acting.director.pose(read.stream, record);
        }
        Ok(None)
    }

    /// Does what a text says; what is refused, in words.
    fn text(&mut self, text: &str) -> Result<Option<String>, PageOver> {
        self.count_text()?;
        let said = match PageText::read(text) {
            Ok(said) => said,
            Err(error) => return Ok(Some(error.to_string())),
        };
        let done = match said {
            PageText::Act { stream } => self.act(stream),
            PageText::Mark { event, device_ns } => {
                let times = MarkTimes {
                    sample_ns: self.clock.receipt_ns(device_ns),
                    device_ns: Some(device_ns),
                };
                self.acting.director.mark(&event, times)
            }
            PageText::Calibrate(wish) => self.calibrate(wish),
            said => match said.order() {
                Some(order) => self.acting.director.order(&order),
                None => Err("this page was let in already".to_owned()),
            },
        };
        Ok(done.err())
    }

    fn act(&self, stream: usize) -> Result<(), String> {
        let seen_s = {
            let status = self.acting.status.borrow();
            let tracker = status.trackers.get(stream);
            let tracker = tracker.filter(|tracker| tracker.state == Presence::Sending);
            tracker.and_then(|tracker| tracker.seen_s)
        };
        let seen_s = seen_s.filter(|seen_s| *seen_s < RECENT_S);
        let seen = seen_s.map(Duration::from_secs_f64);
        let claims = &self.acting.claims;
        claims.take(stream, self.key, self.session, seen, Instant::now())
    }

    /// Makes a step of a calibration beside everything else.
    fn calibrate(&mut self, wish: CalibrationWish) -> Result<(), String> {
        if self.calibrating.is_some() {
            return Err("a calibration is being made".to_owned());
        }
        let history = &self.acting.metrics.history;
        let recordings = wish.takes.iter().map(|take| {
            let recording = history.recording(*take);
            recording.ok_or_else(|| format!("take {take} is none of the last ones that have ended"))
        });
        let recordings = recordings.collect::<Result<Vec<_>, _>>()?;
        let calibrations = Arc::clone(&self.acting.calibrations);
        let make = move || match calibrations.make(&wish, recordings) {
            Ok(made) => made,
            Err(why) => refusal_text(&why),
        };
        self.calibrating = Some(tokio::task::spawn_blocking(make));
        Ok(())
    }

    fn count_text(&mut self) -> Result<(), PageOver> {
        match self.texts.take(1, Instant::now()) {
            true => Ok(()),
            false => Err(PageOver("more messages than a page sends")),
        }
    }

    async fn say_state(&mut self) -> Result<(), PageOver> {
        let metrics = &self.acting.metrics;
        let troubles = metrics.health.troubles(Instant::now());
        let takes = metrics.history.takes();
        let text = state_text(&self.acting.status.borrow(), &troubles, &takes);
        self.send(text).await
    }

    async fn send(&mut self, text: String) -> Result<(), PageOver> {
        self.sent(Message::text(text)).await
    }

    async fn sent(&mut self, message: Message) -> Result<(), PageOver> {
        let sent = tokio::time::timeout(STALL, self.socket.send(message)).await;
        taken(sent)
    }

    async fn flush(&mut self) -> Result<(), PageOver> {
        let sent = tokio::time::timeout(STALL, self.socket.flush()).await;
        taken(sent)
    }
}

/// What came of what is being made; never, where nothing is.
async fn ended(calibrating: &mut Option<JoinHandle<String>>) -> String {
    let Some(made) = calibrating else {
        return std::future::pending().await;
    };
    let made = made.await;
    *calibrating = None;
    made.unwrap_or_else(|_| refusal_text("the calibration was not finished"))
}

/// The key of a page whose first message lets it in; else why it does not, in words.
fn let_in(acting: &ActingStage, text: &str) -> Result<Token, String> {
    let paired = match PageText::read(text) {
        Ok(PageText::Pair { code }) => acting.pairing.pair(&code, Instant::now()),
        Ok(PageText::Resume { key }) => acting.pairing.resume(&key),
        Ok(_) => return Err("the first message says the code".to_owned()),
        Err(error) => return Err(error.to_string()),
    };
    paired.map_err(|error| error.to_string())
}

/// What was sent is taken, or it is over.
fn taken<T, E, F>(sent: Result<Result<T, E>, F>) -> Result<(), PageOver> {
    match sent {
        Ok(Ok(_)) => Ok(()),
        Ok(Err(_)) => Err(PageOver("the connection broke")),
        Err(_) => Err(PageOver("this page does not read")),
    }
}
