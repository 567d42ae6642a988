//! Single records: their frames and their contents.
//!
//! Parsed here, not by the crate `mcap`. The crate's parser allocates the length that a
//! string claims before it checks whether the bytes exist, up to 4 GB for one flipped bit; it
//! slices out of bounds where an attachment is too short for its checksum; its linear reader counts
//! below zero where a record reaches out of an uncompressed chunk.

use std::collections::BTreeMap;
use std::io::{self, ErrorKind, Read};
use std::ops::Range;

use mcap::McapError;
use mcap::records::{Channel, MessageHeader, Metadata, SchemaHeader, op};

/// Bytes of a record's opcode and length.
pub(super) const FRAME_BYTES: usize = 1 + 8;

/// Largest chunk, decompressed. A file's own figure is not trusted: a flipped bit would make the
/// reader allocate hundreds of gigabytes.
const CHUNK_LIMIT_BYTES: usize = 64 << 20;

/// Largest window of a chunk compressed by zstd, as a power of two: what its decoder allocates. The
/// default writes 2 MiB, the highest level 128 MiB.
const ZSTD_WINDOW_LOG: u32 = 26;

/// Longest name of a topic, schema or encoding: there may be 65,535 of each, and each is listed.
const NAME_LIMIT_BYTES: usize = 1024;

/// Longest definition of a schema: a writer keeps two more copies of it.
const SCHEMA_LIMIT_BYTES: usize = 4 << 20;

/// Longest definition of a channel: in memory its pairs are ten times as long.
const CHANNEL_LIMIT_BYTES: usize = 1 << 20;

/// Bytes before a message's data: channel, sequence number and two times.
const MESSAGE_HEADER_BYTES: usize = 2 + 4 + 8 + 8;

/// Bytes of an index entry: log time and offset of a message.
const INDEX_ENTRY_BYTES: usize = 8 + 8;

/// Bytes at the start of a chunk: start and end time.
const CHUNK_TIMES_BYTES: usize = 8 + 8;

/// The compressions of chunks, each with the first bytes of its data.
const COMPRESSIONS: [(&[u8], &[u8]); 3] = [
    (b"", b""),
    (b"zstd", &[0x28, 0xb5, 0x2f, 0xfd]),
    (b"lz4", &[0x04, 0x22, 0x4d, 0x18]),
];

/// The first opcode that the format leaves for private records.
pub(super) const PRIVATE: u8 = 0x80;

/// Opcode of enact's private record in a chunk. After [`REPEATED`] it holds schema and channel
/// records that the file already contains, so that the chunk can be read without earlier ones.
pub const REPEATS: u8 = 0xe0;

/// First bytes of such a record: others may use the same opcode.
pub const REPEATED: &[u8] = b"enact repeats\n";

/// A record's content; its data are a range of the bytes it was read from.
pub(super) enum Content {
    Header {
        profile: String,
    },
    Schema {
        header: SchemaHeader,
        data: Vec<u8>,
    },
    Channel(Channel),
    Message {
        header: MessageHeader,
        data: Range<usize>,
    },
    Attachment {
        log_time: u64,
        create_time: u64,
        name: String,
        media_type: String,
        data: Range<usize>,
    },
    Metadata(Metadata),
    /// Indexes, statistics, private records: nothing that is used.
    Other,
}

/// The record at `at`: its opcode and the range of its body. `None` where it is not whole.
pub(super) fn frame(bytes: &[u8], at: usize) -> Option<(u8, Range<usize>)> {
    let frame: [u8; FRAME_BYTES] = *bytes.get(at..)?.first_chunk()?;
    let [opcode, length @ ..] = frame;
    let length = usize::try_from(u64::from_le_bytes(length)).ok()?;
    let start = at + FRAME_BYTES;
    let end = start.checked_add(length)?;
    (end <= bytes.len()).then_some((opcode, start..end))
}

/// Parses the record whose body is `range` of `bytes`.
pub(super) fn parse(opcode: u8, bytes: &[u8], range: Range<usize>) -> Result<Content, McapError> {
    let body = &bytes[range.clone()];
    match opcode {
        op::MESSAGE => {
            let at = &mut 0;
            let header = MessageHeader {
                channel_id: u16::from_le_bytes(take(body, at)?),
                sequence: u32::from_le_bytes(take(body, at)?),
                log_time: u64::from_le_bytes(take(body, at)?),
                publish_time: u64::from_le_bytes(take(body, at)?),
            };
            Ok(Content::Message {
                header,
                data: range.start + MESSAGE_HEADER_BYTES..range.end,
            })
        }
        op::ATTACHMENT => attachment(bytes, range),
        op::HEADER => Ok(Content::Header {
            profile: text(body, &mut 0)?,
        }),
        op::MESSAGE_INDEX => {
            let entries = body.get(2..).ok_or(McapError::UnexpectedEof)?;
            match prefixed(entries, &mut 0)?.len() % INDEX_ENTRY_BYTES {
                0 => Ok(Content::Other),
                _ => Err(McapError::UnexpectedEof),
            }
        }
        op::SCHEMA => schema(body),
        op::CHANNEL => channel(body),
        op::METADATA => {
            let mut at = 0;
            Ok(Content::Metadata(Metadata {
                name: text(body, &mut at)?,
                metadata: pairs(body, &mut at)?,
            }))
        }
        _ => Ok(Content::Other),
    }
}

/// Whether records of that type may be in chunks: definitions, messages, and private ones. The data
/// of others would be ranges of the file.
pub(super) fn belongs_into_chunk(opcode: u8) -> bool {
    matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE | PRIVATE..)
}

fn schema(body: &[u8]) -> Result<Content, McapError> {
    if body.len() > SCHEMA_LIMIT_BYTES {
        return Err(refused(format!(
            "a schema of {} bytes, at most {SCHEMA_LIMIT_BYTES} are read",
            body.len()
        )));
    }
    let mut at = 0;
    let header = SchemaHeader {
        id: u16::from_le_bytes(take(body, &mut at)?),
        name: name(body, &mut at)?,
        encoding: name(body, &mut at)?,
    };
    if header.id == 0 {
        return Err(McapError::InvalidSchemaId);
    }
    let data = prefixed(body, &mut at)?.to_vec();
    Ok(Content::Schema { header, data })
}

fn channel(body: &[u8]) -> Result<Content, McapError> {
    if body.len() > CHANNEL_LIMIT_BYTES {
        return Err(refused(format!(
            "a channel of {} bytes, at most {CHANNEL_LIMIT_BYTES} are read",
            body.len()
        )));
    }
    let mut at = 0;
    Ok(Content::Channel(Channel {
        id: u16::from_le_bytes(take(body, &mut at)?),
        schema_id: u16::from_le_bytes(take(body, &mut at)?),
        topic: name(body, &mut at)?,
        message_encoding: name(body, &mut at)?,
        metadata: pairs(body, &mut at)?,
    }))
}

fn attachment(bytes: &[u8], range: Range<usize>) -> Result<Content, McapError> {
    let body = &bytes[range.clone()];
    let mut at = 0;
    let log_time = u64::from_le_bytes(take(body, &mut at)?);
    let create_time = u64::from_le_bytes(take(body, &mut at)?);
    let name = text(body, &mut at)?;
    let media_type = text(body, &mut at)?;
    let length = usize::try_from(u64::from_le_bytes(take(body, &mut at)?))
        .map_err(|_| McapError::UnexpectedEof)?;
    let start = at;
    at = start
        .checked_add(length)
        .filter(|&end| end <= body.len())
        .ok_or(McapError::UnexpectedEof)?;
    let end = at;
    let saved = u32::from_le_bytes(take(body, &mut at)?);
    if saved != 0 {
        let calculated = crc32fast::hash(&body[..end]);
        if calculated != saved {
            return Err(McapError::BadAttachmentCrc { saved, calculated });
        }
    }
    Ok(Content::Attachment {
        log_time,
        create_time,
        name,
        media_type,
        data: range.start + start..range.start + end,
    })
}

fn take<const N: usize>(body: &[u8], at: &mut usize) -> Result<[u8; N], McapError> {
    let bytes = body.get(*at..).and_then(|rest| rest.first_chunk());
    let bytes = bytes.ok_or(McapError::UnexpectedEof)?;
    *at += N;
    Ok(*bytes)
}

/// Bytes after their length in 32 bits.
fn prefixed<'a>(body: &'a [u8], at: &mut usize) -> Result<&'a [u8], McapError> {
    let length = u32::from_le_bytes(take(body, at)?) as usize;
    let bytes = at
        .checked_add(length)
        .and_then(|end| body.get(*at..end))
        .ok_or(McapError::UnexpectedEof)?;
    *at += length;
    Ok(bytes)
}

fn text(body: &[u8], at: &mut usize) -> Result<String, McapError> {
    let bytes = prefixed(body, at)?.to_vec();
    String::from_utf8(bytes).map_err(|error| {
        let error = std::io::Error::new(std::io::ErrorKind::InvalidData, error);
        McapError::Io(error)
    })
}

/// A text of at most [`NAME_LIMIT_BYTES`].
fn name(body: &[u8], at: &mut usize) -> Result<String, McapError> {
    let length = prefixed(body, &mut at.clone())?.len();
    if length > NAME_LIMIT_BYTES {
        return Err(refused(format!(
            "a name of {length} bytes, at most {NAME_LIMIT_BYTES} are read"
        )));
    }
    text(body, at)
}

/// What is wrong, in words: of an error of I/O the crate says only that there is one.
pub(super) fn words(error: &McapError) -> String {
    match error {
        McapError::Io(error) => error.to_string(),
        other => other.to_string(),
    }
}

/// What is valid MCAP and is not read.
pub(super) fn refused(reason: String) -> McapError {
    McapError::Io(io::Error::new(ErrorKind::InvalidData, reason))
}

fn pairs(body: &[u8], at: &mut usize) -> Result<BTreeMap<String, String>, McapError> {
    let inside = prefixed(body, at)?;
    let mut pairs = BTreeMap::new();
    let mut at = 0;
    while at < inside.len() {
        pairs.insert(text(inside, &mut at)?, text(inside, &mut at)?);
    }
    Ok(pairs)
}

/// Whether a record outside of chunks, other than a verified chunk or attachment, may be one that
/// the writer of journals makes: nothing in it is used. Its length is told twice in the header and
/// in indexes, so that one that is damaged does not lead past other records.
pub(super) fn is_of_journal(bytes: &[u8], opcode: u8, range: &Range<usize>) -> bool {
    let (body, at) = (&bytes[range.clone()], &mut 0);
    match opcode {
        // What is no valid one is reported as such; and the end of a file is recognised by length.
        op::CHUNK => chunk_header(bytes, range.start - FRAME_BYTES).is_none(),
        op::DATA_END | op::FOOTER => true,
        op::HEADER => {
            let is_first = range.start == mcap::MAGIC.len() + FRAME_BYTES;
            is_first && text(body, at).and_then(|_| text(body, at)).is_ok() && *at == body.len()
        }
        op::MESSAGE_INDEX => {
            let id = take::<2>(body, at);
            id.and_then(|_| prefixed(body, at)).is_ok() && *at == body.len()
        }
        _ => false,
    }
}

/// The attachment of a record at `at`, by its own lengths: where it ends, and the bytes that its
/// checksum is for. `None` where it has no checksum or does not end in the file.
pub(super) fn attachment_of(bytes: &[u8], at: usize) -> Option<(usize, Range<usize>)> {
    let start = at.checked_add(FRAME_BYTES)?;
    let body = bytes.get(start..)?;
    let mut from = 8 + 8;
    prefixed(body, &mut from).ok()?;
    prefixed(body, &mut from).ok()?;
    let length = usize::try_from(u64::from_le_bytes(take(body, &mut from).ok()?)).ok()?;
    let end = from.checked_add(length)?;
    let saved: [u8; 4] = take(body, &mut end.clone()).ok()?;
    (saved != [0; 4]).then_some((start + end + saved.len(), start..start + end))
}

/// A chunk's own header, which identifies it without its record's opcode and length.
#[derive(Clone, Copy)]
pub(super) struct ChunkHeader {
    /// Offset of the end of its data, where its record should end.
    pub(super) end: usize,
    /// Whether it has a checksum.
    pub(super) is_checked: bool,
    /// Length of its data in the file.
    pub(super) packed: usize,
    /// Whether the data are not compressed, so that their first bytes identify nothing.
    pub(super) is_plain: bool,
}

/// The chunk header of a record at `at`; `None` unless its compression is known, its data begin as
/// that compression requires, and they are complete.
pub(super) fn chunk_header(bytes: &[u8], at: usize) -> Option<ChunkHeader> {
    let record = bytes.get(at..)?;
    let mut from = FRAME_BYTES + CHUNK_TIMES_BYTES;
    let size = u64::from_le_bytes(take(record, &mut from).ok()?);
    let crc = u32::from_le_bytes(take(record, &mut from).ok()?);
    let name = prefixed(record, &mut from).ok()?;
    let packed = u64::from_le_bytes(take(record, &mut from).ok()?);
    let (name, magic) = COMPRESSIONS.iter().find(|(known, _)| *known == name)?;
    let packed = usize::try_from(packed).ok()?;
    let data = record.get(from..from.checked_add(packed)?)?;
    let is_plain = name.is_empty();
    let is_likely = packed > 0 && data.starts_with(magic) && (!is_plain || size == packed as u64);
    is_likely.then_some(ChunkHeader {
        end: at + from + packed,
        is_checked: crc != 0,
        packed,
        is_plain,
    })
}

/// Unpacks the chunk in `bytes[record]` into `records`, which holds whole verified records
/// afterwards, or nothing. Its record's opcode and length are ignored. Fails where it unpacks to
/// more than `limit` bytes, and says in any case how many it unpacked.
pub(super) fn unpack_chunk(
    bytes: &[u8],
    record: Range<usize>,
    limit: usize,
    records: &mut Vec<u8>,
) -> (usize, Result<(), McapError>) {
    records.clear();
    let result = unpack(&bytes[record], limit, records);
    let work = records.len();
    if result.is_err() {
        records.clear();
    }
    (work, result)
}

fn unpack(record: &[u8], limit: usize, records: &mut Vec<u8>) -> Result<(), McapError> {
    let mut at = FRAME_BYTES + CHUNK_TIMES_BYTES;
    let size = u64::from_le_bytes(take(record, &mut at)?);
    let saved = u32::from_le_bytes(take(record, &mut at)?);
    let compression = prefixed(record, &mut at)?;
    let packed_size = u64::from_le_bytes(take(record, &mut at)?);
    let wanted = usize::try_from(size).ok();
    let Some(wanted) = wanted.filter(|wanted| *wanted <= CHUNK_LIMIT_BYTES) else {
        return Err(McapError::ChunkTooLarge(size));
    };
    // A header of zeros looks like that of an empty chunk; its record then holds more than it
    // claims.
    let is_short = compression.is_empty() && packed_size != (record.len() - at) as u64;
    if is_short || (size == 0 && at < record.len()) {
        return Err(McapError::UnexpectedEoc);
    }
    let packed = usize::try_from(packed_size)
        .ok()
        .and_then(|length| record.get(at..at.checked_add(length)?))
        .ok_or(McapError::UnexpectedEoc)?;
    // One byte more shows that there is more than was claimed.
    let most = (wanted + 1).min(limit.saturating_add(1)) as u64;
    match compression {
        b"" => records.extend_from_slice(&packed[..packed.len().min(most as usize)]),
        b"zstd" => {
            let mut decoder = zstd::stream::read::Decoder::with_buffer(packed)?;
            decoder.window_log_max(ZSTD_WINDOW_LOG)?;
            decoder.take(most).read_to_end(records)?;
        }
        b"lz4" => unpack_lz4(packed, most, records)?,
        other => {
            let name = String::from_utf8_lossy(other).chars().take(32).collect();
            return Err(McapError::UnsupportedCompression(name));
        }
    }
    if records.len() > limit {
        return Err(refused(format!(
            "unpacks to more than the {limit} bytes that are left of the limit for this file"
        )));
    }
    if records.len() != wanted {
        return Err(McapError::UnexpectedEoc);
    }
    let calculated = crc32fast::hash(records);
    if saved != 0 && saved != calculated {
        return Err(McapError::BadChunkCrc { saved, calculated });
    }
    if !are_records(records) {
        return Err(McapError::UnexpectedEoc);
    }
    Ok(())
}

/// Unpacks frames of lz4, one after the other, up to `most` bytes in all.
fn unpack_lz4(mut packed: &[u8], most: u64, records: &mut Vec<u8>) -> io::Result<()> {
    while !packed.is_empty() && (records.len() as u64) < most {
        let before = (packed.len(), records.len());
        let left = most - records.len() as u64;
        lz4::Decoder::new(&mut packed)?
            .take(left)
            .read_to_end(records)?;
        if before == (packed.len(), records.len()) {
            return Err(ErrorKind::UnexpectedEof.into());
        }
    }
    Ok(())
}

/// Number of bytes before the first repeated record in a record of [`REPEATS`]; `None` for others.
pub(super) fn repeated(opcode: u8, body: &[u8]) -> Option<usize> {
    let records = body.strip_prefix(REPEATED)?;
    (opcode == REPEATS && are_records(records)).then_some(REPEATED.len())
}

/// Whether bytes are whole records, one after the other.
fn are_records(bytes: &[u8]) -> bool {
    let mut at = 0;
    while at < bytes.len() {
        let Some((_, range)) = frame(bytes, at) else {
            return false;
        };
        at = range.end;
    }
    true
}
