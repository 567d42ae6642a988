//! Journals as a killed recorder leaves them, and what may happen to their bytes.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use enact::motion::{Mark, Stamp};
use enact::wire::container::Container;
use enact::wire::live::payload::{MarkRecord, NO_TIME, PoseRecord};
use enact::write::Journal;

const START: i64 = 1_700_000_000_000_000_000;
const MS: i64 = 1_000_000;

/// Page of a file system.
pub const PAGE: usize = 4096;

/// A message: topic, sequence number, log time, publish time, data.
pub type Message = (String, u32, u64, u64, Vec<u8>);

/// The bytes of a journal, and what is in them.
pub struct Written {
    pub bytes: Vec<u8>,
    pub messages: Vec<Message>,
    pub scene: Vec<u8>,
    /// Where chunks lie, and which messages are in each.
    pub chunks: Vec<(Range<usize>, Range<usize>)>,
}

/// The journal that will be `path`, of that many chunks of that many samples, still open. No two
/// samples are alike.
pub fn open_journal(path: &Path, chunks: usize, samples: usize) -> Journal {
    let topics = ["/tracker/a/pose".to_owned(), "/tracker/b/pose".to_owned()];
    let mut journal = Journal::create(path, &topics, "/marks", &scene()).expect("create");
    for k in 0..(chunks * samples) as i64 {
        let receipt = Stamp(START + k * MS);
        let record = pose(k);
        let sample = record.pose(Stamp(record.sample_ns));
        let used = (k % 3 > 0).then_some(&sample);
        let stream = (k % 2) as usize;
        journal
            .pose(stream, receipt, &record, used)
            .expect("a pose");
        if k % 97 == 50 {
            let mark = Mark {
                stamp: receipt,
                event: Some(format!("event {k}")),
            };
            journal
                .mark(receipt, &raw_mark(k), Some(&mark))
                .expect("mark");
        }
        if (k + 1) % samples as i64 == 0 {
            journal.close_chunk().expect("a chunk");
        }
    }
    journal
}

fn scene() -> Vec<u8> {
    b"name = \"journal\"\n".repeat(20)
}

/// The same as a killed recorder leaves it: never closed.
pub fn journal(chunks: usize, samples: usize) -> Written {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("take.mcap");
    let journal = open_journal(&path, chunks, samples);
    let bytes = std::fs::read(journal.part()).expect("read");
    drop(journal);
    let messages = messages(&Container::new(bytes.clone()).expect("MCAP"));
    let mut at = 0;
    let mut found = Vec::new();
    for chunk in records(&bytes, Some(0x06)) {
        // With the definitions in its head a chunk is read alone.
        let alone = [&bytes[..8], &bytes[chunk.clone()]].concat();
        let count = Container::new(alone).expect("MCAP").message_count() as usize;
        found.push((chunk, at..at + count));
        at += count;
    }
    assert_eq!(at, messages.len(), "chunks that cannot be read alone");
    assert_eq!(found.len(), chunks + 1);
    Written {
        bytes,
        messages,
        scene: scene(),
        chunks: found,
    }
}

/// A sample of numbers that do not compress.
fn pose(k: i64) -> PoseRecord {
    let noise = |salt: i64| ((k * 8 + salt) as f64 * 12.9898).sin() * 43_758.545_3;
    PoseRecord {
        sequence: (k / 2) as u64,
        available_ns: START + k * MS - 7,
        sample_ns: START + k * MS - 1_500,
        device_ns: NO_TIME,
        position_m: [noise(0).fract(), noise(1).fract(), noise(2).fract()],
        quaternion_xyzw: [noise(3).fract(), 0.0, 0.0, 1.0],
        flags: 1,
        session: 9,
    }
}

fn raw_mark(k: i64) -> MarkRecord {
    MarkRecord {
        sequence: k as u64,
        available_ns: START + k * MS,
        sample_ns: NO_TIME,
        device_ns: NO_TIME,
        event: [k as u8; 256],
        flags: 0,
        session: 9,
    }
}

/// All messages, in file order.
pub fn messages(container: &Container) -> Vec<Message> {
    let mut found = Vec::new();
    let mut walk = container.walk();
    while let Some(message) = walk.next_message() {
        let channel = &container.channels()[&message.channel_id];
        found.push((
            channel.topic.clone(),
            message.sequence,
            message.log_time,
            message.publish_time,
            message.data.to_vec(),
        ));
    }
    found
}

/// The messages of a file that is whole.
pub fn messages_of(path: &Path) -> Vec<Message> {
    let container = Container::new(std::fs::read(path).expect("read")).expect("MCAP");
    assert_eq!(container.damages().count(), 0, "{}", path.display());
    messages(&container)
}

/// Where records of a type, or all, lie in an undamaged file.
pub fn records(bytes: &[u8], wanted: Option<u8>) -> Vec<Range<usize>> {
    let (mut found, mut at) = (Vec::new(), 8);
    while at + 9 <= bytes.len() {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().expect("eight"));
        let end = at + 9 + length as usize;
        if wanted.is_none_or(|wanted| bytes[at] == wanted) {
            found.push(at..end);
        }
        at = end;
    }
    found
}

/// What happens to a file. Places are shares of its length, in 2³² parts.
#[derive(Clone, Debug)]
pub enum Blow {
    FlipBit(u32, u8),
    ZeroPage(u32),
    Cut(u32),
    Repeat(u32, u16),
    Remove(u32, u16),
}

/// A file that was hit: each byte with the place that it had, if it is still what it was.
pub struct Hit {
    bytes: Vec<(u8, Option<usize>)>,
}

impl Hit {
    pub fn new(bytes: &[u8]) -> Self {
        let places = bytes.iter().copied().enumerate();
        Self {
            bytes: places.map(|(at, byte)| (byte, Some(at))).collect(),
        }
    }

    pub fn strike(&mut self, blow: &Blow) {
        let length = self.bytes.len();
        let place = |share: u32| ((u64::from(share) * length as u64) >> 32) as usize;
        if length == 0 {
            return;
        }
        match *blow {
            Blow::FlipBit(at, bit) => {
                let byte = &mut self.bytes[place(at)];
                *byte = (byte.0 ^ (1 << (bit % 8)), None);
            }
            Blow::ZeroPage(at) => {
                let from = place(at) / PAGE * PAGE;
                let to = (from + PAGE).min(length);
                self.bytes[from..to].fill((0, None));
            }
            Blow::Cut(at) => self.bytes.truncate(place(at)),
            Blow::Repeat(at, count) => {
                let from = place(at);
                let to = (from + usize::from(count)).min(length);
                let again = self.bytes[from..to].to_vec();
                self.bytes.splice(to..to, again);
            }
            Blow::Remove(at, count) => {
                let from = place(at);
                let to = (from + usize::from(count)).min(length);
                self.bytes.drain(from..to);
            }
        }
    }

    pub fn bytes(&self) -> Vec<u8> {
        self.bytes.iter().map(|(byte, _)| *byte).collect()
    }

    /// Where each chunk lies that is untouched, by its number, the first time.
    pub fn untouched(&self, written: &Written) -> BTreeMap<usize, Range<usize>> {
        let mut found = BTreeMap::new();
        for at in 0..self.bytes.len() {
            let Some(place) = self.bytes[at].1 else {
                continue;
            };
            let begins = |(range, _): &(Range<usize>, _)| range.start == place;
            let Some(number) = written.chunks.iter().position(begins) else {
                continue;
            };
            let chunk = written.chunks[number].0.clone();
            let here = self.bytes.get(at..at + chunk.len());
            let is_whole = here.is_some_and(|here| {
                here.iter()
                    .map(|(_, place)| *place)
                    .eq(chunk.clone().map(Some))
            });
            if is_whole {
                found.entry(number).or_insert(at..at + chunk.len());
            }
        }
        found
    }

    /// Where anything is left of what was in that range of the file.
    pub fn remains_of(&self, range: &Range<usize>) -> Vec<usize> {
        let bytes = self.bytes.iter().enumerate();
        let is_of = |place: &Option<usize>| place.is_some_and(|place| range.contains(&place));
        let of = bytes.filter(|(_, (_, place))| is_of(place));
        of.map(|(at, _)| at).collect()
    }
}
