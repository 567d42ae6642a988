//! Health and metrics by HTTP/1: two pages, one request per connection.
//!
//! | path | answer |
//! |---|---|
//! | `/health` | 200 `ready`, or 503 `draining` once the daemon is told to end |
//! | `/metrics` | 200, the text that Prometheus reads |
//!
//! Anything else is refused: another path with 404, another method with 405, a malformed request
//! with 400, more than 8 KiB of head with 431. A peer has two seconds for its request; at most 32
//! connections are open at a time, further ones wait to be accepted.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Semaphore, watch};

use super::event::Status;
use super::metrics::Metrics;

const HEAD_BYTES: usize = 8 << 10;
const HEADERS: usize = 64;
const PATIENCE: Duration = Duration::from_secs(2);
const CONNECTIONS: usize = 32;

/// The contents of the pages.
pub(super) struct Pages {
    pub(super) metrics: Arc<Metrics>,
    pub(super) status: watch::Receiver<Status>,
    /// Set once the daemon is told to end.
    pub(super) stop: Arc<AtomicBool>,
}

/// Listens on an address and answers in a task of its own; returns the bound address.
pub(super) async fn serve(address: SocketAddr, pages: Pages) -> std::io::Result<SocketAddr> {
    let listener = TcpListener::bind(address).await?;
    let address = listener.local_addr()?;
    tokio::spawn(async move {
        let pages = Arc::new(pages);
        let places = Arc::new(Semaphore::new(CONNECTIONS));
        loop {
            let Ok(place) = Arc::clone(&places).acquire_owned().await else {
                return;
            };
            match listener.accept().await {
                Ok((stream, _)) => {
                    let pages = Arc::clone(&pages);
                    tokio::spawn(async move {
                        let answer = tokio::time::timeout(PATIENCE, pages.answer(stream)).await;
                        if !matches!(answer, Ok(Ok(()))) {
                            pages.metrics.requests_refused.add();
                        }
                        drop(place);
                    });
                }
                // A temporary error, such as too many open files.
                Err(error) => {
                    tracing::warn!(%error, "a connection was not accepted");
                    tokio::time::sleep(Duration::from_millis(100)).await;
                }
            }
        }
    });
    Ok(address)
}

/// The reply to a request.
struct Reply {
    status: &'static str,
    body: String,
}

impl Pages {
    async fn answer(&self, mut stream: TcpStream) -> std::io::Result<()> {
        let mut head = Vec::new();
        let reply = loop {
            if let Some(reply) = self.reply(&head) {
                break reply;
            }
            let mut part = [0; 1024];
            match stream.read(&mut part).await? {
                0 => break refusal("400 Bad Request"),
                length => head.extend_from_slice(&part[..length]),
            }
        };
        if !reply.status.starts_with("200") && !reply.status.starts_with("503") {
            self.metrics.requests_refused.add();
        }
        let Reply { status, body } = reply;
        let length = body.len();
        let head = format!(
            "HTTP/1.1 {status}\r\nContent-Type: text/plain; version=0.0.4; charset=utf-8\r\n\
             Content-Length: {length}\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n"
        );
        stream.write_all(head.as_bytes()).await?;
        stream.write_all(body.as_bytes()).await?;
        stream.shutdown().await
    }

    /// The reply to a request; `None` while its head is incomplete.
    fn reply(&self, head: &[u8]) -> Option<Reply> {
        let mut headers = [httparse::EMPTY_HEADER; HEADERS];
        let mut request = httparse::Request::new(&mut headers);
        match request.parse(head) {
            Ok(httparse::Status::Complete(_)) => {}
            Ok(httparse::Status::Partial) if head.len() < HEAD_BYTES => return None,
            Ok(httparse::Status::Partial) | Err(httparse::Error::TooManyHeaders) => {
                return Some(refusal("431 Request Header Fields Too Large"));
            }
            Err(_) => return Some(refusal("400 Bad Request")),
        }
        let path = request.path.unwrap_or_default();
        let path = path.split('?').next().unwrap_or_default();
        let is_get = request.method == Some("GET");
        Some(match path {
            "/health" | "/metrics" if !is_get => refusal("405 Method Not Allowed"),
            "/health" if self.stop.load(Ordering::Relaxed) => Reply {
                status: "503 Service Unavailable",
                body: "draining\n".to_owned(),
            },
            "/health" => Reply {
                status: "200 OK",
                body: "ready\n".to_owned(),
            },
            "/metrics" => Reply {
                status: "200 OK",
                body: self.metrics.text(&self.status.borrow()),
            },
            _ => refusal("404 Not Found"),
        })
    }
}

fn refusal(status: &'static str) -> Reply {
    Reply {
        status,
        body: format!("{status}\n"),
    }
}
