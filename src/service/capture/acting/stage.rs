//! What acting pages share: the page itself, who is let in, and who has which stream.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use tokio::sync::{Semaphore, watch};

use super::super::director::Director;
use super::super::event::Status;
use super::super::metrics::Metrics;
use super::calibration::Calibrations;
use super::claims::Claims;
use super::greeting::{Greeting, scene_glb};
use super::pairing::Pairing;
use crate::ingest::live::{StreamTopic, Token};
use crate::motion::Scene;

/// Pages that act at a time.
const PAGES: usize = 4;

/// Readings that a page may send: four trackers of 250 Hz.
pub(super) const READINGS_PER_SECOND: f64 = 1000.0;

/// Texts that it may send.
pub(super) const TEXTS_PER_SECOND: f64 = 20.0;

/// What the acting page is served with.
pub(in super::super) struct ActingStage {
    /// The page.
    pub(in super::super) html: Arc<[u8]>,
    /// The scene as binary glTF, each body at the origin.
    pub(in super::super) scene: Arc<[u8]>,
    pub(super) greeting: Greeting,
    pub(super) pairing: Pairing,
    pub(super) claims: Claims,
    pub(super) calibrations: Arc<Calibrations>,
    pub(super) director: Director,
    pub(super) status: watch::Receiver<Status>,
    pub(super) metrics: Arc<Metrics>,
    pub(super) places: Arc<Semaphore>,
    sessions: AtomicU32,
}

/// What the parts of it are made of.
pub(in super::super) struct ActingParts<'a> {
    /// The page.
    pub(in super::super) html: Arc<[u8]>,
    pub(in super::super) pairing: Pairing,
    pub(in super::super) scene: &'a Scene,
    /// The text of it.
    pub(in super::super) scene_toml: &'a str,
    pub(in super::super) topics: &'a [StreamTopic],
    /// With a queue of its own.
    pub(in super::super) director: Director,
    pub(in super::super) status: watch::Receiver<Status>,
    pub(in super::super) metrics: Arc<Metrics>,
}

impl ActingStage {
    pub(in super::super) fn new(parts: ActingParts) -> Self {
        // Any beginning that another start of the daemon is unlikely to have.
        let first = Token::make().map_or([0; 16], |token| token.bytes());
        Self {
            html: parts.html,
            scene: scene_glb(parts.scene).into(),
            greeting: Greeting::new(parts.scene, parts.topics, parts.director.events()),
            pairing: parts.pairing,
            claims: Claims::new(parts.topics.len()),
            calibrations: Arc::new(Calibrations::new(parts.scene_toml, parts.topics)),
            director: parts.director,
            status: parts.status,
            metrics: parts.metrics,
            places: Arc::new(Semaphore::new(PAGES)),
            sessions: AtomicU32::new(u32::from_le_bytes([first[0], first[1], first[2], 0])),
        }
    }

    /// The six digits that who acts must know.
    pub(in super::super) fn code(&self) -> &str {
        self.pairing.code()
    }

    /// A number that differs for every connection.
    pub(super) fn session(&self) -> u32 {
        self.sessions.fetch_add(1, Ordering::Relaxed)
    }
}
