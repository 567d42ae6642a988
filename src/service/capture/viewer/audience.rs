//! Viewers without a network, for tests and fuzzing.

use std::sync::Arc;

use tokio::io::{AsyncRead, AsyncWrite};
use tokio::sync::Semaphore;

use super::super::gate::Gate;
use super::super::metrics::Metrics;
use super::super::origin::Origins;
use super::ViewerChannels;
use super::hub::{ChannelNumber, Hub};
use super::websocket::Server;
use crate::ingest::live::StreamTopic;
use crate::motion::Scene;

const PLACES: usize = 2;

/// The server of viewers, and its channels.
pub(in super::super) struct Audience {
    server: Arc<Server>,
    channels: Vec<ChannelNumber>,
}

impl Audience {
    pub(in super::super) fn new(
        scene: &Scene,
        streams: &[StreamTopic],
        origins: Origins,
        metrics: &Arc<Metrics>,
    ) -> Self {
        let mut hub = Hub::new("audience".to_owned(), metrics);
        let of = ViewerChannels::new(&mut hub, scene, streams);
        let alone = [of.marks, of.transforms, of.scene, of.report, of.time_map];
        let all = alone.into_iter().chain(of.trackers);
        Self {
            channels: all.chain(of.links.into_iter().flatten()).collect(),
            server: Arc::new(Server {
                hub: Arc::new(hub),
                gate: Gate::new("viewers", 1, metrics),
                places: Arc::new(Semaphore::new(PLACES)),
                origins,
            }),
        }
    }

    /// Serves one connection to its end.
    pub(in super::super) async fn serve(&self, stream: impl AsyncRead + AsyncWrite + Unpin) {
        let waiting = self.server.gate.alone();
        Arc::clone(&self.server).serve(stream, waiting).await;
    }

    /// Shows a message on every channel.
    pub(in super::super) fn show(&self, data: Vec<u8>) {
        for channel in &self.channels {
            self.server.hub.log(*channel, data.clone());
        }
    }

    /// Whether nobody watches or is subscribed to anything.
    pub(in super::super) fn is_empty(&self) -> bool {
        let hub = &self.server.hub;
        let is_free = |channel: &ChannelNumber| !hub.has_subscribers(*channel);
        self.server.places.available_permits() == PLACES
            && hub.metrics.viewers.get() == 0
            && self.channels.iter().all(is_free)
    }
}
