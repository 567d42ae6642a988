//! The marks in a recording, message by message.

use super::error::IngestError;
use super::recording::Recording;
use crate::motion::{Mark, Stamp};
use crate::wire::MarkFormat;

/// A message that is a mark.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MarkMessage {
    /// Its place among the messages of the file, from 0.
    pub place: u64,
    /// When it was logged.
    pub log_time: Stamp,
    /// The mark: when it was made, by the message's stamp or its log time, and of what.
    pub mark: Mark,
    /// Whether it has a stamp of its own.
    pub is_stamped: bool,
}

impl Recording {
    /// The messages on a topic as marks, in file order. Those of a schema that is no mark's are marks of no
    /// name, stamped by log time: a button's, whatever it sends.
    ///
    /// Fails where the topic is absent, or a message of a mark cannot be decoded.
    pub fn marks_on(&self, topic: &str) -> Result<Vec<MarkMessage>, IngestError> {
        let container = self.container();
        if !container.topics().contains(topic) {
            return Err(IngestError::NoTopic {
                path: self.path().to_owned(),
                topic: topic.to_owned(),
                present: container.topics().into_iter().map(str::to_owned).collect(),
            });
        }
        let mut marks = Vec::new();
        let mut walk = container.walk();
        let mut place = 0;
        while let Some(message) = walk.next_message() {
            place += 1;
            let channel = container.channels().get(&message.channel_id);
            let Some(channel) = channel.filter(|channel| channel.topic == topic) else {
                continue;
            };
            let schema = container.schema_of(channel);
            let schema = schema.map_or("", |schema| schema.name.as_str());
            let log_time = Stamp(i64::try_from(message.log_time).unwrap_or(i64::MAX));
            let (mark, is_stamped) = match MarkFormat::of(schema, &channel.message_encoding) {
                Some(format) => {
                    let decoded = format.decode(message.data);
                    let mark = decoded.map_err(|source| IngestError::Keyframe {
                        path: self.path().to_owned(),
                        topic: topic.to_owned(),
                        source,
                    })?;
                    let is_stamped = mark.stamp.is_some();
                    (mark.mark(log_time), is_stamped)
                }
                None => {
                    let mark = Mark {
                        stamp: log_time,
                        event: None,
                    };
                    (mark, false)
                }
            };
            marks.push(MarkMessage {
                place: place - 1,
                log_time,
                mark,
                is_stamped,
            });
        }
        Ok(marks)
    }
}
