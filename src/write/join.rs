//! Several recordings as one, as of a bag that was split.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, McapResult, Writer};

use super::error::WriteError;
use super::merge::replaced;
use super::options;
use crate::wire::Container;

/// Recordings as one.
#[derive(Clone, Debug)]
pub struct Joined {
    /// An MCAP file.
    pub bytes: Vec<u8>,
    /// Messages that were in several of them, each of which is there once.
    pub doubles: u64,
}

/// A message of one of them.
struct Of {
    input: usize,
    header: MessageHeader,
    data: Vec<u8>,
}

/// Puts recordings together in order of log time. Channels that are the same are one, attachments and metadata that are
/// the same are there once; what an earlier estimate added is left out.
///
/// Fails where they are of different profiles, or have too many channels or schemas together.
pub fn joined(inputs: &[(PathBuf, &Container)]) -> Result<Joined, WriteError> {
    let Some((path, first)) = inputs.first() else {
        return Ok(Joined {
            bytes: Vec::new(),
            doubles: 0,
        });
    };
    if let Some((other, container)) = inputs
        .iter()
        .find(|(_, of)| of.profile() != first.profile())
    {
        return Err(WriteError::Profiles {
            path: other.clone(),
            profile: container.profile().to_owned(),
            other: path.clone(),
            expected: first.profile().to_owned(),
        });
    }
    write(path, inputs)
}

fn write(path: &Path, inputs: &[(PathBuf, &Container)]) -> Result<Joined, WriteError> {
    let failed = WriteError::mcap(path);
    let made = || -> McapResult<Joined> {
        let mut writer = options::writer(Cursor::new(Vec::new()), inputs[0].1.profile())?;
        attach(&mut writer, inputs)?;
        let mut messages: Vec<Of> = Vec::new();
        for (input, (_, container)) in inputs.iter().enumerate() {
            let channels = define(&mut writer, container)?;
            let mut walk = container.walk();
            while let Some(message) = walk.next_message() {
                let Some(&channel_id) = channels.get(&message.channel_id) else {
                    continue;
                };
                let header = MessageHeader {
                    channel_id,
                    sequence: message.sequence,
                    log_time: message.log_time,
                    publish_time: message.publish_time,
                };
                let data = message.data.to_vec();
                messages.push(Of {
                    input,
                    header,
                    data,
                });
            }
        }
        // Those of one log time stay in order.
        messages.sort_by_key(|of| of.header.log_time);
        let mut doubles = 0;
        let mut begin = 0;
        for (at, of) in messages.iter().enumerate() {
            if messages[begin].header.log_time != of.header.log_time {
                begin = at;
            }
            // Many of one log time are of one file: only the last few are looked at.
            let before = &messages[begin.max(at.saturating_sub(LOOKED_BACK))..at];
            let is_same = |other: &Of| {
                other.input != of.input
                    && other.header.channel_id == of.header.channel_id
                    && other.data == of.data
            };
            if before.iter().any(is_same) {
                doubles += 1;
                continue;
            }
            writer.write_to_known_channel(&of.header, &of.data)?;
        }
        writer.finish()?;
        Ok(Joined {
            bytes: writer.into_inner().into_inner(),
            doubles,
        })
    };
    made().map_err(failed)
}

/// Messages of one log time that are compared with one.
const LOOKED_BACK: usize = 64;

/// Defines the channels of an input, but those of an estimate; their new numbers by the old ones.
fn define(
    writer: &mut Writer<Cursor<Vec<u8>>>,
    input: &Container,
) -> McapResult<BTreeMap<u16, u16>> {
    let replaced = replaced(input);
    let mut numbers = BTreeMap::new();
    for (&id, channel) in input.channels() {
        if replaced.contains(&id) {
            continue;
        }
        let schema = match input.schema_of(channel) {
            Some(schema) => writer.add_schema(&schema.name, &schema.encoding, &schema.data)?,
            None => 0,
        };
        let number = writer.add_channel(
            schema,
            &channel.topic,
            &channel.message_encoding,
            &channel.metadata,
        )?;
        numbers.insert(id, number);
    }
    Ok(numbers)
}

fn attach(
    writer: &mut Writer<Cursor<Vec<u8>>>,
    inputs: &[(PathBuf, &Container)],
) -> McapResult<()> {
    let mut attached: Vec<(&str, &[u8])> = Vec::new();
    let mut noted: Vec<(&str, &BTreeMap<String, String>)> = Vec::new();
    for (_, input) in inputs {
        for attachment in input.attachments() {
            let data = input.attachment_data(attachment);
            if attached.contains(&(attachment.name.as_str(), data)) {
                continue;
            }
            attached.push((&attachment.name, data));
            writer.attach(&Attachment {
                log_time: attachment.log_time,
                create_time: attachment.create_time,
                name: attachment.name.clone(),
                media_type: attachment.media_type.clone(),
                data: Cow::Borrowed(data),
            })?;
        }
        for metadata in input.metadata() {
            if noted.contains(&(metadata.name.as_str(), &metadata.pairs)) {
                continue;
            }
            noted.push((&metadata.name, &metadata.pairs));
            writer.write_metadata(&Metadata {
                name: metadata.name.clone(),
                metadata: metadata.pairs.clone(),
            })?;
        }
    }
    Ok(())
}
