//! What is wrong with a file, and where.

use thiserror::Error;

/// A place where a file is not what it should be.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Damage {
    /// The file ends, or its records cannot be told apart any more.
    #[error("cut off: nothing can be read from byte {at} on")]
    Cut {
        /// Offset of the first record that is not whole.
        at: usize,
    },
    /// A chunk cannot be decompressed or fails its checksum: none of its messages is used.
    #[error("chunk at byte {at} is left out: {reason}")]
    Chunk {
        /// Offset in the file.
        at: usize,
        /// What the MCAP reader says.
        reason: String,
    },
    /// A record cannot be parsed.
    #[error("record of type {opcode:#04x} at byte {at} is left out: {reason}")]
    Record {
        /// Offset in the file, of its chunk if it is in one.
        at: usize,
        /// Its type.
        opcode: u8,
        /// What the MCAP reader says.
        reason: String,
    },
    /// Two definitions of one channel or schema: the first holds.
    #[error("{what} {id} is defined twice, differently")]
    Redefined {
        /// `channel` or `schema`.
        what: &'static str,
        /// Which one.
        id: u16,
    },
    /// A channel names a schema that is not there.
    #[error("channel {id} names schema {schema}, which is not defined")]
    NoSchema {
        /// The channel, left out.
        id: u16,
        /// The schema.
        schema: u16,
    },
    /// A message names a channel that is not there.
    #[error("message at byte {at} is left out: channel {id} is not defined")]
    NoChannel {
        /// Offset in the file, of its chunk if it is in one.
        at: usize,
        /// The channel.
        id: u16,
    },
    /// The data section fails its checksum.
    #[error("checksum of the data section is {calculated:#010x}, the file says {saved:#010x}")]
    Checksum {
        /// As calculated.
        calculated: u32,
        /// As stored.
        saved: u32,
    },
    /// All records are there, but not the end of the file.
    #[error("the end of the file is missing")]
    NoEnd,
}

/// How many damages are kept in full.
const KEPT: usize = 16;

/// The damages of a file: the first few, and how many in all.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Damages {
    first: Vec<Damage>,
    count: usize,
}

impl Damages {
    /// The first sixteen, in file order.
    pub fn first(&self) -> &[Damage] {
        &self.first
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Whether the file is cut off: its end is not there.
    pub fn is_truncated(&self) -> bool {
        self.first
            .iter()
            .any(|damage| matches!(damage, Damage::Cut { .. } | Damage::NoEnd))
    }

    pub(super) fn push(&mut self, damage: Damage) {
        self.count += 1;
        // A missing end is always said, however much came before it.
        if self.first.len() < KEPT || matches!(damage, Damage::Cut { .. } | Damage::NoEnd) {
            self.first.push(damage);
        }
    }

    pub(super) fn append(&mut self, others: Damages) {
        let unkept = others.count - others.first.len();
        for damage in others.first {
            self.push(damage);
        }
        self.count += unkept;
    }
}
