//! The contents of an MCAP file besides its messages: channels, schemas, attachments, metadata,
//! damage.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

use mcap::MAGIC;
use thiserror::Error;

use super::budget::Reading;
use super::damage::{Damage, Damages};
use super::record::Content;
use super::summary;
use super::walk::Walk;

/// Why bytes are not an MCAP file at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum ContainerError {
    /// There are none.
    #[error("the file is empty")]
    Empty,
    /// They begin with something else, and nothing in them is a record that can be verified.
    #[error("not an MCAP file: it does not begin with the MCAP magic bytes")]
    NotMcap,
    /// Nothing follows the magic bytes, or in a journal no record that can be read.
    #[error("there is nothing in it: no record follows the MCAP magic bytes")]
    NoRecord,
}

/// A schema of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Schema {
    /// Such as `foxglove.PoseInFrame`.
    pub name: String,
    /// Such as `protobuf`.
    pub encoding: String,
    /// The definition.
    pub data: Vec<u8>,
}

/// A channel of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Its topic; several channels may share one.
    pub topic: String,
    /// Its schema, if it has one.
    pub schema_id: Option<u16>,
    /// Such as `protobuf`.
    pub message_encoding: String,
    /// Whatever its writer noted.
    pub metadata: BTreeMap<String, String>,
    /// How many messages it has.
    pub messages: u64,
}

/// An attachment of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attachment {
    /// When it was recorded \[ns\].
    pub log_time: u64,
    /// When it was made \[ns\].
    pub create_time: u64,
    /// Its name; not necessarily unique.
    pub name: String,
    /// Its media type.
    pub media_type: String,
    data: Range<usize>,
}

/// A metadata record of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Metadata {
    /// Its name; not necessarily unique.
    pub name: String,
    /// Its pairs.
    pub pairs: BTreeMap<String, String>,
}

/// An MCAP file in memory, walked through once.
#[derive(Clone, Debug)]
pub struct Container {
    bytes: Arc<Vec<u8>>,
    profile: String,
    schemas: BTreeMap<u16, Schema>,
    channels: BTreeMap<u16, Channel>,
    attachments: Vec<Attachment>,
    metadata: Vec<Metadata>,
    messages: u64,
    log_times: Option<(u64, u64)>,
    is_sorted: bool,
    damages: Damages,
    reading: Reading,
}

/// Limit of the lengths of all definitions that are kept: this multiple of the file's
/// size plus [`DEFINED_BYTES`].
const DEFINED_SHARE: usize = 4;
const DEFINED_BYTES: usize = 4 << 20;

/// What is known of the messages of a channel, defined or not.
#[derive(Clone, Copy)]
struct Tally {
    /// Offset of the first, of its chunk if it is in one.
    at: usize,
    messages: u64,
    /// Least and greatest log time [ns].
    log_times: (u64, u64),
}

/// What a walk gathers before it is known what is defined.
struct Gathered {
    tallies: BTreeMap<u16, Tally>,
    /// Channels whose schema did not come before them, the first of each id.
    waiting: BTreeMap<u16, mcap::records::Channel>,
    /// What is defined twice, differently: `channel` or `schema`, and its id.
    redefined: BTreeSet<(&'static str, u16)>,
    /// Definitions for which there is no place, likewise.
    refused: BTreeSet<(&'static str, u16)>,
    /// How long definitions may still be.
    defined_left: usize,
    last_log_time: u64,
}

impl Gathered {
    fn new(bytes: usize) -> Self {
        Self {
            tallies: BTreeMap::new(),
            waiting: BTreeMap::new(),
            redefined: BTreeSet::new(),
            refused: BTreeSet::new(),
            defined_left: bytes
                .saturating_mul(DEFINED_SHARE)
                .saturating_add(DEFINED_BYTES),
            last_log_time: 0,
        }
    }

    /// Whether there is a place for a definition that is not known yet. None is given to one that was
    /// refused before.
    fn has_place(&mut self, what: &'static str, id: u16, length: usize) -> bool {
        let left = self.defined_left.checked_sub(length);
        if left.is_none() {
            self.refused.insert((what, id));
        }
        self.defined_left = left.unwrap_or(self.defined_left);
        left.is_some() && !self.refused.contains(&(what, id))
    }
}

/// Length of what is kept of a channel.
fn length_of(channel: &mcap::records::Channel) -> usize {
    let pairs = channel.metadata.iter();
    let pairs = pairs.map(|(key, value)| 8 + key.len() + value.len());
    channel.topic.len() + channel.message_encoding.len() + pairs.sum::<usize>()
}

impl Container {
    /// All of the file.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Walks through the bytes of a file. Damage is no error: what can be read is there, and
    /// [`Container::damages`] says what cannot.
    pub fn new(bytes: Vec<u8>) -> Result<Self, ContainerError> {
        Self::read(bytes, Reading::default())
    }

    /// The same of a journal of a live take ([`Reading::is_journal`]).
    pub fn of_journal(bytes: Vec<u8>) -> Result<Self, ContainerError> {
        let is_journal = true;
        Self::read(
            bytes,
            Reading {
                is_journal,
                ..Reading::default()
            },
        )
    }

    /// The same, read in a way that is given.
    pub fn read(bytes: Vec<u8>, reading: Reading) -> Result<Self, ContainerError> {
        if bytes.is_empty() {
            return Err(ContainerError::Empty);
        }
        let has_magic = bytes.starts_with(MAGIC);
        let bytes = Arc::new(bytes);
        let mut container = Self {
            bytes: Arc::clone(&bytes),
            profile: String::new(),
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            attachments: Vec::new(),
            metadata: Vec::new(),
            messages: 0,
            log_times: None,
            is_sorted: true,
            damages: Damages::default(),
            reading,
        };
        let mut walk = Walk::verifying(Arc::clone(&bytes), reading);
        let mut gathered = Gathered::new(bytes.len());
        let mut is_anything = false;
        while let Some((_, content)) = walk.next_content() {
            is_anything = true;
            container.note(content, walk.offset(), &mut gathered);
        }
        if !is_anything && !has_magic {
            return Err(ContainerError::NotMcap);
        }
        // Of other files than journals, what is there and cannot be read is damage.
        let has_nothing = reading.is_journal || bytes.len() == MAGIC.len();
        if !is_anything && !walk.is_ended_whole() && has_nothing {
            return Err(ContainerError::NoRecord);
        }
        container.damages = walk.into_damages();
        container.conclude(gathered);
        Ok(container)
    }

    /// The messages, from the first on.
    pub fn walk(&self) -> Walk {
        Walk::new(Arc::clone(&self.bytes), self.reading)
    }

    /// The profile in the header.
    pub fn profile(&self) -> &str {
        &self.profile
    }

    /// The schemas, by id.
    pub fn schemas(&self) -> &BTreeMap<u16, Schema> {
        &self.schemas
    }

    /// The channels, by id.
    pub fn channels(&self) -> &BTreeMap<u16, Channel> {
        &self.channels
    }

    /// The channel's schema.
    pub fn schema_of(&self, channel: &Channel) -> Option<&Schema> {
        self.schemas.get(&channel.schema_id?)
    }

    /// The topics, each once, in alphabetical order.
    pub fn topics(&self) -> BTreeSet<&str> {
        self.channels
            .values()
            .map(|channel| channel.topic.as_str())
            .collect()
    }

    /// The attachments, in file order.
    pub fn attachments(&self) -> &[Attachment] {
        &self.attachments
    }

    /// The content of one of this file's attachments.
    pub fn attachment_data(&self, attachment: &Attachment) -> &[u8] {
        &self.bytes[attachment.data.clone()]
    }

    /// The metadata records, in file order.
    pub fn metadata(&self) -> &[Metadata] {
        &self.metadata
    }

    /// Messages of defined channels.
    pub fn message_count(&self) -> u64 {
        self.messages
    }

    /// Least and greatest log time of a message \[ns\].
    pub fn log_times(&self) -> Option<(u64, u64)> {
        self.log_times
    }

    /// Whether messages lie in the file in order of log time.
    pub fn is_sorted(&self) -> bool {
        self.is_sorted
    }

    /// Size of the file.
    pub fn byte_count(&self) -> usize {
        self.bytes.len()
    }

    /// What is wrong with it.
    pub fn damages(&self) -> &Damages {
        &self.damages
    }

    fn note(&mut self, content: Content, at: usize, gathered: &mut Gathered) {
        match content {
            Content::Header { profile } => self.profile = profile,
            Content::Schema { header, data } => {
                let schema = Schema {
                    name: header.name,
                    encoding: header.encoding,
                    data,
                };
                let length = schema.name.len() + schema.encoding.len() + schema.data.len();
                let is_new = !self.schemas.contains_key(&header.id);
                if is_new && !gathered.has_place("schema", header.id, length) {
                    return;
                }
                if !define(&mut self.schemas, header.id, schema) {
                    gathered.redefined.insert(("schema", header.id));
                }
            }
            Content::Channel(channel) => self.note_channel(channel, gathered),
            Content::Message { header, .. } => {
                let time = header.log_time;
                let tally = gathered.tallies.entry(header.channel_id).or_insert(Tally {
                    at,
                    messages: 0,
                    log_times: (time, time),
                });
                tally.messages += 1;
                let (first, last) = tally.log_times;
                tally.log_times = (first.min(time), last.max(time));
                self.is_sorted &= time >= gathered.last_log_time;
                gathered.last_log_time = gathered.last_log_time.max(time);
            }
            Content::Attachment {
                log_time,
                create_time,
                name,
                media_type,
                data,
            } => self.attachments.push(Attachment {
                log_time,
                create_time,
                name,
                media_type,
                data,
            }),
            Content::Metadata(metadata) => self.metadata.push(Metadata {
                name: metadata.name,
                pairs: metadata.metadata,
            }),
            Content::Other => {}
        }
    }

    fn note_channel(&mut self, record: mcap::records::Channel, gathered: &mut Gathered) {
        let schema_id = (record.schema_id != 0).then_some(record.schema_id);
        let id = record.id;
        let is_new = !self.channels.contains_key(&id) && !gathered.waiting.contains_key(&id);
        if is_new && !gathered.has_place("channel", id, length_of(&record)) {
            return;
        }
        if schema_id.is_some_and(|schema| !self.schemas.contains_key(&schema)) {
            gathered.waiting.entry(id).or_insert(record);
            return;
        }
        let channel = Channel {
            topic: record.topic,
            schema_id,
            message_encoding: record.message_encoding,
            metadata: record.metadata,
            messages: 0,
        };
        if !define(&mut self.channels, id, channel) {
            gathered.redefined.insert(("channel", id));
        }
    }

    /// Ends the walk: takes definitions that are still missing from the summary, and counts
    /// messages.
    fn conclude(&mut self, mut gathered: Gathered) {
        let is_lost = |id: &u16| !self.channels.contains_key(id);
        if !gathered.waiting.is_empty() || gathered.tallies.keys().any(is_lost) {
            for content in summary::definitions(&Arc::clone(&self.bytes)) {
                self.note(content, 0, &mut gathered);
            }
        }
        let waiting = std::mem::take(&mut gathered.waiting);
        let has_schema = |channel: &mcap::records::Channel| {
            channel.schema_id == 0 || self.schemas.contains_key(&channel.schema_id)
        };
        let (found, lost): (Vec<_>, Vec<_>) = waiting.into_values().partition(has_schema);
        for channel in found {
            self.note_channel(channel, &mut gathered);
        }
        for (what, id) in gathered.redefined {
            self.damages.push(Damage::Redefined { what, id });
        }
        for (what, id) in gathered.refused {
            self.damages.push(Damage::Definitions { what, id });
        }
        for channel in lost {
            let (id, schema) = (channel.id, channel.schema_id);
            if !self.channels.contains_key(&id) {
                self.damages.push(Damage::NoSchema { id, schema });
            }
        }
        for (id, tally) in gathered.tallies {
            let Tally {
                at,
                messages,
                log_times: (first, last),
            } = tally;
            let Some(channel) = self.channels.get_mut(&id) else {
                self.damages.push(Damage::NoChannel { at, messages, id });
                continue;
            };
            channel.messages = messages;
            self.messages += messages;
            let (least, greatest) = self.log_times.unwrap_or((first, last));
            self.log_times = Some((least.min(first), greatest.max(last)));
        }
    }
}

/// Enters a definition; writers may repeat one, but not change it. Whether they do.
fn define<T: PartialEq>(known: &mut BTreeMap<u16, T>, id: u16, value: T) -> bool {
    match known.get(&id) {
        None => known.insert(id, value).is_none(),
        Some(first) => *first == value,
    }
}
