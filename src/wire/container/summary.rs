//! Schemas and channels from the summary section, where a file repeats them at its end.

use mcap::MAGIC;
use mcap::records::op;

use super::record::{self, Content, FRAME_BYTES};

/// Length of a footer: two offsets and a checksum.
const FOOTER_BYTES: usize = 8 + 8 + 4;

/// Length of what is after the summary section: the footer's record and the magic bytes.
pub(super) const END_BYTES: usize = FRAME_BYTES + FOOTER_BYTES + MAGIC.len();

/// What the checksum does not cover of it.
const UNCHECKED_BYTES: usize = 4 + MAGIC.len();

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
    let (start, saved) = footer(bytes)?;
    let start = usize::try_from(start).ok()?;
    let section = bytes.get(start..)?;
    let is_believed = saved == 0 || is_verified(section, saved);
    section
        .get(..section.len().checked_sub(END_BYTES)?)
        .filter(|_| is_believed)
}

/// Where the summary section of a file begins, and its checksum, by the end of the file.
pub(super) fn footer(end: &[u8]) -> Option<(u64, u32)> {
    let (opcode, range) = record::frame(end, end.len().checked_sub(END_BYTES)?)?;
    let footer = end.get(range)?;
    if opcode != op::FOOTER || footer.len() != FOOTER_BYTES {
        return None;
    }
    let start = u64::from_le_bytes(footer[..8].try_into().ok()?);
    let saved = u32::from_le_bytes(footer[16..].try_into().ok()?);
    (start > 0).then_some((start, saved))
}

/// Whether a file has that checksum from its summary section to its end.
pub(super) fn is_verified(section: &[u8], saved: u32) -> bool {
    let checked = section.len().checked_sub(UNCHECKED_BYTES);
    section.len() >= END_BYTES
        && checked.is_some_and(|checked| saved == crc32fast::hash(&section[..checked]))
}
