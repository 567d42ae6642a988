//! The records of a file's data section, one by one, in file order.

use std::collections::BTreeMap;
use std::hash::{BuildHasher, RandomState};
use std::ops::Range;
use std::sync::Arc;

use mcap::MAGIC;
use mcap::records::op;

use super::budget::{Budget, Reading};
use super::damage::{Damage, Damages};
use super::record::{self, ChunkHeader, Content, FRAME_BYTES};
use super::scan::{self, Scan};

/// Length of the record that ends the data section: its checksum.
const DATA_END_BYTES: usize = 4;

/// A message of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Message<'a> {
    /// Its channel.
    pub channel_id: u16,
    /// Sequence number, as its writer defined it.
    pub sequence: u32,
    /// When it was recorded \[ns\].
    pub log_time: u64,
    /// When it was published \[ns\].
    pub publish_time: u64,
    /// Its content.
    pub data: &'a [u8],
}

/// Whether a record's bytes are in the file or in the open chunk.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    File,
    Chunk,
}

/// A walk over the data section. It shares the bytes, and holds its position and the damage found
/// so far.
pub struct Walk {
    bytes: Arc<Vec<u8>>,
    /// Offset of the next record of the file.
    at: usize,
    /// Offset of the last record handed out, or of the chunk it was in.
    offset: usize,
    /// The open chunk's records, complete and verified.
    chunk: Vec<u8>,
    chunk_at: usize,
    /// Whether its checksum was verified.
    chunk_is_checked: bool,
    /// Offsets of the chunks read so far, by length and hash of their records in the file. Nobody
    /// can make different chunks of one hash, which would all have to be compared.
    chunks: BTreeMap<(usize, u64), Vec<usize>>,
    hasher: RandomState,
    scan: Scan,
    verifies_data_section: bool,
    /// Whether records without a checksum are not believed: see [`record::is_of_journal`]. Those of
    /// a journal never are; those of other files are as long as each record leads to the next,
    /// from the first on, and are not once a search found where to go on.
    is_strict: bool,
    /// Messages that were believed without a checksum of their own.
    unchecked: u64,
    ended: bool,
    ended_whole: bool,
    damages: Damages,
}

impl Walk {
    /// A walk that does not verify the data section's checksum: an earlier walk did.
    pub(super) fn new(bytes: Arc<Vec<u8>>, reading: Reading) -> Self {
        Self {
            // A file without the magic bytes is damaged from its first byte on.
            at: if bytes.starts_with(MAGIC) {
                MAGIC.len()
            } else {
                0
            },
            scan: Scan::new(Budget::new(bytes.len(), reading.deadline)),
            chunks: BTreeMap::new(),
            hasher: RandomState::new(),
            // Where its beginning is damaged nothing leads to its first record.
            is_strict: reading.is_journal || !bytes.starts_with(MAGIC),
            unchecked: 0,
            bytes,
            offset: 0,
            chunk: Vec::new(),
            chunk_at: 0,
            chunk_is_checked: false,
            verifies_data_section: false,
            ended: false,
            ended_whole: false,
            damages: Damages::default(),
        }
    }

    /// A walk that also checks the data section as a whole.
    pub(super) fn verifying(bytes: Arc<Vec<u8>>, reading: Reading) -> Self {
        Self {
            verifies_data_section: true,
            ..Self::new(bytes, reading)
        }
    }

    /// The next message; `None` at the end. The file may not define its channel.
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

    /// The next record that can be parsed, and the bytes to which its ranges refer.
    pub(super) fn next_content(&mut self) -> Option<(Place, Content)> {
        loop {
            let (place, opcode, range) = self.next_frame()?;
            let parsed = match place {
                Place::Chunk if !record::belongs_into_chunk(opcode) => Err(record::refused(
                    "it does not belong into a chunk".to_owned(),
                )),
                _ => record::parse(opcode, self.bytes_of(place), range),
            };
            match parsed {
                Ok(content) => {
                    let is_checked = place == Place::Chunk && self.chunk_is_checked;
                    let is_message = matches!(content, Content::Message { .. });
                    self.unchecked += u64::from(is_message && !is_checked);
                    return Some((place, content));
                }
                Err(error) => {
                    let damage = Damage::Record {
                        at: self.offset,
                        bytes: match place {
                            Place::File => self.at - self.offset,
                            Place::Chunk => 0,
                        },
                        opcode,
                        reason: record::words(&error),
                    };
                    self.damages.push(damage);
                }
            }
        }
    }

    /// Offset in the file of the last record returned, or of its chunk.
    pub(super) fn offset(&self) -> usize {
        self.offset
    }

    /// Whether the record that ends the data section was reached.
    pub(super) fn is_ended_whole(&self) -> bool {
        self.ended_whole
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
                self.chunk_at = match record::repeated(opcode, &self.chunk[range.clone()]) {
                    // The repeated records are walked through as records of the chunk itself.
                    Some(prefix) => range.start + prefix,
                    None => range.end,
                };
                return Some((Place::Chunk, opcode, range));
            }
            if self.ended {
                return None;
            }
            if self.scan.budget.step() {
                self.end_unread(self.at);
                return None;
            }
            self.offset = self.at;
            if let Some((opcode, range)) = self.next_in_file() {
                return Some((Place::File, opcode, range));
            }
        }
    }

    /// Takes the next step in the file: over a record that is returned, into a chunk, over damage,
    /// or to the end.
    fn next_in_file(&mut self) -> Option<(u8, Range<usize>)> {
        if self.at == self.bytes.len() {
            self.end(Damage::NoEnd);
            return None;
        }
        if self.at < MAGIC.len() {
            self.go_on();
            return None;
        }
        let frame = record::frame(&self.bytes, self.at);
        // Bytes with a chunk's header are a chunk even where opcode or length differ.
        if let Some(chunk) = record::chunk_header(&self.bytes, self.at) {
            let is_framed = frame == Some((op::CHUNK, self.at + FRAME_BYTES..chunk.end));
            let is_believed = is_framed && (chunk.is_checked || !self.is_strict);
            if is_believed || self.is_chunk(chunk) {
                return self.open_chunk(chunk.end, is_framed);
            }
        }
        if let Some(end) = self.scan.attachment_end(&self.bytes, self.at) {
            let (at, range) = (self.at, self.at + FRAME_BYTES..end);
            if frame != Some((op::ATTACHMENT, range.clone())) {
                self.damages.push(Damage::Frame { at });
                self.is_strict = true;
            }
            self.at = end;
            return Some((op::ATTACHMENT, range));
        }
        let is_believed = |opcode, range: &Range<usize>| {
            !self.is_strict || record::is_of_journal(&self.bytes, opcode, range)
        };
        let frame = frame.filter(|(opcode, range)| {
            *opcode != 0
                && scan::is_plausible(&self.bytes, range.end)
                && is_believed(*opcode, range)
        });
        let Some((opcode, range)) = frame else {
            self.go_on();
            return None;
        };
        match opcode {
            op::CHUNK => return self.open_chunk(range.end, true),
            // Another record whose type was damaged has another length.
            op::DATA_END if range.len() == DATA_END_BYTES => {
                self.end_whole(range);
                return None;
            }
            // The record that ends the data section is missing.
            op::FOOTER if self.bytes.len() <= range.end + MAGIC.len() => {
                self.end(Damage::NoEnd);
                return None;
            }
            op::DATA_END | op::FOOTER => {
                self.go_on();
                return None;
            }
            _ => {}
        }
        self.at = range.end;
        Some((opcode, range))
    }

    /// Whether bytes with a chunk's header but not its opcode or length are a chunk. Another record
    /// may contain numbers that look like the header of an uncompressed chunk.
    fn is_chunk(&mut self, header: ChunkHeader) -> bool {
        header.is_checked && (!header.is_plain || self.scan.passes(&self.bytes, self.at, header))
    }

    /// Unpacks the chunk from here to `end`; its records are returned only if all of it is valid.
    fn open_chunk(&mut self, end: usize, is_framed: bool) -> Option<(u8, Range<usize>)> {
        let at = self.at;
        self.chunk_at = 0;
        self.chunk.clear();
        if let Some(first) = self.first_of(at..end) {
            self.leave(at..end, is_framed);
            self.damages.push(Damage::Repeated { at, first });
            return None;
        }
        let limit = self.scan.budget.unpacked_left();
        let (work, result) = record::unpack_chunk(&self.bytes, at..end, limit, &mut self.chunk);
        self.scan.budget.take_unpacked(work);
        match result {
            Ok(()) => {
                self.remember(at..end);
                let header = record::chunk_header(&self.bytes, at);
                self.chunk_is_checked = header.is_some_and(|header| header.is_checked);
                self.leave(at..end, is_framed);
            }
            Err(_) if work > limit => self.end(Damage::Unpacked {
                at,
                bytes: self.bytes.len() - at,
            }),
            Err(error) => {
                // If its length is damaged, another record may begin before `end`.
                let is_end = scan::is_plausible(&self.bytes, end);
                let limit = if is_end { end } else { self.bytes.len() };
                let next = self.scan.find(&self.bytes, at + 1..limit);
                self.is_strict |= next.is_some() || !is_end;
                self.at = next.unwrap_or(limit);
                let reason = record::words(&error);
                let end = self.at;
                self.damages.push(Damage::Chunk { at, end, reason });
            }
        }
        None
    }

    /// Goes on behind a chunk that was read, now or before.
    fn leave(&mut self, chunk: Range<usize>, is_framed: bool) {
        self.at = chunk.end;
        if !is_framed {
            self.damages.push(Damage::Frame { at: chunk.start });
            self.is_strict = true;
            self.check_end(chunk.start);
        }
    }

    /// After a chunk whose record and header state different lengths: where neither leads to a
    /// record, searches for the next verified one, from the chunk's beginning on.
    fn check_end(&mut self, at: usize) {
        if scan::is_plausible(&self.bytes, self.at) {
            return;
        }
        let end = self.at;
        let next = self.scan.find(&self.bytes, at + 1..self.bytes.len());
        self.at = next.unwrap_or(end);
        if self.at > end {
            self.damages.push(Damage::Gap {
                at: end,
                end: self.at,
            });
        }
    }

    /// Offset of an identical chunk that was read before, if there is one.
    fn first_of(&self, chunk: Range<usize>) -> Option<usize> {
        let same = self.chunks.get(&self.key_of(chunk.clone()))?;
        let is_same = |first: &&usize| {
            let first = **first..**first + chunk.len();
            self.bytes[first] == self.bytes[chunk.clone()]
        };
        same.iter().find(is_same).copied()
    }

    /// Keeps a chunk that was read for [`Walk::first_of`].
    fn remember(&mut self, chunk: Range<usize>) {
        let key = self.key_of(chunk.clone());
        self.chunks.entry(key).or_default().push(chunk.start);
    }

    fn key_of(&self, chunk: Range<usize>) -> (usize, u64) {
        (chunk.len(), self.hasher.hash_one(&self.bytes[chunk]))
    }

    /// Continues at the next record that can be verified, if there is one.
    fn go_on(&mut self) {
        let (at, length) = (self.at, self.bytes.len());
        match self.scan.find(&self.bytes, at + 1..length) {
            Some(end) => {
                self.at = end;
                self.is_strict = true;
                self.damages.push(Damage::Gap { at, end });
            }
            None => self.end_unread(at),
        }
    }

    /// Ends the walk: nothing from `at` on is read.
    fn end_unread(&mut self, at: usize) {
        let bytes = self.bytes.len() - at;
        let budget = &self.scan.budget;
        self.end(if budget.is_late() {
            Damage::Late { at, bytes }
        } else if budget.is_spent() {
            Damage::Searched { at, bytes }
        } else {
            Damage::Cut { at, bytes }
        });
    }

    fn end(&mut self, damage: Damage) {
        self.ended = true;
        self.damages.push(damage);
    }

    /// Ends the walk at the record that ends the data section, and compares its checksum.
    fn end_whole(&mut self, body: Range<usize>) {
        self.ended = true;
        self.ended_whole = true;
        let saved = self.bytes.get(body).and_then(|body| body.try_into().ok());
        let Some(saved) = saved.map(u32::from_le_bytes) else {
            return self.damages.push(Damage::NoEnd);
        };
        if !self.verifies_data_section {
            return;
        }
        let calculated = crc32fast::hash(&self.bytes[..self.at]);
        if saved != 0 && saved != calculated {
            self.damages.push(Damage::Checksum {
                messages: self.unchecked,
                calculated,
                saved,
            });
        }
        if !self.bytes[self.at..].ends_with(MAGIC) {
            self.damages.push(Damage::NoEnd);
        }
    }
}
