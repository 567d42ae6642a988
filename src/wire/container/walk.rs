//! The records of a file's data section, one by one, in file order.

use std::ops::Range;
use std::sync::Arc;

use mcap::MAGIC;
use mcap::records::op;

use super::damage::{Damage, Damages};
use super::record::{self, Content};

/// A message as it lies in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Message<'a> {
    /// Its channel.
    pub channel_id: u16,
    /// Sequence number, whatever its writer meant by it.
    pub sequence: u32,
    /// When it was recorded \[ns\].
    pub log_time: u64,
    /// When it was published \[ns\].
    pub publish_time: u64,
    /// Its content.
    pub data: &'a [u8],
}

/// Where a record's bytes are.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    File,
    Chunk,
}

/// A walk over the data section. It shares the bytes, and remembers where it is and what
/// was wrong on the way.
pub struct Walk {
    bytes: Arc<Vec<u8>>,
    /// Next record of the file.
    at: usize,
    /// Offset of the last record handed out, or of the chunk it was in.
    offset: usize,
    /// The open chunk's records, whole and verified, and where the next of them begins.
    chunk: Vec<u8>,
    chunk_at: usize,
    verifies_data_section: bool,
    ended: bool,
    damages: Damages,
}

impl Walk {
    /// A walk that trusts an earlier one for the data section's checksum.
    pub(super) fn new(bytes: Arc<Vec<u8>>) -> Self {
        Self {
            bytes,
            at: MAGIC.len(),
            offset: 0,
            chunk: Vec::new(),
            chunk_at: 0,
            verifies_data_section: false,
            ended: false,
            damages: Damages::default(),
        }
    }

    /// A walk that also checks the data section as a whole.
    pub(super) fn verifying(bytes: Arc<Vec<u8>>) -> Self {
        Self {
            verifies_data_section: true,
            ..Self::new(bytes)
        }
    }

    /// The next message. Its channel may be one that the file does not define.
    pub fn next_message(&mut self) -> Option<Message<'_>> {
        loop {
            let (place, content) = self.next_content()?;
            if let Content::Message { header, data } = content {
                return Some(Message {
                    channel_id: header.channel_id,
                    sequence: header.sequence,
                    log_time: header.log_time,
                    publish_time: header.publish_time,
                    data: &self.bytes_of(place)[data],
                });
            }
        }
    }

    /// The next record that can be parsed, and where its ranges point.
    pub(super) fn next_content(&mut self) -> Option<(Place, Content)> {
        loop {
            let (place, opcode, range) = self.next_frame()?;
            match record::parse(opcode, self.bytes_of(place), range) {
                Ok(content) => return Some((place, content)),
                Err(error) => {
                    let damage = Damage::Record {
                        at: self.offset,
                        opcode,
                        reason: error.to_string(),
                    };
                    self.damages.push(damage);
                }
            }
        }
    }

    /// Offset in the file of the record that was handed out last, or of its chunk.
    pub(super) fn offset(&self) -> usize {
        self.offset
    }

    pub(super) fn into_damages(self) -> Damages {
        self.damages
    }

    fn bytes_of(&self, place: Place) -> &[u8] {
        match place {
            Place::File => &self.bytes,
            Place::Chunk => &self.chunk,
        }
    }

    fn next_frame(&mut self) -> Option<(Place, u8, Range<usize>)> {
        loop {
            if self.chunk_at < self.chunk.len() {
                let (opcode, range) = record::frame(&self.chunk, self.chunk_at)
                    .expect("an unpacked chunk holds whole records");
                self.chunk_at = range.end;
                return Some((Place::Chunk, opcode, range));
            }
            if self.ended {
                return None;
            }
            let Some((opcode, range)) = record::frame(&self.bytes, self.at) else {
                self.end_cut();
                return None;
            };
            self.offset = self.at;
            self.at = range.end;
            match opcode {
                op::CHUNK => self.open_chunk(range.end),
                op::DATA_END => {
                    self.end_whole(range);
                    return None;
                }
                // A footer without the record that ends the data: a chunk with its type
                // damaged would look so.
                op::FOOTER => {
                    self.at = self.offset;
                    self.end_cut();
                    return None;
                }
                _ => return Some((Place::File, opcode, range)),
            }
        }
    }

    fn open_chunk(&mut self, end: usize) {
        self.chunk_at = 0;
        if let Err(error) = record::unpack_chunk(&self.bytes[self.offset..end], &mut self.chunk) {
            self.damages.push(Damage::Chunk {
                at: self.offset,
                reason: error.to_string(),
            });
        }
    }

    fn end_cut(&mut self) {
        self.ended = true;
        self.damages.push(Damage::Cut { at: self.at });
    }

    /// At the record that ends the data section.
    fn end_whole(&mut self, body: Range<usize>) {
        self.ended = true;
        if !self.verifies_data_section {
            return;
        }
        let saved = self.bytes.get(body).and_then(|body| body.try_into().ok());
        let Some(saved) = saved.map(u32::from_le_bytes) else {
            return self.damages.push(Damage::Cut { at: self.offset });
        };
        let calculated = crc32fast::hash(&self.bytes[..self.offset]);
        if saved != 0 && saved != calculated {
            self.damages.push(Damage::Checksum { calculated, saved });
        }
        if !self.bytes[self.offset..].ends_with(MAGIC) {
            self.damages.push(Damage::NoEnd);
        }
    }
}
