//! What a file says at its end, without reading the rest of it.
//!
//! A file that was written to its end has a summary with a checksum: definitions, counts, and where things
//! are. With what is wanted of these a short file is put together, which is read as any other
//! ([`Container`]): a take of gigabytes is listed by a few kilobytes.

use std::io::{self, Read, Seek, SeekFrom};

use mcap::MAGIC;
use mcap::records::op;

use super::index::Container;
use super::record;
use super::summary::{END_BYTES, footer, is_verified};

/// Longest summary that is read, and longest record that it leads to.
const SUMMARY_BYTES: u64 = 16 << 20;
const RECORD_BYTES: u64 = 64 << 20;

/// Most metadata records that are read.
const METADATA: usize = 64;

/// What a file says at its end.
#[derive(Debug)]
pub struct Digest {
    /// How many messages there are.
    pub messages: u64,
    /// Its channels and metadata, and of its messages those in the last chunk that has any of the topic.
    pub container: Container,
}

/// Where something is in a file, and how long.
type Place = (u64, u64);

/// Reads the end of a file, its metadata, and the last chunk with messages on a topic, if there is one.
///
/// `None` where the file has no summary with a checksum that fits: then all of it must be read. Damage elsewhere in
/// the file is not seen.
pub fn digest(file: &mut (impl Read + Seek), topic: &str) -> io::Result<Option<Digest>> {
    let length = file.seek(SeekFrom::End(0))?;
    let Some(end) = length.checked_sub(END_BYTES as u64) else {
        return Ok(None);
    };
    let begins = read(file, (0, MAGIC.len() as u64))?;
    let Some((start, saved)) = footer(&read(file, (end, END_BYTES as u64))?) else {
        return Ok(None);
    };
    let section_length = length.checked_sub(start).filter(|it| *it <= SUMMARY_BYTES);
    let Some(section_length) = section_length.filter(|_| begins == MAGIC && saved != 0) else {
        return Ok(None);
    };
    let section = read(file, (start, section_length))?;
    if !is_verified(&section, saved) {
        return Ok(None);
    }
    let Some(found) = DigestFound::of(&section[..section.len() - END_BYTES], topic) else {
        return Ok(None);
    };
    let mut short = [MAGIC, &found.definitions[..]].concat();
    for place in found.metadata.into_iter().chain(found.chunk) {
        let is_inside = place.0.checked_add(place.1).is_some_and(|to| to <= start);
        if !is_inside || place.1 > RECORD_BYTES {
            return Ok(None);
        }
        short.extend(read(file, place)?);
    }
    let container = Container::new(short).ok();
    Ok(container.map(|container| Digest {
        messages: found.messages,
        container,
    }))
}

fn read(file: &mut (impl Read + Seek), (at, length): Place) -> io::Result<Vec<u8>> {
    file.seek(SeekFrom::Start(at))?;
    let mut bytes = Vec::new();
    file.take(length).read_to_end(&mut bytes)?;
    match bytes.len() as u64 == length {
        true => Ok(bytes),
        false => Err(io::ErrorKind::UnexpectedEof.into()),
    }
}

/// What a summary says.
struct DigestFound {
    messages: u64,
    definitions: Vec<u8>,
    metadata: Vec<Place>,
    chunk: Option<Place>,
}

impl DigestFound {
    /// `None` where it has no count of messages, or a record of it cannot be read.
    fn of(summary: &[u8], topic: &str) -> Option<Self> {
        let mut messages = None;
        let (mut definitions, mut metadata) = (Vec::new(), Vec::new());
        let (mut wanted, mut chunks) = (Vec::new(), Vec::new());
        let mut at = 0;
        while let Some((opcode, range)) = record::frame(summary, at) {
            let body = &summary[range.clone()];
            match opcode {
                op::SCHEMA | op::CHANNEL => {
                    definitions.extend_from_slice(&summary[at..range.end]);
                    if let Ok(record::Content::Channel(channel)) =
                        record::parse(opcode, summary, range.clone())
                        && channel.topic == topic
                    {
                        wanted.push(channel.id);
                    }
                }
                op::STATISTICS => messages = Some(number(body, 0)?),
                op::METADATA_INDEX if metadata.len() < METADATA => {
                    metadata.push((number(body, 0)?, number(body, 8)?));
                }
                op::CHUNK_INDEX => chunks.push(body),
                _ => {}
            }
            at = range.end;
        }
        let has_wanted = |chunk: &&&[u8]| channels(chunk).any(|id| wanted.contains(&id));
        let chunk = chunks.iter().rfind(has_wanted);
        let chunk = chunk.and_then(|chunk| Some((number(chunk, 16)?, number(chunk, 24)?)));
        Some(Self {
            messages: messages?,
            definitions,
            metadata,
            chunk,
        })
    }
}

/// The channels that have messages in a chunk, by its index: pairs of a number and an offset after the times,
/// the place and the length of the pairs.
fn channels(chunk_index: &[u8]) -> impl Iterator<Item = u16> {
    let pairs = chunk_index.get(32..).unwrap_or_default();
    let length = pairs.first_chunk().map_or(0, |it| u32::from_le_bytes(*it));
    let pairs = pairs.get(4..).unwrap_or_default();
    let pairs = pairs.get(..length as usize).unwrap_or_default();
    let ids = pairs.chunks_exact(2 + 8);
    ids.map(|pair| u16::from_le_bytes([pair[0], pair[1]]))
}

fn number(body: &[u8], at: usize) -> Option<u64> {
    let bytes = body.get(at..)?.first_chunk()?;
    Some(u64::from_le_bytes(*bytes))
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    const RECORDING: &[u8] = include_bytes!("../../../recordings/pencil_tip.mcap");

    fn said(bytes: &[u8], topic: &str) -> Option<Digest> {
        digest(&mut Cursor::new(bytes), topic).ok().flatten()
    }

    #[test]
    fn the_end_says_what_the_whole_says() {
        let whole = Container::new(RECORDING.to_vec()).expect("MCAP");
        let topic = "/tracker/pencil/pose";
        let found = said(RECORDING, topic).expect("a summary");
        assert_eq!(found.messages, whole.message_count());
        assert_eq!(found.container.metadata(), whole.metadata());
        let mut walk = found.container.walk();
        let mut of_topic = 0;
        while let Some(message) = walk.next_message() {
            let channel = &whole.channels()[&message.channel_id];
            of_topic += usize::from(channel.topic == topic);
        }
        assert!(of_topic > 0);
        assert_eq!(
            said(RECORDING, "/none")
                .expect("one")
                .container
                .message_count(),
            0
        );
        // Cut off anywhere it is not believed.
        for length in (0..RECORDING.len()).step_by(97) {
            assert!(said(&RECORDING[..length], topic).is_none(), "{length}");
        }
    }

    #[test]
    fn whatever_is_in_the_end_it_is_noticed_or_harmless() {
        let whole = said(RECORDING, "/none").expect("a summary");
        let (start, _) = footer(RECORDING).expect("a footer");
        let start = start as usize;
        for at in start..RECORDING.len() {
            for bit in 0..8 {
                let mut bytes = RECORDING.to_vec();
                bytes[at] ^= 1 << bit;
                if let Some(found) = said(&bytes, "/none") {
                    assert_eq!(found.messages, whole.messages, "{at}");
                }
            }
        }
        // Numbers that lie, with a checksum that fits.
        for at in start..RECORDING.len() - END_BYTES {
            for byte in [0, 0x7f, 0xff] {
                let mut bytes = RECORDING.to_vec();
                bytes[at] = byte;
                let end = bytes.len() - MAGIC.len() - 4;
                let saved = crc32fast::hash(&bytes[start..end]).to_le_bytes();
                bytes[end..end + 4].copy_from_slice(&saved);
                let _ = said(&bytes, "/tracker/pencil/pose");
            }
        }
    }
}
