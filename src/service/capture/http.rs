//! The operator's page, health and metrics by HTTP/1, one request per connection.
//!
//! | path | answer |
//! |---|---|
//! | `/` | the operator's page, which needs nothing but this server |
//! | `/state` | 200, what the page shows, as JSON |
//! | `POST /take` | 202 for an order in JSON that is handed on, 409 and why for one that cannot be obeyed |
//! | `/health` | 200 `ready`; 503 and what keeps takes from being written, or `draining` once the daemon is told to end |
//! | `/picture/7.svg` | 200, the motion of take 7, if it is one of the last and has one |
//! | `/motion/7.glb` | 200, the same as binary glTF, with what was acted, to be played |
//! | `/metrics` | 200, the text that Prometheus reads |
//! | `/act` | 200, the acting page, where it is served ([`acting`](super::acting)); `/act/scene.glb` is its scene |
//! | `/act/socket` | 101, its WebSocket, for a page of this server's own |
//!
//! Where other devices are served by HTTPS there is only what acting needs: `/act` and `/motion`.
//!
//! Anything else is refused: another path with 404, another method with 405, a malformed request
//! with 400, a name that is none of the daemon's with 421 ([`Origins::is_known`]), more than 8 KiB of head or of
//! body with 431 or 413, an order without the daemon's token, or from a page that is not this server's own, with 403
//! ([`Director::knows`], [`Origins::may_direct`]). A peer has two seconds for its request, and as long for the answer, longer for a
//! long one; where more than there are [`GatePlaces`] have not sent theirs, the oldest is closed.

mod reply;
mod routes;

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::TcpListener;
use tokio::sync::{Semaphore, watch};
use tokio_rustls::TlsAcceptor;

use super::acting::{self, ActingStage, Upgraded, derive_accept_key};
use super::director::Director;
use super::event::Status;
use super::gate::{Gate, GatePlaces, Waiting};
use super::metrics::Metrics;
use super::origin::Origins;
use reply::{Reply, refusal, the_header};

pub(super) const HEAD_BYTES: usize = 8 << 10;
pub(super) const BODY_BYTES: usize = 8 << 10;
const HEADERS: usize = 64;
const SHORT_BYTES: usize = 4 << 10;
const PATIENCE: Duration = Duration::from_secs(2);

/// The slowest that an answer may be taken \[bytes/s\].
const SLOWEST: usize = 64 << 10;

/// The contents of the pages.
pub(super) struct Pages {
    pub(super) metrics: Arc<Metrics>,
    pub(super) status: watch::Receiver<Status>,
    /// Set once the daemon is told to end.
    pub(super) stop: Arc<AtomicBool>,
    pub(super) director: Director,
    pub(super) origins: Origins,
    /// The acting page, if it is served.
    pub(super) acting: Option<Arc<ActingStage>>,
    /// Whether nothing else is: for other devices.
    pub(super) is_acting_alone: bool,
}

/// Listens on an address and answers in tasks of its own, by HTTPS where there is a certificate; returns the bound address.
pub(super) async fn serve(
    address: SocketAddr,
    places: GatePlaces,
    pages: Pages,
    acceptor: Option<TlsAcceptor>,
) -> std::io::Result<SocketAddr> {
    let listener = TcpListener::bind(address).await?;
    let address = listener.local_addr()?;
    let pages = Arc::new(pages);
    let answered = Arc::new(Semaphore::new(places.answered));
    let gate = match &acceptor {
        Some(_) => Gate::new("acting", places.waiting, &pages.metrics),
        None => Gate::with_spare("metrics", places.waiting, &pages.metrics),
    };
    let serve = move |stream, waiting| {
        let (pages, answered) = (Arc::clone(&pages), Arc::clone(&answered));
        let acceptor = acceptor.clone();
        async move {
            let Some(acceptor) = acceptor else {
                return pages.meet(stream, waiting, &answered).await;
            };
            // The greeting is part of what a peer has to say before it is heard.
            match tokio::time::timeout(PATIENCE, acceptor.accept(stream)).await {
                Ok(Ok(stream)) => pages.meet(stream, waiting, &answered).await,
                Ok(Err(_)) | Err(_) => pages.metrics.requests_refused.add(),
            }
        }
    };
    tokio::spawn(gate.keep(listener, serve));
    Ok(address)
}

/// What a request is for.
#[derive(Clone, Copy)]
struct RequestTarget<'a> {
    path: &'a str,
    is_get: bool,
}

/// What comes of a request.
enum Answer {
    /// A reply, and the end of the connection.
    Reply(Reply),
    /// A WebSocket: its handshake's answer, and where the request ended.
    Socket { accept: String, head: usize },
}

impl Pages {
    /// Answers a peer, to the end of its connection.
    pub(super) async fn meet<S: AsyncRead + AsyncWrite + Unpin>(
        &self,
        stream: S,
        waiting: Waiting,
        answered: &Semaphore,
    ) {
        match self.answer(stream, waiting, answered).await {
            Ok(None) => {}
            Ok(Some(upgraded)) => self.act(upgraded).await,
            Err(_) => self.metrics.requests_refused.add(),
        }
    }

    /// Takes one request and sends the reply; what is left of the connection where a WebSocket begins on it.
    async fn answer<S: AsyncRead + AsyncWrite + Unpin>(
        &self,
        mut stream: S,
        waiting: Waiting,
        answered: &Semaphore,
    ) -> std::io::Result<Option<Upgraded<S>>> {
        let mut request = Vec::new();
        let heard = tokio::time::timeout(PATIENCE, self.hear(&mut stream, &mut request)).await??;
        let (accept, head) = match heard {
            Answer::Socket { accept, head } => (accept, head),
            Answer::Reply(reply) => {
                self.send(stream, reply, waiting, answered).await?;
                return Ok(None);
            }
        };
        let answer = format!(
            "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
             Sec-WebSocket-Accept: {accept}\r\n\r\n"
        );
        tokio::time::timeout(PATIENCE, stream.write_all(answer.as_bytes())).await??;
        Ok(Some(Upgraded {
            stream,
            rest: request.split_off(head),
            waiting,
        }))
    }

    /// Talks with the acting page to the end of its connection.
    async fn act<S: AsyncRead + AsyncWrite + Unpin>(&self, upgraded: Upgraded<S>) {
        if let Some(acting) = &self.acting {
            acting::serve(acting, upgraded).await;
        }
    }

    /// Reads until there is an answer.
    async fn hear(
        &self,
        stream: &mut (impl AsyncRead + Unpin),
        request: &mut Vec<u8>,
    ) -> std::io::Result<Answer> {
        loop {
            if let Some(answer) = self.reply(request) {
                return Ok(answer);
            }
            let mut part = [0; 1024];
            match stream.read(&mut part).await? {
                0 => return Ok(Answer::Reply(refusal("400 Bad Request"))),
                length => request.extend_from_slice(&part[..length]),
            }
        }
    }

    async fn send(
        &self,
        mut stream: impl AsyncWrite + Unpin,
        reply: Reply,
        waiting: Waiting,
        answered: &Semaphore,
    ) -> std::io::Result<()> {
        // A short reply fits into the system's buffer whether the peer reads or not. Of the peers
        // that are sent long ones only so many can hold a connection.
        let _place = match reply.body.len() > SHORT_BYTES {
            true => answered.acquire().await.ok(),
            false => None,
        };
        drop(waiting);
        let is_error = reply.status.starts_with('4');
        if is_error {
            self.metrics.requests_refused.add();
        }
        let Reply {
            status,
            kind,
            policy,
            body,
        } = reply;
        let length = body.len();
        let head = format!(
            "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n\
             Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n\
             Content-Security-Policy: {policy}\r\nConnection: close\r\n\r\n"
        );
        let patience = PATIENCE + Duration::from_secs((length / SLOWEST) as u64);
        let sent = async {
            stream.write_all(head.as_bytes()).await?;
            stream.write_all(&body).await?;
            stream.shutdown().await
        };
        tokio::time::timeout(patience, sent).await?
    }

    /// The answer to a request; `None` while it is incomplete.
    fn reply(&self, bytes: &[u8]) -> Option<Answer> {
        let mut headers = [httparse::EMPTY_HEADER; HEADERS];
        let mut request = httparse::Request::new(&mut headers);
        let head = match request.parse(bytes) {
            Ok(httparse::Status::Complete(length)) => length,
            Ok(httparse::Status::Partial) if bytes.len() < HEAD_BYTES => return None,
            Ok(httparse::Status::Partial) | Err(httparse::Error::TooManyHeaders) => {
                return Some(Answer::Reply(refusal(
                    "431 Request Header Fields Too Large",
                )));
            }
            Err(_) => return Some(Answer::Reply(refusal("400 Bad Request"))),
        };
        let of = |name| the_header(request.headers, name);
        let path = request.path.unwrap_or_default();
        let path = path.split('?').next().unwrap_or_default();
        let is_get = request.method == Some("GET");
        if path == "/act/socket"
            && is_get
            && self.acting.is_some()
            && self.origins.is_known(of("host"))
        {
            return Some(match self.socket_key(request.headers) {
                Ok(key) => Answer::Socket {
                    accept: derive_accept_key(key.as_bytes()),
                    head,
                },
                Err(refused) => Answer::Reply(refused),
            });
        }
        self.page(&request, &bytes[head..], RequestTarget { path, is_get })
            .map(Answer::Reply)
    }

    /// The key of a WebSocket's handshake from a page of this server's own.
    fn socket_key<'h>(&self, headers: &[httparse::Header<'h>]) -> Result<&'h str, Reply> {
        let header = |name: &str| the_header(headers, name);
        let (origin, host) = (header("origin"), header("host"));
        if origin.is_none() || !self.origins.may_direct(origin, host) {
            return Err(refusal("403 Forbidden"));
        }
        let says = |name: &str, word: &str| {
            let mut words = header(name).unwrap_or_default().split(',');
            words.any(|said| said.trim().eq_ignore_ascii_case(word))
        };
        let is_socket = says("upgrade", "websocket")
            && says("connection", "upgrade")
            && says("sec-websocket-version", "13");
        let key = header("sec-websocket-key").filter(|_| is_socket);
        key.ok_or_else(|| refusal("400 Bad Request"))
    }
}
