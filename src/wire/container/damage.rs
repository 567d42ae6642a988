//! Damage of an MCAP file, with offsets.

use std::ops::Range;

use thiserror::Error;

/// One damage of a file.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Damage {
    /// Nothing that can be verified follows: the file ends in the middle of a record, or
    /// its rest is destroyed.
    #[error("cut off: nothing can be read from byte {at} on, {bytes} bytes")]
    Cut {
        /// Offset of the first incomplete record.
        at: usize,
        /// Number of bytes from there to the end of the file.
        bytes: usize,
    },
    /// Chunks unpack to more than is read of a file of that size.
    #[error(
        "reading ends at byte {at}, {bytes} bytes were not read: the chunks unpack to more than 64 times the file's size and 64 MiB"
    )]
    Unpacked {
        /// Offset of the chunk that would be too much.
        at: usize,
        /// Number of bytes from there to the end of the file.
        bytes: usize,
    },
    /// The search for the next record that can be verified was given up.
    #[error(
        "the search for records that can be verified ends at byte {at} after too much work in vain, {bytes} bytes were not read"
    )]
    Searched {
        /// Offset of the first byte that was not read.
        at: usize,
        /// Number of bytes from there to the end of the file.
        bytes: usize,
    },
    /// The time for reading was over.
    #[error("the time limit was reached at byte {at}, {bytes} bytes were not read")]
    Late {
        /// Offset of the first byte that was not read.
        at: usize,
        /// Number of bytes from there to the end of the file.
        bytes: usize,
    },
    /// A definition beyond what is kept of a file of that size.
    #[error("{what} {id} is left out: the definitions are longer than 4 times the file and 4 MiB")]
    Definitions {
        /// `channel` or `schema`.
        what: &'static str,
        /// Its id.
        id: u16,
    },
    /// Bytes in which nothing can be verified, before further records.
    #[error("nothing in bytes {at} to {end} can be verified: they are left out")]
    Gap {
        /// Offset of the first byte.
        at: usize,
        /// Offset of the next record.
        end: usize,
    },
    /// A chunk cannot be decompressed or fails its checksum: none of its messages is used.
    #[error("chunk in bytes {at} to {end} is left out: {reason}")]
    Chunk {
        /// Offset in the file.
        at: usize,
        /// Offset of the next record.
        end: usize,
        /// What the MCAP reader says.
        reason: String,
    },
    /// A chunk or attachment that passes its checksum although its opcode or length is wrong. No
    /// data are lost.
    #[error(
        "type or length of the record at byte {at} is damaged: it is read as its own header says"
    )]
    Frame {
        /// Offset in the file.
        at: usize,
    },
    /// A chunk that is identical to an earlier one: its messages are used once.
    #[error("chunk at byte {at} is that of byte {first} again, and left out")]
    Repeated {
        /// Offset in the file.
        at: usize,
        /// Offset of the earlier one.
        first: usize,
    },
    /// A record cannot be parsed.
    #[error("record of type {opcode:#04x} at byte {at} is left out: {reason}")]
    Record {
        /// Offset in the file, of its chunk if it is in one.
        at: usize,
        /// Its length in the file; zero if it is in a chunk, since that was read.
        bytes: usize,
        /// Its type.
        opcode: u8,
        /// What the MCAP reader says.
        reason: String,
    },
    /// Two different definitions of one channel or schema: the first is used.
    #[error("{what} {id} is defined twice, differently")]
    Redefined {
        /// `channel` or `schema`.
        what: &'static str,
        /// Its id.
        id: u16,
    },
    /// A channel names a schema that is not defined.
    #[error("channel {id} names schema {schema}, which is not defined")]
    NoSchema {
        /// The channel, left out.
        id: u16,
        /// The schema.
        schema: u16,
    },
    /// Messages name a channel that is not defined.
    #[error("{messages} messages from byte {at} on are left out: channel {id} is not defined")]
    NoChannel {
        /// Offset in the file of the first of them, of its chunk if it is in one.
        at: usize,
        /// Number of messages.
        messages: u64,
        /// The channel.
        id: u16,
    },
    /// The data section fails its checksum.
    #[error(
        "checksum of the data section is {calculated:#010x}, the file says {saved:#010x}: {}",
        unchecked(*messages)
    )]
    Checksum {
        /// Number of messages that no other checksum verifies.
        messages: u64,
        /// As calculated.
        calculated: u32,
        /// As stored.
        saved: u32,
    },
    /// All records are complete, but the end of the file is missing or damaged.
    #[error("the end of the file is missing or damaged")]
    NoEnd,
}

impl Damage {
    /// The bytes of the file that were not read.
    pub fn unread(&self) -> Option<Range<usize>> {
        match *self {
            Damage::Cut { at, bytes }
            | Damage::Unpacked { at, bytes }
            | Damage::Searched { at, bytes }
            | Damage::Late { at, bytes }
            | Damage::Record { at, bytes, .. }
                if bytes > 0 =>
            {
                Some(at..at + bytes)
            }
            Damage::Gap { at, end } | Damage::Chunk { at, end, .. } => Some(at..end),
            _ => None,
        }
    }

    /// Whether reading ended with it.
    fn is_end(&self) -> bool {
        use Damage::{Cut, Late, NoEnd, Searched, Unpacked};
        matches!(
            self,
            Cut { .. } | Late { .. } | Searched { .. } | Unpacked { .. } | NoEnd
        )
    }

    /// Whether all data of the file were read in spite of it.
    pub fn is_harmless(&self) -> bool {
        matches!(self, Damage::NoEnd | Damage::Frame { .. })
    }
}

/// What the failed checksum of a data section says of the messages that have no other.
fn unchecked(messages: u64) -> String {
    match messages {
        0 => "all messages have passed one of their own".to_owned(),
        _ => format!("any of the {messages} messages without one of their own may be wrong"),
    }
}

/// Number of damages that are kept in full.
const KEPT: usize = 16;

/// The damages of a file: the first few, their number, and all ranges that were not read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Damages {
    first: Vec<Damage>,
    count: usize,
    harmful: usize,
    unread: Vec<Range<usize>>,
}

impl Damages {
    /// The first sixteen, in file order.
    pub fn first(&self) -> &[Damage] {
        &self.first
    }

    /// Number of all damages.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Whether any of them is not harmless ([`Damage::is_harmless`]).
    pub fn is_loss(&self) -> bool {
        self.harmful > 0
    }

    /// Ranges of the file that were not read, in order; adjacent ranges are merged.
    pub fn unread(&self) -> &[Range<usize>] {
        &self.unread
    }

    /// Number of bytes that were not read.
    pub fn unread_bytes(&self) -> usize {
        self.unread.iter().map(ExactSizeIterator::len).sum()
    }

    /// Whether the end of the file is missing.
    pub fn is_truncated(&self) -> bool {
        self.first
            .iter()
            .any(|damage| matches!(damage, Damage::Cut { .. } | Damage::NoEnd))
    }

    pub(super) fn push(&mut self, damage: Damage) {
        self.count += 1;
        self.harmful += usize::from(!damage.is_harmless());
        if let Some(range) = damage.unread() {
            match self.unread.last_mut() {
                Some(last) if last.end == range.start => last.end = range.end,
                _ => self.unread.push(range),
            }
        }
        // Why reading ended is always kept, however many damages came before it.
        if self.first.len() < KEPT || damage.is_end() {
            self.first.push(damage);
        }
    }
}
