//! Schemas and channels from the summary section, where a file repeats them at its end.

use mcap::MAGIC;
use mcap::records::op;

use super::record::{self, Content, FRAME_BYTES};

/// Length of a footer: two offsets and a checksum.
const FOOTER_BYTES: usize = 8 + 8 + 4;

/// Schemas and channels of the summary section; none where it is absent or fails its checksum.
pub(super) fn definitions(bytes: &[u8]) -> Vec<Content> {
    let Some(summary) = summary(bytes) else {
        return Vec::new();
    };
    let mut found = Vec::new();
    let mut at = 0;
    while let Some((opcode, range)) = record::frame(summary, at) {
        at = range.end;
        if matches!(opcode, op::SCHEMA | op::CHANNEL) {
            found.extend(record::parse(opcode, summary, range).ok());
        }
    }
    found
}

/// The summary section, verified.
fn summary(bytes: &[u8]) -> Option<&[u8]> {
    let footer_at = bytes
        .len()
        .checked_sub(FRAME_BYTES + FOOTER_BYTES + MAGIC.len())?;
    let (opcode, range) = record::frame(bytes, footer_at)?;
    let footer = bytes.get(range)?;
    if opcode != op::FOOTER || footer.len() != FOOTER_BYTES {
        return None;
    }
    let start = u64::from_le_bytes(footer[..8].try_into().ok()?);
    let start = usize::try_from(start).ok().filter(|start| *start > 0)?;
    let saved = u32::from_le_bytes(footer[16..].try_into().ok()?);
    let checked = bytes.get(start..footer_at + FRAME_BYTES + FOOTER_BYTES - 4)?;
    if saved != 0 && saved != crc32fast::hash(checked) {
        return None;
    }
    bytes.get(start..footer_at)
}
