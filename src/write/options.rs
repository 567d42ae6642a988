//! How every MCAP file of ours is made.

use std::io::{Seek, Write};

use mcap::{Compression, WriteOptions, Writer};

/// What the header names as the library: a constant, for the bytes not to change with a
/// version.
pub(super) const LIBRARY: &str = "enact";

/// An MCAP writer with our options: zstd at level 1, which writes pose messages twice as fast
/// as the default level, and no compression threads, whose number would show in the bytes.
pub(super) fn writer<W: Write + Seek>(sink: W, profile: &str) -> mcap::McapResult<Writer<W>> {
    WriteOptions::new()
        .profile(profile)
        .library(LIBRARY)
        .compression(Some(Compression::Zstd))
        .compression_level(1)
        .compression_threads(0)
        .create(sink)
}
