//! The protocol `foxglove.sdk.v1` over WebSockets, for reading alone.
//!
//! Of the [specification](https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md) it has
//! `serverInfo` without capabilities, `advertise`, `status`, `removeStatus`, `subscribe`,
//! `unsubscribe` and message data. Whatever else a viewer sends is not looked at. A viewer must
//! take what it is sent within [`STALL`] and answer pings.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use serde::Deserialize;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{Semaphore, broadcast};
use tokio::time::error::Elapsed;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::handshake::server::{ErrorResponse, Request, Response};
use tokio_tungstenite::tungstenite::http::{HeaderValue, StatusCode};
use tokio_tungstenite::tungstenite::protocol::WebSocketConfig;
use tokio_tungstenite::tungstenite::{Bytes, Message};

use super::super::gate::{Gate, Waiting};
use super::super::origin::Origins;
use super::hub::{Hub, Sent};

/// The protocol.
const PROTOCOL: &str = "foxglove.sdk.v1";

/// How long a handshake may take.
const PATIENCE: Duration = Duration::from_secs(2);

/// How long a viewer may take for one message.
const STALL: Duration = Duration::from_secs(10);

/// Interval of pings; a viewer that has answered none of two when the third is due has gone.
const PING: Duration = Duration::from_secs(10);

/// Greatest message of a viewer: a subscription to some hundred channels.
const RECEIVED_BYTES: usize = 8 << 10;

/// The code of message data.
const DATA: u8 = 1;

/// What every connection needs.
pub(super) struct Server {
    pub(super) hub: Arc<Hub>,
    pub(super) gate: Arc<Gate>,
    pub(super) places: Arc<Semaphore>,
    pub(super) origins: Origins,
}

/// A viewer's text.
#[derive(Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
enum Received {
    Subscribe {
        subscriptions: Vec<Subscription>,
    },
    Unsubscribe {
        #[serde(rename = "subscriptionIds")]
        ids: Vec<u32>,
    },
    #[serde(other)]
    Other,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Subscription {
    id: u32,
    channel_id: u32,
}

/// A viewer.
struct Conversation<'a, S> {
    hub: &'a Hub,
    socket: WebSocketStream<S>,
    /// Numbers of subscriptions by their channels.
    subscriptions: BTreeMap<u32, u32>,
}

/// It is over: the viewer has gone, or is sent away.
struct Over;

impl Server {
    /// Serves one connection to its end.
    pub(super) async fn serve<S>(self: Arc<Self>, stream: S, waiting: Waiting)
    where
        S: AsyncRead + AsyncWrite + Unpin,
    {
        let Ok(handshake) = tokio::time::timeout(PATIENCE, self.handshake(stream)).await else {
            return self.refused("its handshake did not end");
        };
        let (socket, _place) = match handshake {
            Ok(opened) => opened,
            Err(why) => return self.refused(&why),
        };
        drop(waiting);
        self.hub.metrics.viewers.put();
        let mut conversation = Conversation {
            hub: &self.hub,
            socket,
            subscriptions: BTreeMap::new(),
        };
        let _over = conversation.run().await;
        conversation.unsubscribe_all();
        self.hub.metrics.viewers.take();
    }

    fn refused(&self, why: &str) {
        self.hub.metrics.viewers_refused.add();
        self.gate.complain("a viewer was refused", why);
    }

    /// Opens the WebSocket of a viewer that may watch, with its place.
    async fn handshake<S>(
        &self,
        stream: S,
    ) -> Result<(WebSocketStream<S>, tokio::sync::OwnedSemaphorePermit), String>
    where
        S: AsyncRead + AsyncWrite + Unpin,
    {
        let mut place = None;
        let config = WebSocketConfig::default()
            .read_buffer_size(4 << 10)
            .write_buffer_size(0)
            .max_frame_size(Some(RECEIVED_BYTES))
            .max_message_size(Some(RECEIVED_BYTES));
        // The type of a refusal is that of the library.
        #[allow(clippy::result_large_err)]
        let answer = |request: &Request, mut response: Response| {
            if let Err((status, why)) = self.may_watch(request) {
                return Err(refusal(status, why));
            }
            place = Arc::clone(&self.places).try_acquire_owned().ok();
            if place.is_none() {
                let status = StatusCode::SERVICE_UNAVAILABLE;
                return Err(refusal(status, "as many viewers as there may be are there"));
            }
            let protocol = HeaderValue::from_static(PROTOCOL);
            response
                .headers_mut()
                .insert("sec-websocket-protocol", protocol);
            Ok(response)
        };
        let opened =
            tokio_tungstenite::accept_hdr_async_with_config(stream, answer, Some(config)).await;
        match (opened, place) {
            (Ok(socket), Some(place)) => Ok((socket, place)),
            (Ok(_), None) => Err("no place".to_owned()),
            (Err(error), _) => Err(error.to_string()),
        }
    }

    fn may_watch(&self, request: &Request) -> Result<(), (StatusCode, &'static str)> {
        let header = |name: &str| request.headers().get(name).map(|value| value.to_str());
        // A value that is no text is no page that is allowed.
        let origin = header("origin").map(|origin| origin.unwrap_or("?"));
        let host = header("host").map(|host| host.unwrap_or("?"));
        let is_one = request.headers().get_all("host").iter().count() == 1;
        if !is_one || !self.origins.is_known(host) {
            let why = "ask for an address in numbers or for localhost, or list the name in the scene, [capture] hosts";
            return Err((StatusCode::MISDIRECTED_REQUEST, why));
        }
        if !self.origins.may_watch(origin) {
            let why = "this page may not watch: list it in the scene, [capture] origins";
            return Err((StatusCode::FORBIDDEN, why));
        }
        let offered = request.headers().get_all("sec-websocket-protocol").iter();
        let mut offered = offered.flat_map(|value| value.to_str().unwrap_or_default().split(','));
        if !offered.any(|protocol| protocol.trim() == PROTOCOL) {
            let why = "expected the sub-protocol foxglove.sdk.v1";
            return Err((StatusCode::BAD_REQUEST, why));
        }
        Ok(())
    }
}

#[allow(clippy::result_large_err)]
fn refusal(status: StatusCode, why: &str) -> ErrorResponse {
    let mut response = ErrorResponse::new(Some(format!("{why}\n")));
    *response.status_mut() = status;
    response
}

impl<S: AsyncRead + AsyncWrite + Unpin> Conversation<'_, S> {
    async fn run(&mut self) -> Result<(), Over> {
        let (mut ring, mut large) = self.hub.listen();
        for text in self.hub.greeting() {
            self.send(Message::text(text)).await?;
        }
        let mut pings = tokio::time::interval(PING);
        let mut unanswered = 0;
        loop {
            tokio::select! {
                received = self.socket.next() => {
                    match received {
                        Some(Ok(Message::Text(text))) => self.received(&text),
                        // The pong goes out before more is read: of one who pings and does not
                        // read, none wait here.
                        Some(Ok(Message::Ping(_))) => self.flush().await?,
                        Some(Ok(Message::Close(_)) | Err(_)) | None => return Err(Over),
                        Some(Ok(_)) => {}
                    }
                    unanswered = 0;
                }
                sent = ring.recv() => self.deliver(sent).await?,
                sent = large.recv() => self.deliver(sent).await?,
                _ = pings.tick() => {
                    unanswered += 1;
                    if unanswered > 2 {
                        return Err(Over);
                    }
                    self.send(Message::Ping(Bytes::new())).await?;
                }
            }
        }
    }

    async fn deliver(
        &mut self,
        sent: Result<Sent, broadcast::error::RecvError>,
    ) -> Result<(), Over> {
        let (channel, time_ns, data) = match sent {
            Ok(Sent::Message {
                channel,
                time_ns,
                data,
            }) => (channel, time_ns, data),
            Ok(Sent::Text(text)) => return self.send(Message::text(&*text)).await,
            Err(RecvError::Lagged(count)) => {
                self.hub.metrics.viewers_missed.add_many(count);
                return Ok(());
            }
            Err(RecvError::Closed) => return Err(Over),
        };
        let Some(id) = self.subscriptions.get(&channel) else {
            return Ok(());
        };
        // Once as a message and once as a frame.
        let Some(_room) = self.hub.room(2 * data.len()) else {
            self.hub.metrics.viewers_missed.add();
            return Ok(());
        };
        let mut message = Vec::with_capacity(13 + data.len());
        message.push(DATA);
        message.extend(id.to_le_bytes());
        message.extend(time_ns.to_le_bytes());
        message.extend_from_slice(&data);
        drop(data);
        self.send(Message::binary(message)).await
    }

    /// Sends; a viewer that does not take it in time is sent away.
    async fn send(&mut self, message: Message) -> Result<(), Over> {
        let sent = tokio::time::timeout(STALL, self.socket.send(message)).await;
        self.is_taken(sent)
    }

    /// Sends what waits to be sent.
    async fn flush(&mut self) -> Result<(), Over> {
        let sent = tokio::time::timeout(STALL, self.socket.flush()).await;
        self.is_taken(sent)
    }

    fn is_taken<E>(&self, sent: Result<Result<(), E>, Elapsed>) -> Result<(), Over> {
        match sent {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) => Err(Over),
            Err(_) => {
                self.hub.metrics.viewers_stalled.add();
                Err(Over)
            }
        }
    }

    fn received(&mut self, text: &str) {
        match serde_json::from_str(text) {
            Ok(Received::Subscribe { subscriptions }) => {
                for Subscription { id, channel_id } in subscriptions {
                    let Some(count) = self.hub.subscribed(channel_id) else {
                        continue;
                    };
                    if self.subscriptions.insert(channel_id, id).is_none() {
                        count.fetch_add(1, Ordering::Relaxed);
                    }
                }
            }
            Ok(Received::Unsubscribe { ids }) => {
                let hub = self.hub;
                self.subscriptions.retain(|channel, id| {
                    let stays = !ids.contains(id);
                    if !stays && let Some(count) = hub.subscribed(*channel) {
                        count.fetch_sub(1, Ordering::Relaxed);
                    }
                    stays
                });
            }
            // Neither what no reader says nor garbage does anything.
            Ok(Received::Other) | Err(_) => {}
        }
    }

    fn unsubscribe_all(&mut self) {
        for channel in std::mem::take(&mut self.subscriptions).into_keys() {
            if let Some(count) = self.hub.subscribed(channel) {
                count.fetch_sub(1, Ordering::Relaxed);
            }
        }
    }
}
