//! The journal of a live take: everything as it comes, in an ordinary recording.
//!
//! | topic | schema | what |
//! |---|---|---|
//! | a stream's topic | `foxglove.PoseInFrame` | what an estimate is made from: valid samples with their stamps |
//! | `/capture` + that topic | `enact_msgs/msg/RawPose` (CDR) | every sample, bit for bit: [`PoseRecord`] |
//! | the marks topic | `foxglove.Event` | marks |
//! | `/capture` + that topic | `enact_msgs/msg/RawMark` (CDR) | every mark, bit for bit: [`MarkRecord`] |
//! | `/capture/counts` | `enact.CaptureCounts` (JSON) | what became of the samples, now and then and at the end |
//!
//! Log time is the arrival, publish time what the publisher calls `available`. The scene is
//! attached at the beginning.
//!
//! Until it is closed the file is called `….mcap.part` and locked. It grows by whole chunks
//! only, each handed to the system when it is [`Journal::close_chunk`]d: a process that is
//! killed loses the open chunk, a machine that fails loses besides what was not synced
//! ([`Journal::sync_handle`]). [`crate::write::recover()`] makes a recording of what is left.
//!
//! Every chunk can be read without those before it: before the first message of a channel it
//! repeats that channel and its schema, in a private record that others skip.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, Compression, WriteOptions, Writer};

use super::atomic::rename_to_new;
use super::error::WriteError;
use super::estimate::DEFAULT_WORLD_FRAME;
use super::options::LIBRARY;
use super::topics::COUNTS;
use crate::motion::{Mark, PoseSample, Stamp};
use crate::wire::encode::{self, SchemaRecord};
use crate::wire::live::payload::{MarkRecord, PoseRecord};
use crate::wire::{EncodeError, Encoded};
use crate::write::recover::PART_SUFFIX;

/// What is put before a topic for what came on it bit for bit.
pub const RAW_PREFIX: &str = "/capture";

/// A chunk with more in it is closed before its time \[bytes, not compressed\].
const CHUNK_BYTES: usize = 512 << 10;

const RAW_POSE: &str = "\
# A sample of a tracker as it came over iceoryx2 (payload enact.Pose.1). Times in nanoseconds;\n\
# -9223372036854775808 where there is none. flags: 1 valid.\n\
uint64 sequence\nint64 available_ns\nint64 sample_ns\nint64 device_ns\n\
float64[3] position_m\nfloat64[4] quaternion_xyzw\nuint32 flags\nuint32 session\n";

const RAW_MARK: &str = "\
# A mark as it came over iceoryx2 (payload enact.Mark.1). Times as in RawPose; event is UTF-8\n\
# with zeros after it.\n\
uint64 sequence\nint64 available_ns\nint64 sample_ns\nint64 device_ns\n\
uint8[256] event\nuint32 flags\nuint32 session\n";

const COUNTS_SCHEMA: &str = include_str!("capture_counts.schema.json");

/// A journal that is being written.
pub struct Journal {
    path: PathBuf,
    part: PathBuf,
    writer: Writer<BufWriter<File>>,
    file: File,
    channels: JournalChannels,
    /// Length at which the file was last whole.
    whole: u64,
    messages: u64,
    /// What is in the open chunk \[bytes\].
    open_bytes: usize,
    /// Chunks so far.
    chunks: u64,
}

struct JournalChannels {
    poses: Vec<(JournalChannel, JournalChannel)>,
    marks: (JournalChannel, JournalChannel),
    counts: JournalChannel,
}

/// A channel, and how many messages it has.
struct JournalChannel {
    id: u16,
    sequence: u32,
    /// Its definition for chunks to repeat, and the last that did.
    repeat: Vec<u8>,
    repeated: Option<u64>,
}

/// Which channel a message is for.
#[derive(Clone, Copy)]
enum To {
    Pose(usize),
    RawPose(usize),
    Mark,
    RawMark,
    Counts,
}

impl Journal {
    /// Begins the journal that will be `path`: its streams are on `topics`, its marks on
    /// `marks_topic`. Fails where either name is taken.
    pub fn create(
        path: &Path,
        topics: &[String],
        marks_topic: &str,
        scene_toml: &[u8],
    ) -> Result<Self, WriteError> {
        let part = part_of(path);
        if std::fs::symlink_metadata(path).is_ok() {
            return Err(WriteError::Exists {
                path: path.to_owned(),
            });
        }
        let file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(&part)
            .map_err(WriteError::io(&part, "create"))?;
        // Advisory, and gone with the process: it tells a recorder at work from one that died.
        file.try_lock()
            .map_err(|error| WriteError::io(&part, "lock")(error.into()))?;
        let sink = file
            .try_clone()
            .map_err(WriteError::io(&part, "open again"))?;
        let begun = begin(sink, topics, marks_topic, scene_toml);
        let (writer, channels) = match begun {
            Ok(begun) => begun,
            Err(error) => {
                forget(&part);
                return Err(WriteError::mcap(&part)(error));
            }
        };
        let mut journal = Self {
            path: path.to_owned(),
            part,
            writer,
            file,
            channels,
            whole: 0,
            messages: 0,
            open_bytes: 0,
            chunks: 0,
        };
        if let Err(error) = journal.flush() {
            let (sink, _) = journal.writer.into_inner().into_parts();
            drop(sink);
            forget(&journal.part);
            return Err(error);
        }
        Ok(journal)
    }

    /// The name it will have.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The name it has.
    pub fn part(&self) -> &Path {
        &self.part
    }

    /// Samples and marks, whatever became of them.
    pub fn messages(&self) -> u64 {
        self.messages
    }

    /// Keeps a sample that came on the stream of that number; `sample` is what of it is used.
    pub fn pose(
        &mut self,
        stream: usize,
        receipt: Stamp,
        record: &PoseRecord,
        sample: Option<&PoseSample>,
    ) -> Result<(), WriteError> {
        self.messages += 1;
        let times = Times::new(receipt, record.available_ns);
        self.message(To::RawPose(stream), times, &cdr(&record.to_bytes()))?;
        let Some(sample) = sample else {
            return Ok(());
        };
        let bytes = encode::pose_in_frame(DEFAULT_WORLD_FRAME, sample);
        let bytes = self.encoded(bytes)?;
        self.message(To::Pose(stream), times, &bytes)
    }

    /// Keeps a mark; `mark` is what is used of it.
    pub fn mark(
        &mut self,
        receipt: Stamp,
        record: &MarkRecord,
        mark: Option<&Mark>,
    ) -> Result<(), WriteError> {
        self.messages += 1;
        let times = Times::new(receipt, record.available_ns);
        self.message(To::RawMark, times, &cdr(&record.to_bytes()))?;
        let Some(mark) = mark else {
            return Ok(());
        };
        let bytes = self.encoded(encode::event(mark))?;
        self.message(To::Mark, times, &bytes)
    }

    /// Notes what became of the samples so far, as JSON.
    pub fn counts(&mut self, now: Stamp, json: &[u8]) -> Result<(), WriteError> {
        self.message(To::Counts, Times::new(now, now.0), json)
    }

    /// Hands what was written to the system: a killed process does not lose it any more.
    pub fn close_chunk(&mut self) -> Result<(), WriteError> {
        if self.open_bytes > 0 {
            self.flush()?;
        }
        Ok(())
    }

    /// The file, for another thread to sync: a failing machine does not lose it any more.
    pub fn sync_handle(&self) -> Result<File, WriteError> {
        self.file
            .try_clone()
            .map_err(WriteError::io(&self.part, "open again"))
    }

    /// Notes something of the take itself under that name, in a metadata record.
    pub fn note(&mut self, name: &str, pairs: BTreeMap<String, String>) -> Result<(), WriteError> {
        let name = name.to_owned();
        let metadata = Metadata {
            name,
            metadata: pairs,
        };
        let written = self.writer.write_metadata(&metadata);
        written.map_err(WriteError::mcap(&self.part))
    }

    /// Writes the end, makes the file durable and gives it its name. Where something else has come
    /// by that name it is left alone, and the journal keeps its own.
    pub fn finish(mut self) -> Result<(), WriteError> {
        if let Err(error) = self.writer.finish() {
            let error = WriteError::mcap(&self.part)(error);
            return Err(match self.salvage() {
                Ok(()) => error,
                Err(worse) => worse,
            });
        }
        let sink = self.writer.into_inner();
        let ended = sink
            .into_inner()
            .map_err(io::IntoInnerError::into_error)
            .and_then(|file| file.sync_all());
        if let Err(error) = ended {
            let error = WriteError::io(&self.part, "write")(error);
            return Err(match cut(&self.file, self.whole) {
                Ok(()) => rename_to_new(&self.part, &self.path).err().unwrap_or(error),
                Err(_) => error,
            });
        }
        rename_to_new(&self.part, &self.path)
    }

    /// After an error: goes back to where the file was last whole, ends it there, without an
    /// index, and gives it its name. Needs no more room than the last chunk had.
    pub fn salvage(self) -> Result<(), WriteError> {
        // What is buffered does not fit.
        let (sink, _) = self.writer.into_inner().into_parts();
        drop(sink);
        cut(&self.file, self.whole).map_err(WriteError::io(&self.part, "end"))?;
        rename_to_new(&self.part, &self.path)
    }

    /// [`Journal::finish`] into another folder, which is made if it is not there: what is thrown away by mistake
    /// can be had back. Returns the file's path.
    pub fn set_aside(mut self, folder: &Path) -> Result<PathBuf, WriteError> {
        std::fs::create_dir_all(folder).map_err(WriteError::io(folder, "make"))?;
        let name = self.path.file_name().unwrap_or_default();
        self.path = folder.join(name);
        let path = self.path.clone();
        self.finish().map(|()| path)
    }

    fn flush(&mut self) -> Result<(), WriteError> {
        self.writer.flush().map_err(WriteError::mcap(&self.part))?;
        self.whole = self
            .file
            .metadata()
            .map_err(WriteError::io(&self.part, "measure"))?
            .len();
        self.open_bytes = 0;
        self.chunks += 1;
        Ok(())
    }

    fn encoded(&self, bytes: Result<Vec<u8>, EncodeError>) -> Result<Vec<u8>, WriteError> {
        bytes.map_err(WriteError::encode(&self.part, "pose or mark"))
    }

    fn message(&mut self, to: To, times: Times, data: &[u8]) -> Result<(), WriteError> {
        let channels = &mut self.channels;
        let channel = match to {
            To::Pose(stream) => &mut channels.poses[stream].0,
            To::RawPose(stream) => &mut channels.poses[stream].1,
            To::Mark => &mut channels.marks.0,
            To::RawMark => &mut channels.marks.1,
            To::Counts => &mut channels.counts,
        };
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: channel.sequence,
            log_time: times.log,
            publish_time: times.publish,
        };
        channel.sequence = channel.sequence.wrapping_add(1);
        let mut written = Ok(());
        if channel.repeated.replace(self.chunks) != Some(self.chunks) {
            self.open_bytes += channel.repeat.len();
            written = repeats::write(&mut self.writer, &channel.repeat);
        }
        self.open_bytes += data.len();
        written
            .and_then(|()| self.writer.write_to_known_channel(&header, data))
            .map_err(WriteError::mcap(&self.part))?;
        if self.open_bytes > CHUNK_BYTES {
            self.flush()?;
        }
        Ok(())
    }
}

#[derive(Clone, Copy)]
struct Times {
    log: u64,
    publish: u64,
}

impl Times {
    /// Times before 1970 cannot be said; the raw record says them.
    fn new(receipt: Stamp, available_ns: i64) -> Self {
        let log = u64::try_from(receipt.0).unwrap_or(0);
        Self {
            log,
            publish: u64::try_from(available_ns).unwrap_or(log),
        }
    }
}

/// Removes a journal that could not be begun and has nothing in it.
fn forget(part: &Path) {
    // One that stays is found by the next look for what a crash left.
    let _ = std::fs::remove_file(part);
}

/// `take.mcap` → `take.mcap.part`.
pub(super) fn part_of(path: &Path) -> PathBuf {
    let mut part = path.as_os_str().to_owned();
    part.push(PART_SUFFIX);
    part.into()
}

/// A fixed layout of aligned words is its own CDR after the mark of little-endian.
fn cdr(words: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(4 + words.len());
    bytes.extend([0, 1, 0, 0]);
    bytes.extend(words);
    bytes
}

fn begin(
    file: File,
    topics: &[String],
    marks_topic: &str,
    scene_toml: &[u8],
) -> mcap::McapResult<(Writer<BufWriter<File>>, JournalChannels)> {
    // A chunk is made in memory and written at once: the file grows by whole ones.
    let mut writer = WriteOptions::new()
        .profile("")
        .library(LIBRARY)
        .compression(Some(Compression::Zstd))
        .compression_level(1)
        .compression_threads(0)
        .chunk_size(None)
        .disable_seeking(true)
        .create(BufWriter::new(file))?;
    writer.attach(&Attachment {
        log_time: 0,
        create_time: 0,
        name: "scene.toml".to_owned(),
        media_type: "application/toml".to_owned(),
        data: scene_toml.into(),
    })?;
    let mut channel = |topic: &str, schema: &SchemaRecord, encoding: &str| {
        let schema_id = writer.add_schema(&schema.name, &schema.encoding, &schema.data)?;
        let id = writer.add_channel(schema_id, topic, encoding, &BTreeMap::new())?;
        mcap::McapResult::Ok(JournalChannel {
            id,
            sequence: 0,
            repeat: repeats::definition(schema_id, schema, id, topic, encoding),
            repeated: None,
        })
    };
    let of_text = |name: &str, encoding: &str, text: &str| SchemaRecord {
        name: name.to_owned(),
        encoding: encoding.to_owned(),
        data: text.as_bytes().to_vec(),
    };
    let raw_pose = of_text("enact_msgs/msg/RawPose", "ros2msg", RAW_POSE);
    let raw_mark = of_text("enact_msgs/msg/RawMark", "ros2msg", RAW_MARK);
    let counts = of_text("enact.CaptureCounts", "jsonschema", COUNTS_SCHEMA);
    let (pose, event) = (Encoded::PoseInFrame.schema(), Encoded::Event.schema());
    let raw_topic = |topic: &str| format!("{RAW_PREFIX}{topic}");
    let mut poses = Vec::new();
    for topic in topics {
        let used = channel(topic, &pose, "protobuf")?;
        poses.push((used, channel(&raw_topic(topic), &raw_pose, "cdr")?));
    }
    let marks = channel(marks_topic, &event, "protobuf")?;
    let marks = (marks, channel(&raw_topic(marks_topic), &raw_mark, "cdr")?);
    let counts = channel(COUNTS, &counts, "json")?;
    Ok((
        writer,
        JournalChannels {
            poses,
            marks,
            counts,
        },
    ))
}

/// Cuts a file to the length at which it was last whole, and ends it there if there is room: without an
/// end all of it is read as well. What was whole, and perhaps synced, stays in it whatever fails.
fn cut(mut file: &File, whole: u64) -> io::Result<()> {
    let ended = file
        .set_len(whole)
        .and_then(|()| file.seek(SeekFrom::Start(whole)))
        .and_then(|_| file.write_all(&end()));
    if ended.is_err() {
        file.set_len(whole)?;
    }
    file.sync_all()
}

/// The end of a file without an index: data end, footer, magic.
fn end() -> Vec<u8> {
    use mcap::records::op;
    let mut end = vec![op::DATA_END];
    end.extend(4_u64.to_le_bytes());
    end.extend([0; 4]);
    end.push(op::FOOTER);
    end.extend(20_u64.to_le_bytes());
    end.extend([0; 20]);
    end.extend(mcap::MAGIC);
    end
}

mod repeats;

#[cfg(test)]
mod tests;
