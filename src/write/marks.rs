//! What came in with other marks, in one MCAP file.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::atomic::AtomicFile;
use super::dialect::Dialect;
use super::error::WriteError;
use super::estimate::is_same;
use super::merge::{self, Additions, Kept, OurChannel, OurMessage};
use crate::motion::{Mark, Stamp};
use crate::wire::Container;

/// Writes a recording again, whole or not at all, with these marks added on that topic, each logged
/// when it says, and without the messages at those places in the file, from 0. Everything else is as it
/// was, but for what an earlier estimate added: with other marks it is no longer the recording's.
pub fn write_marks(
    path: &Path,
    input: &Container,
    input_path: &Path,
    topic: &str,
    marks: &[(Stamp, Mark)],
    without: BTreeSet<u64>,
) -> Result<(), WriteError> {
    if is_same(path, input_path) {
        return Err(WriteError::IsInput {
            path: path.to_owned(),
        });
    }
    let dialect = Dialect::of(input);
    let mut additions = Additions {
        kept: Kept {
            without,
            ..Kept::default()
        },
        ..Additions::default()
    };
    if !marks.is_empty() {
        let (schema, message_encoding) = dialect.events();
        additions.channels.push(OurChannel {
            topic: topic.to_owned(),
            schema,
            message_encoding,
            metadata: BTreeMap::new(),
        });
    }
    for (log_time, mark) in marks {
        let data = dialect
            .event(mark.stamp, mark.event.as_deref(), None)
            .map_err(WriteError::encode(path, topic))?;
        let log_time = u64::try_from(log_time.0).map_err(|_| WriteError::LogTime {
            path: path.to_owned(),
            topic: topic.to_owned(),
            log_time: log_time.0,
        })?;
        additions.messages.push(OurMessage {
            channel: 0,
            log_time,
            data,
        });
    }
    let file = AtomicFile::create_of(path, &[input_path])?;
    merge::write(file, input, None, additions)?;
    Ok(())
}
