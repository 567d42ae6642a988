//! Peers without a network, for tests and fuzzing of what is behind the ports.

use std::future::Future;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, DuplexStream};
use tokio::runtime::Runtime;
use tokio::sync::{Semaphore, watch};

use super::acting::pairing::Pairing;
use super::acting::{ActingParts, ActingStage};
use super::director::Director;
use super::event::Status;
use super::gate::Gate;
use super::http::{BODY_BYTES, HEAD_BYTES, Pages};
use super::metrics::Metrics;
use super::origin::Origins;
use super::viewer::audience::Audience;
use crate::config::scene_from_toml;
use crate::ingest::live::{Arrival, Token, stream_topics};

/// What a connection holds on its way, each way.
const WAY_BYTES: usize = 1 << 10;

/// The most that is taken of a peer before it is answered by HTTP.
pub const REQUEST_BYTES: usize = HEAD_BYTES + BODY_BYTES + 4 * WAY_BYTES;

/// The most that is taken of a peer before it has become a viewer.
pub const HANDSHAKE_BYTES: usize = (64 << 10) + 4 * WAY_BYTES;

/// A viewer's request to become one, as a program says it.
pub const HANDSHAKE: &[u8] = b"GET / HTTP/1.1\r\nHost: localhost:8765\r\nUpgrade: websocket\r\n\
    Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
    Sec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n";

/// The acting page's request for its WebSocket.
pub const ACTING_HANDSHAKE: &[u8] = b"GET /act/socket HTTP/1.1\r\nHost: localhost:9464\r\n\
    Origin: http://localhost:9464\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
    Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n";

/// What who acts must know.
pub const CODE: &str = "042137";

/// A frame of a page, masked with zeros.
pub fn page_frame(opcode: u8, data: &[u8]) -> Vec<u8> {
    let mut frame = vec![0x80 | opcode, 0x80 | 126];
    let length = u16::try_from(data.len()).unwrap_or(u16::MAX);
    frame.extend(length.to_be_bytes());
    frame.extend([0; 4]);
    frame.extend(data);
    frame
}

/// What who directs these servers must know.
pub const TOKEN: &str = "000102030405060708090a0b0c0d0e0f";

/// What became of a connection.
#[derive(Debug)]
pub struct Met {
    /// What the peer was sent.
    pub sent: Vec<u8>,
    /// How much was taken of what it said.
    pub taken: usize,
    /// How many orders were handed on.
    pub orders: usize,
}

/// Says it, as far as it is taken; how much is.
async fn say(to: &mut (impl AsyncWrite + Unpin), bytes: &[u8]) -> usize {
    let mut taken = 0;
    for part in bytes.chunks(WAY_BYTES / 2) {
        if to.write_all(part).await.is_err() {
            break;
        }
        taken += part.len();
    }
    taken
}

/// Hears the head of an answer, or what there is of it.
async fn hear_head(from: &mut (impl AsyncRead + Unpin), sent: &mut Vec<u8>) {
    let mut byte = [0];
    while !sent.ends_with(b"\r\n\r\n") && from.read_exact(&mut byte).await.is_ok() {
        sent.push(byte[0]);
    }
}

/// What comes of it; `None` where nothing has come after so many turns of all others that nothing will.
async fn unless_for_ever<T>(of: impl Future<Output = T>) -> Option<T> {
    const TURNS: usize = 1000;
    let turns = async {
        for _ in 0..TURNS {
            tokio::task::yield_now().await;
        }
    };
    tokio::select! {
        biased;
        what = of => Some(what),
        () = turns => None,
    }
}

/// A daemon's servers of a scene, without its ports.
pub struct Ports {
    runtime: Runtime,
    pages: Pages,
    answered: Semaphore,
    audience: Audience,
    orders: Receiver<Arrival>,
    gate: Arc<Gate>,
    /// Kept: without it a page is told that the daemon ends.
    _status: watch::Sender<Status>,
}

impl Ports {
    /// Those of a daemon that records a take, or none.
    pub fn new(runs: bool) -> Self {
        let text = include_str!("../../../config/pencil_tip.toml");
        let scene = scene_from_toml(text).expect("the scene that comes along");
        let token = Token::of_text(TOKEN).expect("a token");
        let metrics = Arc::new(Metrics::default());
        let status = watch::Sender::new(Status {
            take: runs.then_some(1),
            ..Status::default()
        });
        let (order_sender, orders) = sync_channel(64);
        let topics = stream_topics(&scene);
        let director = || {
            let orders = order_sender.clone();
            Director::new(&scene, orders, status.subscribe(), token)
        };
        let acting = ActingStage::new(ActingParts {
            html: b"<!doctype html>".as_slice().into(),
            pairing: Pairing::with_code(CODE.to_owned()),
            scene: &scene,
            scene_toml: text,
            topics: &topics,
            director: director(),
            status: status.subscribe(),
            metrics: Arc::clone(&metrics),
        });
        let audience = Audience::new(&scene, &topics, Origins::default(), &metrics);
        Self {
            runtime: tokio::runtime::Builder::new_current_thread()
                .enable_time()
                .build()
                .expect("a runtime"),
            gate: Gate::new("metrics", 1, &metrics),
            pages: Pages {
                acting: Some(Arc::new(acting)),
                is_acting_alone: false,
                metrics,
                status: status.subscribe(),
                stop: Arc::new(AtomicBool::new(false)),
                director: director(),
                origins: Origins::default(),
            },
            answered: Semaphore::new(1),
            audience,
            orders,
            _status: status,
        }
    }

    /// A peer at the page's port that says this and then no more.
    pub fn asks(&self, bytes: &[u8]) -> Met {
        self.acts(bytes, &[])
    }

    /// A peer at the page's port that says the first, then once it is answered the second and then no more.
    pub fn acts(&self, first: &[u8], then: &[u8]) -> Met {
        let (ours, theirs) = tokio::io::duplex(WAY_BYTES);
        let waiting = self.gate.alone();
        let serve = self.pages.meet(ours, waiting, &self.answered);
        self.meets(first, then, serve, theirs)
    }

    /// A peer at the viewers' port that says the first, then once it is answered the second and then no more, while
    /// messages are shown.
    pub fn watches(&self, handshake: &[u8], then: &[u8]) -> Met {
        let (ours, theirs) = tokio::io::duplex(WAY_BYTES);
        let is_over = AtomicBool::new(false);
        let serve = async {
            self.audience.serve(ours).await;
            is_over.store(true, Ordering::Relaxed);
        };
        let show = async {
            while !is_over.load(Ordering::Relaxed) {
                self.audience.show(vec![7; 300]);
                tokio::task::yield_now().await;
            }
        };
        let both = async {
            tokio::join!(serve, show);
        };
        self.meets(handshake, then, both, theirs)
    }

    /// Whether nobody watches, and no place is taken.
    pub fn is_empty(&self) -> bool {
        self.audience.is_empty()
    }

    /// How much is taken of a viewer that says this again and again, and after the greeting reads nothing.
    pub fn floods(&self, bytes: &[u8], most: usize) -> usize {
        self.runtime.block_on(async {
            let (ours, mut theirs) = tokio::io::duplex(WAY_BYTES);
            let mut serve = std::pin::pin!(self.audience.serve(ours));
            let (mut taken, mut at) = (0, 0);
            let flood = async {
                theirs.write_all(HANDSHAKE).await.expect("taken");
                let mut part = [0; WAY_BYTES];
                while let Some(Ok(1..)) = unless_for_ever(theirs.read(&mut part)).await {}
                while taken < most {
                    let written = unless_for_ever(theirs.write(&bytes[at..])).await;
                    let Some(Ok(length)) = written else {
                        return;
                    };
                    taken += length;
                    at = (at + length) % bytes.len();
                }
            };
            let has_gone = tokio::select! {
                () = &mut serve => true,
                () = flood => false,
            };
            drop(theirs);
            if !has_gone {
                serve.await;
            }
            taken
        })
    }

    /// Runs both sides to their ends, which a server reaches when its peer has no more to say.
    fn meets(
        &self,
        first: &[u8],
        then: &[u8],
        serve: impl Future<Output = ()>,
        mut peer: DuplexStream,
    ) -> Met {
        let (mut sent, mut taken) = (Vec::new(), 0);
        let peer = async {
            if !then.is_empty() {
                taken += say(&mut peer, first).await;
                hear_head(&mut peer, &mut sent).await;
            }
            let (mut from, mut to) = tokio::io::split(peer);
            let rest = if then.is_empty() { first } else { then };
            let said = async {
                taken += say(&mut to, rest).await;
                let _ = to.shutdown().await;
            };
            let heard = from.read_to_end(&mut sent);
            let _ = tokio::join!(said, heard);
        };
        let both = async { tokio::join!(serve, peer) };
        let ended = self
            .runtime
            .block_on(async { tokio::time::timeout(Duration::from_secs(60), both).await });
        assert!(ended.is_ok(), "the server waits for a peer that has gone");
        let orders = self.orders.try_iter().count();
        Met {
            sent,
            taken,
            orders,
        }
    }
}

#[cfg(test)]
mod tests;
