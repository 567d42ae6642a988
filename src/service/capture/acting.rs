//! The acting page: a page in a browser that is a tracker.
//!
//! `--acting` serves it at `/act` of the HTTP port. It asks for one WebSocket, `/act/socket`, and says on it first the
//! six digits that the daemon printed ([`pairing`]). Its readings, marks and orders then go to the recorder through a
//! queue of their own, as those of other trackers and of the operator's page do ([`message`]).
//!
//! What a page may do to a take that runs is what a tracker may: nothing before it has said the code, and then as much
//! as [`READINGS_PER_SECOND`] and [`TEXTS_PER_SECOND`] allow; who sends more is sent away. One page at a time is the
//! tracker of a stream, and none of a stream on which a tracker sends already ([`claims`]). A page that answers no
//! ping is sent away, and what it was the tracker of is silent meanwhile, as any tracker.

mod allowance;
mod claims;
mod conversation;
mod device_clock;
mod greeting;
mod message;
pub(super) mod page;
pub(super) mod pairing;

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use tokio::io::{AsyncRead, AsyncWrite};
use tokio::sync::{Semaphore, watch};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::protocol::{Role, WebSocketConfig};

use super::director::Director;
use super::event::Status;
use super::gate::Waiting;
use super::metrics::Metrics;
use crate::ingest::live::{StreamTopic, Token};
use crate::motion::Scene;
use claims::Claims;
use conversation::Conversation;
use greeting::Greeting;
use message::MESSAGE_BYTES;
use pairing::Pairing;

pub(super) use tokio_tungstenite::tungstenite::handshake::derive_accept_key;

/// Pages that act at a time.
const PAGES: usize = 4;

/// Readings that a page may send: four trackers of 250 Hz.
const READINGS_PER_SECOND: f64 = 1000.0;

/// Texts that it may send.
const TEXTS_PER_SECOND: f64 = 20.0;

/// What the acting page is served with.
pub(super) struct Acting {
    /// The page.
    pub(super) html: Arc<[u8]>,
    /// The scene as binary glTF, each body at the origin.
    pub(super) scene: Arc<[u8]>,
    greeting: Greeting,
    pairing: Pairing,
    claims: Claims,
    director: Director,
    status: watch::Receiver<Status>,
    metrics: Arc<Metrics>,
    places: Arc<Semaphore>,
    sessions: AtomicU32,
}

/// What the parts of it are made of.
pub(super) struct ActingParts<'a> {
    /// The page.
    pub(super) html: Arc<[u8]>,
    pub(super) pairing: Pairing,
    pub(super) scene: &'a Scene,
    pub(super) topics: &'a [StreamTopic],
    /// With a queue of its own.
    pub(super) director: Director,
    pub(super) status: watch::Receiver<Status>,
    pub(super) metrics: Arc<Metrics>,
}

/// A connection on which a WebSocket begins.
pub(super) struct Upgraded<S> {
    pub(super) stream: S,
    /// What came after the request.
    pub(super) rest: Vec<u8>,
    pub(super) waiting: Waiting,
}

impl Acting {
    pub(super) fn new(parts: ActingParts) -> Self {
        // Any beginning that another start of the daemon is unlikely to have.
        let first = Token::make().map_or([0; 16], |token| token.bytes());
        Self {
            html: parts.html,
            scene: greeting::scene_glb(parts.scene).into(),
            greeting: Greeting::new(parts.scene, parts.topics, parts.director.events()),
            pairing: parts.pairing,
            claims: Claims::new(parts.topics.len()),
            director: parts.director,
            status: parts.status,
            metrics: parts.metrics,
            places: Arc::new(Semaphore::new(PAGES)),
            sessions: AtomicU32::new(u32::from_le_bytes([first[0], first[1], first[2], 0])),
        }
    }

    /// Serves a page to the end of its connection.
    pub(super) async fn serve<S>(&self, upgraded: Upgraded<S>)
    where
        S: AsyncRead + AsyncWrite + Unpin,
    {
        let config = WebSocketConfig::default()
            .read_buffer_size(8 << 10)
            .write_buffer_size(0)
            .max_frame_size(Some(MESSAGE_BYTES))
            .max_message_size(Some(MESSAGE_BYTES));
        let Upgraded {
            stream,
            rest,
            waiting,
        } = upgraded;
        let socket =
            WebSocketStream::from_partially_read(stream, rest, Role::Server, Some(config)).await;
        Conversation::hold(self, socket, waiting).await;
    }

    /// The six digits that who acts must know.
    pub(super) fn code(&self) -> &str {
        self.pairing.code()
    }

    /// A number that differs for every connection.
    fn session(&self) -> u32 {
        self.sessions.fetch_add(1, Ordering::Relaxed)
    }
}
