//! Takes as the trackers gave them → MCAP recordings.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Cursor, Seek, Write};
use std::path::{Path, PathBuf};

use mcap::records::MessageHeader;
use mcap::{Attachment, Writer};

use super::atomic::AtomicFile;
use super::error::WriteError;
use super::options;
use crate::motion::{Holds, Keyframe, Mark, PoseSample, Stamp};
use crate::wire::encode;
use crate::wire::{Encoded, encode_keyframe};

/// Writes a recording: poses as `foxglove.PoseInFrame`, points as `foxglove.Point3InFrame`, marks as `foxglove.Event`, scenes and
/// the like as attachments, in the order given. Give them in order of log time: tools warn of
/// files that are not.
///
/// The bytes depend on what is written alone. The file has its name only after
/// [`RecordingWriter::finish`]; dropped without it, it is removed.
pub struct RecordingWriter<W: Write + Seek = AtomicFile> {
    path: PathBuf,
    writer: Writer<W>,
    channels: BTreeMap<(String, Encoded), OwnChannel>,
}

/// A channel of ours, and how many messages it has.
#[derive(Clone, Copy)]
struct OwnChannel {
    id: u16,
    sequence: u32,
}

impl RecordingWriter<Cursor<Vec<u8>>> {
    /// Begins a recording in memory; `path` is its name in errors.
    pub fn in_memory(path: &Path) -> Result<Self, WriteError> {
        Self::begin(path, Cursor::default())
    }

    /// Writes the summary and gives all of it.
    pub fn into_bytes(mut self) -> Result<Vec<u8>, WriteError> {
        self.writer.finish().map_err(WriteError::mcap(&self.path))?;
        Ok(self.writer.into_inner().into_inner())
    }
}

impl RecordingWriter {
    /// Begins a recording that will be `path`.
    pub fn create(path: &Path) -> Result<Self, WriteError> {
        Self::create_of(path, &[])
    }

    /// [`RecordingWriter::create`] of one that is made of these files: nobody may read it who may not read them.
    pub fn create_of(path: &Path, made_of: &[&Path]) -> Result<Self, WriteError> {
        Self::begin(path, AtomicFile::create_of(path, made_of)?)
    }

    /// Writes the summary, makes the file durable and gives it its name.
    pub fn finish(mut self) -> Result<(), WriteError> {
        self.writer.finish().map_err(WriteError::mcap(&self.path))?;
        self.writer.into_inner().commit()
    }
}

impl<W: Write + Seek> RecordingWriter<W> {
    fn begin(path: &Path, sink: W) -> Result<Self, WriteError> {
        let writer = options::writer(sink, "").map_err(WriteError::mcap(path))?;
        Ok(Self {
            path: path.to_owned(),
            writer,
            channels: BTreeMap::new(),
        })
    }

    /// Adds a tracker reading of a pose or a point, in the frame `frame_id`.
    pub fn pose(
        &mut self,
        topic: &str,
        frame_id: &str,
        log_time: Stamp,
        sample: &PoseSample,
    ) -> Result<(), WriteError> {
        let (kind, bytes) = match sample.holds {
            Holds::Position => (
                Encoded::Point3InFrame,
                encode::point_in_frame(frame_id, sample),
            ),
            _ => (
                Encoded::PoseInFrame,
                encode::pose_in_frame(frame_id, sample),
            ),
        };
        self.message(topic, kind, log_time, bytes)
    }

    /// Adds a keyframe of a body.
    pub fn keyframe(
        &mut self,
        topic: &str,
        log_time: Stamp,
        keyframe: &Keyframe,
    ) -> Result<(), WriteError> {
        let bytes = Ok(encode_keyframe(keyframe));
        self.message(topic, Encoded::Keyframe, log_time, bytes)
    }

    /// Adds a performer's mark, on the scene's marks topic.
    pub fn mark(&mut self, topic: &str, log_time: Stamp, mark: &Mark) -> Result<(), WriteError> {
        self.message(topic, Encoded::Event, log_time, encode::event(mark))
    }

    /// Adds an attachment; the scene is `("scene.toml", "application/toml")`. Its times are
    /// zero: the bytes shall not depend on when they were written.
    pub fn attach(&mut self, name: &str, media_type: &str, bytes: &[u8]) -> Result<(), WriteError> {
        self.writer
            .attach(&Attachment {
                log_time: 0,
                create_time: 0,
                name: name.to_owned(),
                media_type: media_type.to_owned(),
                data: Cow::Borrowed(bytes),
            })
            .map_err(WriteError::mcap(&self.path))
    }

    fn message(
        &mut self,
        topic: &str,
        kind: Encoded,
        log_time: Stamp,
        bytes: Result<Vec<u8>, encode::EncodeError>,
    ) -> Result<(), WriteError> {
        let bytes = bytes.map_err(|source| WriteError::Encode {
            path: self.path.clone(),
            topic: topic.to_owned(),
            source,
        })?;
        let log_time = u64::try_from(log_time.0).map_err(|_| WriteError::LogTime {
            path: self.path.clone(),
            topic: topic.to_owned(),
            log_time: log_time.0,
        })?;
        let channel = self.channel(topic, kind)?;
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: channel.sequence,
            log_time,
            publish_time: log_time,
        };
        self.writer
            .write_to_known_channel(&header, &bytes)
            .map_err(WriteError::mcap(&self.path))
    }

    /// The channel, made at its first message; counts the message.
    fn channel(&mut self, topic: &str, kind: Encoded) -> Result<OwnChannel, WriteError> {
        let key = (topic.to_owned(), kind);
        if let Some(channel) = self.channels.get_mut(&key) {
            channel.sequence = channel.sequence.wrapping_add(1);
            return Ok(*channel);
        }
        let schema = kind.schema();
        let id = self
            .writer
            .add_schema(&schema.name, &schema.encoding, &schema.data)
            .and_then(|schema| {
                self.writer
                    .add_channel(schema, topic, kind.message_encoding(), &BTreeMap::new())
            })
            .map_err(WriteError::mcap(&self.path))?;
        let channel = OwnChannel { id, sequence: 0 };
        self.channels.insert(key, channel);
        Ok(channel)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    fn write(path: &Path) {
        let mut recording = RecordingWriter::create(path).expect("create");
        recording
            .attach("scene.toml", "application/toml", b"name = \"test\"\n")
            .expect("attach");
        for k in 0..100 {
            let stamp = Stamp(1_000_000_000 + k * 5_000_000);
            let sample = PoseSample::new(
                stamp,
                Vector3::new(0.1, 0.2, k as f64),
                [0.0, 0.0, 0.0, 1.0],
            );
            recording
                .pose("/tracker/die/pose", "world", stamp, &sample)
                .expect("pose");
        }
        let mark = Mark {
            stamp: Stamp(1_500_000_000),
            event: Some("bounce".to_owned()),
        };
        recording.mark("/marks", mark.stamp, &mark).expect("mark");
        recording.finish().expect("finish");
    }

    #[test]
    fn the_same_take_gives_the_same_bytes_and_what_was_written() {
        let directory = tempfile::tempdir().expect("directory");
        let (a, b) = (directory.path().join("a"), directory.path().join("b"));
        write(&a);
        write(&b);
        let bytes = std::fs::read(&a).expect("read");
        assert_eq!(bytes, std::fs::read(&b).expect("read"));
        let summary = mcap::Summary::read(&bytes)
            .expect("valid")
            .expect("summary");
        let statistics = summary.stats.expect("statistics");
        assert_eq!(
            (
                statistics.message_count,
                statistics.channel_count,
                statistics.attachment_count
            ),
            (101, 2, 1)
        );
        assert_eq!(statistics.message_start_time, 1_000_000_000);
    }

    #[test]
    fn what_cannot_be_written_is_an_error_and_leaves_no_file() {
        let directory = tempfile::tempdir().expect("directory");
        let path = directory.path().join("out.mcap");
        let mut recording = RecordingWriter::create(&path).expect("create");
        let mark = Mark {
            stamp: Stamp(-5),
            event: None,
        };
        let error = recording
            .mark("/marks", Stamp(0), &mark)
            .expect_err("negative stamp");
        assert!(
            error.to_string().contains("topic /marks: stamp -5 ns"),
            "{error}"
        );
        drop(recording);
        assert_eq!(
            std::fs::read_dir(directory.path()).expect("list").count(),
            0
        );
    }
}
