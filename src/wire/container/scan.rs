//! Finds where records continue after damage.
//!
//! Opcode and length of a record have no checksum, and without the length of one record the offset
//! of the next is unknown. Only records with a checksum of their own can be found without them:
//! chunks, by their headers, and attachments.

use std::ops::Range;

use mcap::records::op;

use super::budget::{ATTEMPT_BYTES, Budget};
use super::record::{self, ChunkHeader, FRAME_BYTES, PRIVATE};

/// A search for records that pass their checksum. It gives up after too much work without success.
pub(super) struct Scan {
    pub(super) budget: Budget,
    records: Vec<u8>,
    /// From here to the end of the file there is nothing to be found.
    nothing_from: usize,
}

impl Scan {
    /// A search in a file, at most at this cost.
    pub(super) fn new(budget: Budget) -> Self {
        Self {
            budget,
            records: Vec::new(),
            nothing_from: usize::MAX,
        }
    }

    /// The first offset in a range at which a verified chunk or attachment begins.
    pub(super) fn find(&mut self, bytes: &[u8], range: Range<usize>) -> Option<usize> {
        if range.start >= self.nothing_from {
            return None;
        }
        for at in range.clone() {
            if self.budget.step() || self.budget.is_spent() {
                return None;
            }
            let is_found = match record::chunk_header(bytes, at).filter(|chunk| chunk.is_checked) {
                Some(chunk) => self.passes(bytes, at, chunk),
                None => self.attachment_end(bytes, at).is_some(),
            };
            if is_found {
                return Some(at);
            }
        }
        if range.end == bytes.len() {
            self.nothing_from = range.start;
        }
        None
    }

    /// Whether the chunk at `at` can be unpacked and passes its checksum.
    pub(super) fn passes(&mut self, bytes: &[u8], at: usize, chunk: ChunkHeader) -> bool {
        let cost = chunk.packed.saturating_add(ATTEMPT_BYTES);
        if !self.budget.may_hash(cost) {
            return false;
        }
        let limit = self.budget.unpacked_left();
        let (work, result) = record::unpack_chunk(bytes, at..chunk.end, limit, &mut self.records);
        match result {
            Ok(()) => self.budget.was_worth(cost),
            Err(_) => {
                self.budget.may_hash(work);
            }
        }
        result.is_ok()
    }

    /// Where an attachment at `at` ends that passes its checksum, whatever its record's type and
    /// length are. `None` too after too much work without success.
    pub(super) fn attachment_end(&mut self, bytes: &[u8], at: usize) -> Option<usize> {
        let (end, checked) = record::attachment_of(bytes, at)?;
        if !self.budget.may_hash(checked.len()) {
            return None;
        }
        let saved = bytes[checked.end..end].try_into().ok()?;
        if crc32fast::hash(&bytes[checked.clone()]) != u32::from_le_bytes(saved) {
            return None;
        }
        self.budget.was_worth(checked.len());
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
