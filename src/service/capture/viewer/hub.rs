//! What viewers are sent waits here once, however many viewers there are.
//!
//! Messages are in two rings that all viewers read, each at its own pace: one who is too slow misses
//! the oldest. What all of them together can take is bounded:
//!
//! | what | bytes, at most |
//! |---|---|
//! | 512 messages of at most 64 KiB | 32 MiB |
//! | 4 greater ones of at most 3 MiB | 12 MiB |
//! | what is being sent, all viewers together; who finds no room misses the message | 11 MiB |
//! | what is being received: 32 viewers, at most 16 KiB each | 0.5 MiB |
//! | 128 handshakes of at most 64 KiB | 8 MiB |
//!
//! A message of more than 3 MiB is not shown, and the log says so.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;

use base64::Engine as _;
use serde_json::json;
use tokio::sync::{Semaphore, broadcast};

use super::super::metrics::Metrics;
use super::super::seldom::Seldom;
use super::super::take::now_ns;
use crate::write::show::ShownTopic;

const RING: usize = 512;
const LARGE_RING: usize = 4;
const MESSAGE_BYTES: usize = 64 << 10;
const LARGE_BYTES: usize = 3 << 20;
const SENDING_BYTES: usize = 11 << 20;

/// A message for all who subscribed to its channel, or for all.
#[derive(Clone, Debug)]
pub(super) enum Sent {
    /// On a channel.
    Message {
        /// Its channel.
        channel: u32,
        /// When it was sent \[ns since 1970\].
        time_ns: u64,
        /// Its bytes.
        data: Arc<[u8]>,
    },
    /// Text of the protocol.
    Text(Arc<str>),
}

/// The number of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ChannelNumber(u32);

/// The channels, and what is on them.
pub(super) struct Hub {
    name: String,
    topics: Vec<ShownTopic>,
    subscribers: Vec<AtomicUsize>,
    ring: broadcast::Sender<Sent>,
    large: broadcast::Sender<Sent>,
    /// Warnings that hold, by their names.
    warnings: Mutex<BTreeMap<String, String>>,
    sending: Arc<Semaphore>,
    pub(super) metrics: Arc<Metrics>,
    too_large: Seldom,
}

impl Hub {
    pub(super) fn new(name: String, metrics: &Arc<Metrics>) -> Self {
        Self {
            name,
            topics: Vec::new(),
            subscribers: Vec::new(),
            ring: broadcast::channel(RING).0,
            large: broadcast::channel(LARGE_RING).0,
            warnings: Mutex::default(),
            sending: Arc::new(Semaphore::new(SENDING_BYTES)),
            metrics: Arc::clone(metrics),
            too_large: Seldom::default(),
        }
    }

    /// Adds a channel, before anybody is served.
    pub(super) fn open(&mut self, topic: ShownTopic) -> ChannelNumber {
        self.topics.push(topic);
        self.subscribers.push(AtomicUsize::new(0));
        ChannelNumber(self.topics.len() as u32)
    }

    /// Shows a message to all who subscribed; without any it is dropped.
    pub(super) fn log(&self, channel: ChannelNumber, data: Vec<u8>) {
        if !self.has_subscribers(channel) {
            return;
        }
        let is_large = data.len() > MESSAGE_BYTES;
        if data.len() > LARGE_BYTES {
            if let Some(more) = self.too_large.due(Instant::now()) {
                let topic = &self.topics[channel.0 as usize - 1].topic;
                tracing::warn!(?topic, bytes = data.len(), more, "too large to be shown");
            }
            return;
        }
        let sent = Sent::Message {
            channel: channel.0,
            time_ns: u64::try_from(now_ns()).unwrap_or(0),
            data: data.into(),
        };
        let ring = if is_large { &self.large } else { &self.ring };
        // Fails where nobody is there.
        let _ = ring.send(sent);
    }

    pub(super) fn has_subscribers(&self, channel: ChannelNumber) -> bool {
        self.subscribed(channel.0)
            .is_some_and(|count| count.load(Ordering::Relaxed) > 0)
    }

    /// The number of subscribers of a channel, if there is such a channel.
    pub(super) fn subscribed(&self, channel: u32) -> Option<&AtomicUsize> {
        self.subscribers.get((channel as usize).checked_sub(1)?)
    }

    /// Both rings, from now on.
    pub(super) fn listen(&self) -> (broadcast::Receiver<Sent>, broadcast::Receiver<Sent>) {
        (self.ring.subscribe(), self.large.subscribe())
    }

    /// Room for sending so many bytes, in turn with all other viewers.
    pub(super) fn room(&self, bytes: usize) -> Option<tokio::sync::OwnedSemaphorePermit> {
        let bytes = u32::try_from(bytes).ok()?;
        Arc::clone(&self.sending).try_acquire_many_owned(bytes).ok()
    }

    /// Warns of something until it is over: all viewers now, and those that come.
    pub(super) fn warn(&self, name: &str, text: Option<&str>) {
        let Ok(mut warnings) = self.warnings.lock() else {
            return;
        };
        let sent = match text {
            Some(text) if warnings.get(name).is_some_and(|said| said == text) => return,
            Some(text) => {
                warnings.insert(name.to_owned(), text.to_owned());
                warning(name, text)
            }
            None if warnings.remove(name).is_none() => return,
            None => json!({"op": "removeStatus", "statusIds": [name]}).to_string(),
        };
        let _ = self.ring.send(Sent::Text(sent.into()));
    }

    /// What a viewer is told first.
    pub(super) fn greeting(&self) -> Vec<String> {
        let info = json!({"op": "serverInfo", "name": self.name, "capabilities": []});
        let channels = self.topics.iter().zip(1..).map(|(topic, id)| {
            let schema = &topic.schema;
            let data = match std::str::from_utf8(&schema.data) {
                Ok(text) if schema.encoding != "protobuf" => text.to_owned(),
                _ => base64::engine::general_purpose::STANDARD.encode(&schema.data),
            };
            json!({
                "id": id,
                "topic": topic.topic,
                "encoding": topic.encoding,
                "schemaName": schema.name,
                "schemaEncoding": schema.encoding,
                "schema": data,
            })
        });
        let channels: Vec<_> = channels.collect();
        let channels = json!({"op": "advertise", "channels": channels});
        let mut greeting = vec![info.to_string(), channels.to_string()];
        if let Ok(warnings) = self.warnings.lock() {
            greeting.extend(warnings.iter().map(|(name, text)| warning(name, text)));
        }
        greeting
    }
}

fn warning(name: &str, text: &str) -> String {
    json!({"op": "status", "level": 1, "message": text, "id": name}).to_string()
}
