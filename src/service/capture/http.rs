//! The operator's page, health and metrics by HTTP/1, one request per connection.
//!
//! | path | answer |
//! |---|---|
//! | `/` | the operator's page, which needs nothing but this server |
//! | `/state` | 200, what the page shows, as JSON |
//! | `POST /take` | 202 for an order in JSON that is handed on, 409 and why for one that cannot be obeyed |
//! | `/health` | 200 `ready`; 503 and what keeps takes from being written, or `draining` once the daemon is told to end |
//! | `/picture/7.svg` | 200, the motion of take 7, if it is one of the last and has one |
//! | `/metrics` | 200, the text that Prometheus reads |
//!
//! Anything else is refused: another path with 404, another method with 405, a malformed request
//! with 400, a name that is none of the daemon's with 421 ([`Origins::is_known`]), more than 8 KiB of head or of
//! body with 431 or 413, an order without the daemon's token, or from a page that is not this server's own, with 403
//! ([`Director::knows`], [`Origins::may_direct`]). A peer has two seconds for its request; where
//! more than there are [`GatePlaces`] have not sent theirs, the oldest is closed.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde_json::json;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::TcpListener;
use tokio::sync::{Semaphore, watch};

use super::director::{Director, DirectorOrder};
use super::event::Status;
use super::gate::{Gate, GatePlaces, Waiting};
use super::metrics::Metrics;
use super::origin::Origins;

pub(super) const HEAD_BYTES: usize = 8 << 10;
pub(super) const BODY_BYTES: usize = 8 << 10;
const HEADERS: usize = 64;
const SHORT_BYTES: usize = 4 << 10;
const PATIENCE: Duration = Duration::from_secs(2);

const PAGE: &str = include_str!("operator.html");

/// What a browser may do with the page: nothing but what is in it, and talk to this server.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; \
                      connect-src 'self'; img-src 'self' data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// What it may do with a picture: show it.
const PICTURE_POLICY: &str =
    "default-src 'none'; style-src 'unsafe-inline'; frame-ancestors 'none'";

/// The contents of the pages.
pub(super) struct Pages {
    pub(super) metrics: Arc<Metrics>,
    pub(super) status: watch::Receiver<Status>,
    /// Set once the daemon is told to end.
    pub(super) stop: Arc<AtomicBool>,
    pub(super) director: Director,
    pub(super) origins: Origins,
}

/// Listens on an address and answers in tasks of its own; returns the bound address.
pub(super) async fn serve(
    address: SocketAddr,
    places: GatePlaces,
    pages: Pages,
) -> std::io::Result<SocketAddr> {
    let listener = TcpListener::bind(address).await?;
    let address = listener.local_addr()?;
    let pages = Arc::new(pages);
    let answered = Arc::new(Semaphore::new(places.answered));
    let gate = Gate::with_spare("metrics", places.waiting, &pages.metrics);
    let serve = move |stream, waiting| {
        let (pages, answered) = (Arc::clone(&pages), Arc::clone(&answered));
        async move {
            let answer = pages.answer(stream, waiting, &answered);
            let answer = tokio::time::timeout(PATIENCE, answer).await;
            if !matches!(answer, Ok(Ok(()))) {
                pages.metrics.requests_refused.add();
            }
        }
    };
    tokio::spawn(gate.keep(listener, serve));
    Ok(address)
}

/// The reply to a request.
struct Reply {
    status: &'static str,
    kind: &'static str,
    policy: &'static str,
    body: Arc<str>,
}

impl Reply {
    fn text(status: &'static str, body: String) -> Self {
        Self {
            status,
            ..Self::ok("text/plain; version=0.0.4; charset=utf-8", body)
        }
    }

    fn ok(kind: &'static str, body: impl Into<Arc<str>>) -> Self {
        Self {
            status: "200 OK",
            kind,
            policy: POLICY,
            body: body.into(),
        }
    }
}

impl Pages {
    /// Takes one request and sends the reply.
    pub(super) async fn answer(
        &self,
        mut stream: impl AsyncRead + AsyncWrite + Unpin,
        waiting: Waiting,
        answered: &Semaphore,
    ) -> std::io::Result<()> {
        let mut request = Vec::new();
        let reply = loop {
            if let Some(reply) = self.reply(&request) {
                break reply;
            }
            let mut part = [0; 1024];
            match stream.read(&mut part).await? {
                0 => break refusal("400 Bad Request"),
                length => request.extend_from_slice(&part[..length]),
            }
        };
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
        stream.write_all(head.as_bytes()).await?;
        stream.write_all(body.as_bytes()).await?;
        stream.shutdown().await
    }

    /// The reply to a request; `None` while it is incomplete.
    fn reply(&self, bytes: &[u8]) -> Option<Reply> {
        let mut headers = [httparse::EMPTY_HEADER; HEADERS];
        let mut request = httparse::Request::new(&mut headers);
        let head = match request.parse(bytes) {
            Ok(httparse::Status::Complete(length)) => length,
            Ok(httparse::Status::Partial) if bytes.len() < HEAD_BYTES => return None,
            Ok(httparse::Status::Partial) | Err(httparse::Error::TooManyHeaders) => {
                return Some(refusal("431 Request Header Fields Too Large"));
            }
            Err(_) => return Some(refusal("400 Bad Request")),
        };
        if !self.origins.is_known(the_header(request.headers, "host")) {
            return Some(Reply::text(
                "421 Misdirected Request",
                "421 Misdirected Request: ask for an address in numbers or for localhost, or list the name \
                 in the scene, [capture] hosts\n"
                    .to_owned(),
            ));
        }
        let path = request.path.unwrap_or_default();
        let path = path.split('?').next().unwrap_or_default();
        let is_get = request.method == Some("GET");
        Some(match path {
            "/take" if request.method == Some("POST") => {
                return self.take(request.headers, &bytes[head..]);
            }
            "/" | "/state" | "/take" | "/health" | "/metrics" if !is_get || path == "/take" => {
                refusal("405 Method Not Allowed")
            }
            "/" => Reply::ok("text/html; charset=utf-8", PAGE),
            "/state" => Reply::ok("application/json", self.state()),
            "/health" => self.health(),
            "/metrics" => Reply::text("200 OK", self.metrics.text(&self.status.borrow())),
            _ => match self.picture(path).filter(|_| is_get) {
                Some(picture) => Reply {
                    policy: PICTURE_POLICY,
                    ..Reply::ok("image/svg+xml", picture)
                },
                None => refusal("404 Not Found"),
            },
        })
    }

    fn picture(&self, path: &str) -> Option<Arc<str>> {
        let take = path.strip_prefix("/picture/")?.strip_suffix(".svg")?;
        self.metrics.history.picture(take.parse().ok()?)
    }

    fn health(&self) -> Reply {
        const BAD: &str = "503 Service Unavailable";
        if self.stop.load(Ordering::Relaxed) {
            return Reply::text(BAD, "draining\n".to_owned());
        }
        let troubles = self.metrics.health.troubles(Instant::now());
        if troubles.is_empty() {
            return Reply::text("200 OK", "ready\n".to_owned());
        }
        Reply::text(BAD, format!("{}\n", troubles.join("\n")))
    }

    /// Everything that the page shows.
    fn state(&self) -> String {
        let status = self.status.borrow();
        json!({
            "status": &*status,
            "troubles": self.metrics.health.troubles(Instant::now()),
            "events": self.director.events(),
            "takes": self.metrics.history.takes(),
            "free_bytes": self.metrics.health.free_bytes(),
        })
        .to_string()
    }

    /// The reply to an order; `None` while its body is incomplete.
    fn take(&self, headers: &[httparse::Header], body: &[u8]) -> Option<Reply> {
        let header = |name: &str| the_header(headers, name);
        let is_own = self.origins.may_direct(header("origin"), header("host"));
        if !is_own || !self.director.knows(header("authorization")) {
            return Some(Reply::text(
                "403 Forbidden",
                "this may only watch: to direct, open the link that `enact take status` prints\n"
                    .to_owned(),
            ));
        }
        let length = header("content-length").map(str::parse);
        let Some(Ok(length)) = length else {
            return Some(refusal("411 Length Required"));
        };
        if length > BODY_BYTES {
            return Some(refusal("413 Content Too Large"));
        }
        let body = body.get(..length)?;
        let order: DirectorOrder = match serde_json::from_slice(body) {
            Ok(order) => order,
            Err(error) => {
                return Some(Reply::text(
                    "400 Bad Request",
                    format!("no order: {error}\n"),
                ));
            }
        };
        Some(match self.director.order(&order) {
            Ok(()) => Reply::text("202 Accepted", "handed on\n".to_owned()),
            Err(why) => Reply::text("409 Conflict", format!("{why}\n")),
        })
    }
}

/// The value of a header; `?` where it is there twice or is no text, which is nobody's name.
fn the_header<'a>(headers: &[httparse::Header<'a>], name: &str) -> Option<&'a str> {
    let mut found = headers
        .iter()
        .filter(|header| header.name.eq_ignore_ascii_case(name));
    let first = found.next()?;
    match found.next() {
        None => Some(std::str::from_utf8(first.value).unwrap_or("?")),
        Some(_) => Some("?"),
    }
}

fn refusal(status: &'static str) -> Reply {
    Reply::text(status, format!("{status}\n"))
}
