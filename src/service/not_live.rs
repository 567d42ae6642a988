//! In place of live takes where the program is built without them.

use std::path::Path;

use thiserror::Error;

use crate::motion::{Scene, Stamp, TakeEvent};
use crate::pipeline::Outcome;

/// The program was built without the feature `live`.
#[derive(Clone, Copy, Debug, Error)]
#[error(
    "this enact was built without live takes: build it with `cargo build --release --features live`"
)]
pub struct NotLive;

/// Nothing can be sent.
pub(super) enum Publication {}

impl Publication {
    /// Always [`NotLive`].
    pub(super) fn begin(_: &Scene, _: Option<&Path>) -> anyhow::Result<Self> {
        Err(NotLive.into())
    }

    pub(super) fn event(&mut self, _: Stamp, _: &TakeEvent) -> anyhow::Result<()> {
        match *self {}
    }

    pub(super) fn end(self, _: &Outcome) -> anyhow::Result<()> {
        match self {}
    }
}
