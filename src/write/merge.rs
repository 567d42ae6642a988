//! What came in, unchanged, and ours beside it, in order of log time.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;

use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, McapResult, Writer};

use super::atomic::AtomicFile;
use super::dialect::Dialect;
use super::error::WriteError;
use super::{options, topics};
use crate::wire::container::{Container, Message};
use crate::wire::encode::SchemaRecord;

/// A channel of ours.
pub(super) struct OurChannel {
    pub(super) topic: String,
    pub(super) schema: SchemaRecord,
    pub(super) message_encoding: &'static str,
    /// By it a later run knows what to replace.
    pub(super) metadata: BTreeMap<String, String>,
}

/// A message of ours, on a channel by its index.
pub(super) struct OurMessage {
    pub(super) channel: usize,
    pub(super) log_time: u64,
    pub(super) data: Vec<u8>,
}

/// What is added to an input.
#[derive(Default)]
pub(super) struct Additions {
    pub(super) channels: Vec<OurChannel>,
    /// In any order; those of one log time stay in theirs.
    pub(super) messages: Vec<OurMessage>,
    /// Name and content of an attachment, if there is one to add.
    pub(super) scene: Option<(&'static str, Vec<u8>)>,
    /// Which of the input's messages stay.
    pub(super) kept: Kept,
}

/// Which messages of an input stay; all of them by default.
#[derive(Default)]
pub(super) struct Kept {
    /// Those logged then \[ns\].
    pub(super) log_times: Option<RangeInclusive<u64>>,
    /// All but those, by their place in the file, from 0.
    pub(super) without: BTreeSet<u64>,
}

impl Kept {
    fn has(&self, place: u64, log_time: u64) -> bool {
        let times = self.log_times.as_ref();
        times.is_none_or(|times| times.contains(&log_time)) && !self.without.contains(&place)
    }
}

/// Channels of an earlier estimate: they are replaced, not doubled.
pub(super) fn replaced(input: &Container) -> BTreeSet<u16> {
    let channels = input.channels().iter();
    channels
        .filter(|(_, channel)| topics::is_ours(&channel.metadata))
        .map(|(&id, _)| id)
        .collect()
}

/// Whether an earlier run has put its estimate in.
pub fn has_estimate(input: &Container) -> bool {
    !replaced(input).is_empty()
}

/// Writes the merge of both, what is added in the input's [`Dialect`], and gives the file its final
/// name. Returns how many of the input's messages are in it.
pub(super) fn write(
    file: AtomicFile,
    input: &Container,
    dropped_attachment: Option<&str>,
    mut additions: Additions,
) -> Result<u64, WriteError> {
    additions.messages.sort_by_key(|message| message.log_time);
    let replaced = replaced(input);
    let path = file.path().to_owned();
    let copied = options::writer(file, Dialect::of(input).profile())
        .and_then(|mut writer| {
            copy_attachments(&mut writer, input, dropped_attachment)?;
            if let Some((name, data)) = &additions.scene {
                writer.attach(&Attachment {
                    log_time: 0,
                    create_time: 0,
                    name: (*name).to_owned(),
                    media_type: "application/toml".to_owned(),
                    data: Cow::Borrowed(data),
                })?;
            }
            let ours = define(&mut writer, input, &replaced, &additions.channels)?;
            let mut merge = Merge {
                writer,
                sequences: vec![0; ours.len()],
                ours,
                messages: additions.messages.into_iter().peekable(),
            };
            let copied = merge.copy(input, &replaced, &additions.kept)?;
            merge.write_ours_before(None)?;
            merge.writer.finish()?;
            Ok((copied, merge.writer))
        })
        .map_err(WriteError::mcap(&path))?;
    let (copied, writer) = copied;
    writer.into_inner().commit()?;
    Ok(copied)
}

fn copy_attachments(
    writer: &mut Writer<AtomicFile>,
    input: &Container,
    dropped: Option<&str>,
) -> McapResult<()> {
    for attachment in input.attachments() {
        if dropped == Some(attachment.name.as_str()) {
            continue;
        }
        writer.attach(&Attachment {
            log_time: attachment.log_time,
            create_time: attachment.create_time,
            name: attachment.name.clone(),
            media_type: attachment.media_type.clone(),
            data: Cow::Borrowed(input.attachment_data(attachment)),
        })?;
    }
    for metadata in input.metadata() {
        writer.write_metadata(&Metadata {
            name: metadata.name.clone(),
            metadata: metadata.pairs.clone(),
        })?;
    }
    Ok(())
}

/// Defines the input's schemas and channels under their own numbers, then ours under free
/// ones. Returns the numbers of ours.
fn define(
    writer: &mut Writer<AtomicFile>,
    input: &Container,
    replaced: &BTreeSet<u16>,
    ours: &[OurChannel],
) -> McapResult<Vec<u16>> {
    let users = |schema: u16| {
        let channels = input.channels().iter();
        channels.filter(move |(_, channel)| channel.schema_id == Some(schema))
    };
    for (&id, schema) in input.schemas() {
        // What only the earlier estimate used goes with it.
        if users(id).next().is_some() && users(id).all(|(user, _)| replaced.contains(user)) {
            continue;
        }
        writer.add_schema_with_id(id, &schema.name, &schema.encoding, &schema.data)?;
    }
    for (&id, channel) in input.channels() {
        if replaced.contains(&id) {
            continue;
        }
        writer.add_channel_with_id(
            id,
            channel.schema_id.unwrap_or(0),
            &channel.topic,
            &channel.message_encoding,
            &channel.metadata,
        )?;
    }
    let schemas = ours
        .iter()
        .map(|channel| {
            let schema = &channel.schema;
            writer.add_schema(&schema.name, &schema.encoding, &schema.data)
        })
        .collect::<McapResult<Vec<_>>>()?;
    ours.iter()
        .zip(schemas)
        .map(|(channel, schema)| {
            let (topic, encoding) = (&channel.topic, channel.message_encoding);
            writer.add_channel(schema, topic, encoding, &channel.metadata)
        })
        .collect()
}

struct Merge {
    writer: Writer<AtomicFile>,
    ours: Vec<u16>,
    /// The next sequence number on each of our channels.
    sequences: Vec<u32>,
    messages: std::iter::Peekable<std::vec::IntoIter<OurMessage>>,
}

impl Merge {
    /// Copies the input's messages in order of log time, ours in between. An input that is not
    /// in order is sorted first, in memory; messages of one log time stay in their order.
    fn copy(
        &mut self,
        input: &Container,
        replaced: &BTreeSet<u16>,
        kept: &Kept,
    ) -> McapResult<u64> {
        let mut place = 0;
        let mut is_wanted = |message: &Message| {
            place += 1;
            input.channels().contains_key(&message.channel_id)
                && !replaced.contains(&message.channel_id)
                && kept.has(place - 1, message.log_time)
        };
        let mut copied = 0;
        let mut walk = input.walk();
        if input.is_sorted() {
            while let Some(message) = walk.next_message() {
                if is_wanted(&message) {
                    self.write_theirs(&message)?;
                    copied += 1;
                }
            }
            return Ok(copied);
        }
        let mut messages: BTreeMap<u64, Vec<(Message<'static>, Vec<u8>)>> = BTreeMap::new();
        while let Some(message) = walk.next_message() {
            if is_wanted(&message) {
                let data = message.data.to_vec();
                let header = Message {
                    data: &[],
                    ..message
                };
                messages
                    .entry(message.log_time)
                    .or_default()
                    .push((header, data));
            }
        }
        for (header, data) in messages.into_values().flatten() {
            self.write_theirs(&Message {
                data: &data,
                ..header
            })?;
            copied += 1;
        }
        Ok(copied)
    }

    fn write_theirs(&mut self, message: &Message) -> McapResult<()> {
        self.write_ours_before(Some(message.log_time))?;
        let header = MessageHeader {
            channel_id: message.channel_id,
            sequence: message.sequence,
            log_time: message.log_time,
            publish_time: message.publish_time,
        };
        self.writer.write_to_known_channel(&header, message.data)
    }

    /// Writes our messages that come before `log_time`; all that are left, if there is none.
    fn write_ours_before(&mut self, log_time: Option<u64>) -> McapResult<()> {
        let is_due = |message: &OurMessage| log_time.is_none_or(|time| message.log_time < time);
        while let Some(message) = self.messages.next_if(is_due) {
            let sequence = self.sequences[message.channel];
            self.sequences[message.channel] = sequence.wrapping_add(1);
            let header = MessageHeader {
                channel_id: self.ours[message.channel],
                sequence,
                log_time: message.log_time,
                publish_time: message.log_time,
            };
            self.writer.write_to_known_channel(&header, &message.data)?;
        }
        Ok(())
    }
}
