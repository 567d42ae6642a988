//! What came in with marks added, in one MCAP file.

use std::collections::BTreeMap;
use std::path::Path;

use super::atomic::AtomicFile;
use super::dialect::Dialect;
use super::error::WriteError;
use super::estimate::is_same;
use super::merge::{self, Additions, OurChannel, OurMessage};
use crate::motion::{Mark, Stamp};
use crate::wire::Container;

/// Writes a recording again, whole or not at all, with these marks on that topic, each logged
/// when it says. Everything else is as it was, but for what an earlier estimate added: with
/// other marks it is no longer the recording's.
pub fn write_marks(
    path: &Path,
    input: &Container,
    input_path: &Path,
    topic: &str,
    marks: &[(Stamp, Mark)],
) -> Result<(), WriteError> {
    if is_same(path, input_path) {
        return Err(WriteError::IsInput {
            path: path.to_owned(),
        });
    }
    let dialect = Dialect::of(input);
    let (schema, message_encoding) = dialect.events();
    let mut additions = Additions::default();
    additions.channels.push(OurChannel {
        topic: topic.to_owned(),
        schema,
        message_encoding,
        metadata: BTreeMap::new(),
    });
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
    merge::write(AtomicFile::create(path)?, input, None, additions)?;
    Ok(())
}
