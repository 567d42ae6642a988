//! Where records go on after damage.
//!
//! Opcode and length of a record have no checksum, and without the length of one record the next
//! one's place is not known. What can be found again without them is what has a checksum of its
//! own: a chunk by its header, an attachment.

use std::ops::Range;

use mcap::records::op;

use super::record::{self, Content, FRAME_BYTES, PRIVATE};

/// How much more than the file's own size may be unpacked in vain: a file can be made to hold a
/// likely beginning of a chunk at every fifty bytes.
const VAIN_SHARE: usize = 8;
const VAIN_BYTES: usize = 64 << 20;

/// Looks for records that pass a checksum. It gives up when it has done too much in vain.
pub(super) struct Scan {
    left: usize,
    records: Vec<u8>,
}

impl Scan {
    /// For a file of that many bytes.
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
            } else if let Some(length) = attachment(bytes, at) {
                match length {
                    Ok(()) => return Some(at),
                    Err(length) => length,
                }
            } else {
                0
            };
            self.left = self.left.checked_sub(wasted)?;
        }
        None
    }
}

/// Whether the attachment that may begin at `at` passes its checksum; its length if not.
fn attachment(bytes: &[u8], at: usize) -> Option<Result<(), usize>> {
    if bytes[at] != op::ATTACHMENT {
        return None;
    }
    let (_, range) = record::frame(bytes, at)?;
    let length = range.len();
    let is_checked = bytes[..range.end].last_chunk() != Some(&[0; 4]);
    match record::parse(op::ATTACHMENT, bytes, range.clone()) {
        // Its checksum is the last of it.
        Ok(Content::Attachment { data, .. }) if is_checked && data.end + 4 == range.end => {
            Some(Ok(()))
        }
        _ => Some(Err(length)),
    }
}

/// How many records in a row are looked at: what is no record may look like one.
const IN_A_ROW: usize = 3;

/// Whether records may begin at `at`: it is known of none of the next that it is none. The end of the
/// bytes may be anything.
pub(super) fn is_plausible(bytes: &[u8], mut at: usize) -> bool {
    for _ in 0..IN_A_ROW {
        let Some(&opcode) = bytes.get(at) else {
            return true;
        };
        if record::chunk_header(bytes, at).is_some_and(|chunk| chunk.is_checked) {
            return true;
        }
        // A length has its high bytes zero.
        let high = bytes.get(at + FRAME_BYTES - 3..at + FRAME_BYTES);
        let is_known = matches!(opcode, op::HEADER..=op::DATA_END | PRIVATE..);
        if !is_known || high.is_some_and(|high| high != [0; 3]) {
            return false;
        }
        // Of a file that is cut it may be too great.
        let Some((_, range)) = record::frame(bytes, at) else {
            return true;
        };
        at = range.end;
    }
    true
}
