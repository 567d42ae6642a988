//! Finds where records continue after damage.
//!
//! Opcode and length of a record have no checksum, and without the length of one record the offset
//! of the next is unknown. Only records with a checksum of their own can be found without them:
//! chunks, by their headers, and attachments.

use std::ops::Range;

use mcap::records::op;

use super::record::{self, FRAME_BYTES, PRIVATE};

/// Limit of the bytes that are unpacked without success: this multiple of the file's size plus
/// [`VAIN_BYTES`]. A file can be made to hold a plausible beginning of a chunk at every fifty
/// bytes.
const VAIN_SHARE: usize = 8;
const VAIN_BYTES: usize = 64 << 20;

/// A search for records that pass their checksum. It gives up after too much work without success.
pub(super) struct Scan {
    left: usize,
    records: Vec<u8>,
}

impl Scan {
    /// A search in a file of the given size.
    pub(super) fn new(bytes: usize) -> Self {
        Self {
            left: bytes.saturating_mul(VAIN_SHARE).saturating_add(VAIN_BYTES),
            records: Vec::new(),
        }
    }

    /// The first offset in a range at which a verified chunk or attachment begins.
    pub(super) fn find(&mut self, bytes: &[u8], range: Range<usize>) -> Option<usize> {
        for at in range {
            let wasted = if let Some(chunk) = record::chunk_header(bytes, at)
                && chunk.is_checked
            {
                if record::unpack_chunk(bytes, at, chunk.end, &mut self.records).is_ok() {
                    return Some(at);
                }
                chunk.packed
            } else {
                if self.attachment_end(bytes, at).is_some() {
                    return Some(at);
                }
                0
            };
            self.left = self.left.checked_sub(wasted)?;
        }
        None
    }

    /// Where an attachment at `at` ends that passes its checksum, whatever its record's type and
    /// length are. `None` too after too much work without success.
    pub(super) fn attachment_end(&mut self, bytes: &[u8], at: usize) -> Option<usize> {
        let (end, checked) = record::attachment_of(bytes, at)?;
        self.left = self.left.checked_sub(checked.len())?;
        let saved = bytes[checked.end..end].try_into().ok()?;
        if crc32fast::hash(&bytes[checked.clone()]) != u32::from_le_bytes(saved) {
            return None;
        }
        self.left += checked.len();
        Some(end)
    }
}

/// Number of consecutive records that are checked, since other bytes may look like one record.
const IN_A_ROW: usize = 3;

/// Whether records may begin at `at`: none of the next [`IN_A_ROW`] is certainly no record. The end
/// of the bytes is accepted as it is.
pub(super) fn is_plausible(bytes: &[u8], mut at: usize) -> bool {
    for _ in 0..IN_A_ROW {
        let Some(&opcode) = bytes.get(at) else {
            return true;
        };
        if record::chunk_header(bytes, at).is_some_and(|chunk| chunk.is_checked) {
            return true;
        }
        // The high bytes of a valid length are zero.
        let high = bytes.get(at + FRAME_BYTES - 3..at + FRAME_BYTES);
        let is_known = matches!(opcode, op::HEADER..=op::DATA_END | PRIVATE..);
        if !is_known || high.is_some_and(|high| high != [0; 3]) {
            return false;
        }
        // In a file that is cut off the length may reach beyond the end.
        let Some((_, range)) = record::frame(bytes, at) else {
            return true;
        };
        at = range.end;
    }
    true
}
