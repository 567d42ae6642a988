//! A part of a recording, or the whole with another scene.

use std::ops::RangeInclusive;
use std::path::Path;

use super::atomic::AtomicFile;
use super::error::WriteError;
use super::estimate::{SCENE_NAME, is_same};
use super::merge::{self, Additions, Kept};
use crate::wire::Container;

/// Writes the messages of a recording that were logged then \[ns\], whole or not at all, with this scene in
/// place of its own if one is given. Everything else is as it was, but for what an earlier estimate added:
/// of a part it is no longer the estimate. Returns the number of messages. It is made of
/// those files, of which none is replaced, and nobody may read it who may not read them.
pub fn write_part(
    path: &Path,
    input: &Container,
    made_of: &[&Path],
    log_times: RangeInclusive<u64>,
    scene: Option<Vec<u8>>,
) -> Result<u64, WriteError> {
    if made_of.iter().any(|of| is_same(path, of)) {
        return Err(WriteError::IsInput {
            path: path.to_owned(),
        });
    }
    let dropped = scene.as_ref().map(|_| SCENE_NAME);
    let additions = Additions {
        scene: scene.map(|text| (SCENE_NAME, text)),
        kept: Kept {
            log_times: Some(log_times),
            ..Kept::default()
        },
        ..Additions::default()
    };
    let file = AtomicFile::create_of(path, made_of)?;
    merge::write(file, input, dropped, additions)
}
