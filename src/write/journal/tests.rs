use std::fs;

use super::super::recover::{abandoned, recover};
use super::*;
use crate::wire::live::payload::NO_TIME;

const START: i64 = 1_700_000_000_000_000_000;
const MS: i64 = 1_000_000;

fn record(k: i64) -> PoseRecord {
    PoseRecord {
        sequence: k as u64,
        available_ns: START + k * MS,
        sample_ns: START + k * MS - 5,
        device_ns: NO_TIME,
        position_m: [k as f64, 0.5, f64::NAN],
        quaternion_xyzw: [0.0, 0.0, 0.0, 1.0],
        flags: 1,
        session: 3,
    }
}

fn journal(path: &Path) -> Journal {
    let topics = ["/tracker/a/pose".to_owned(), "/tracker/b/pose".to_owned()];
    Journal::create(path, &topics, "/marks", b"name = \"x\"\n").expect("create")
}

/// One sample per millisecond, alternately used and not, a chunk every ten. The lengths at which the
/// file was whole.
fn fill(journal: &mut Journal, range: std::ops::Range<i64>) -> Vec<u64> {
    let mut whole = vec![journal.whole];
    for k in range {
        let receipt = Stamp(START + k * MS);
        let sample = record(k).pose(Stamp(START + k * MS - 5));
        let used = (k % 2 == 0).then_some(&sample);
        journal
            .pose((k % 2) as usize, receipt, &record(k), used)
            .expect("write");
        if k % 10 == 9 {
            journal.close_chunk().expect("flush");
            whole.push(journal.whole);
        }
    }
    whole
}

fn container(path: &Path) -> crate::wire::Container {
    crate::wire::Container::new(fs::read(path).expect("read")).expect("MCAP")
}

fn messages(path: &Path, topic: &str) -> u64 {
    let container = container(path);
    let mut channels = container.channels().values();
    channels.find(|c| c.topic == topic).expect(topic).messages
}

#[test]
fn a_closed_journal_is_a_recording_with_every_sample_bit_for_bit() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("take.mcap");
    let mut journal = journal(&path);
    fill(&mut journal, 0..105);
    assert!(!path.exists() && journal.part().exists());
    assert_eq!(journal.messages(), 105);
    journal.finish().expect("finish");
    let bytes = fs::read(&path).expect("read");
    let summary = mcap::Summary::read(&bytes)
        .expect("valid")
        .expect("summary");
    assert_eq!(summary.stats.expect("statistics").message_count, 105 + 53);
    let found = container(&path);
    assert_eq!((found.damages().count(), found.is_sorted()), (0, true));
    let (mut walk, mut k) = (found.walk(), 0);
    while let Some(message) = walk.next_message() {
        let channel = &found.channels()[&message.channel_id];
        if channel.topic.starts_with("/capture/") {
            assert_eq!(message.data[..4], [0, 1, 0, 0]);
            assert_eq!(message.data[4..], record(k).to_bytes());
            assert_eq!(message.publish_time, record(k).available_ns as u64);
            k += 1;
        }
    }
    assert_eq!(k, 105);
    assert_eq!(fs::read_dir(folder.path()).expect("list").count(), 1);
}

#[test]
fn of_a_killed_recorder_everything_but_the_open_chunk_is_recovered() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("take.mcap");
    let mut journal = journal(&path);
    let lengths = fill(&mut journal, 0..108);
    let part = journal.part().to_owned();
    // While it is being written nobody may touch it.
    assert!(matches!(recover(&part), Err(WriteError::Busy { .. })));
    assert!(abandoned(folder.path()).expect("list").is_empty());
    // What the file held at that moment, and the same cut anywhere in its last chunk.
    let whole = fs::read(&part).expect("read");
    let before = lengths[lengths.len() - 2] as usize;
    drop(journal);
    fs::remove_file(&part).expect("remove");
    for (cut, expected, unread) in [
        (whole.len(), 100, 0),
        // The index of the last chunk alone.
        (whole.len() - 1, 100, 1),
        (before + 30, 90, 30),
    ] {
        fs::write(&part, &whole[..cut]).expect("write");
        assert_eq!(abandoned(folder.path()).expect("list"), vec![part.clone()]);
        let recovered = recover(&part).expect("recover");
        assert_eq!(recovered.is_whole, unread == 0);
        assert_eq!(recovered.unread.is_empty(), unread == 0);
        assert!(!part.exists());
        assert!(fs::read(&recovered.journal).expect("kept") == whole[..cut]);
        fs::remove_file(&recovered.journal).expect("remove");
        let saved =
            messages(&path, "/capture/tracker/a/pose") + messages(&path, "/capture/tracker/b/pose");
        assert_eq!(saved, expected, "cut at {cut} of {}", whole.len());
        let said: u64 = recovered.topics.iter().map(|(_, messages)| messages).sum();
        assert_eq!(said, container(&path).message_count());
        let bytes = fs::read(&path).expect("read");
        assert!(mcap::Summary::read(&bytes).expect("valid").is_some());
        fs::remove_file(&path).expect("remove");
    }
}

#[test]
fn damage_in_the_middle_is_said_and_the_journal_kept() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("take.mcap");
    let mut journal = journal(&path);
    let lengths = fill(&mut journal, 0..100);
    let (part, middle) = (journal.part().to_owned(), lengths[5] as usize);
    let mut bytes = fs::read(&part).expect("read");
    drop(journal);
    bytes[middle + 60] ^= 0xff;
    fs::write(&part, &bytes).expect("write");
    let recovered = recover(&part).expect("recover");
    assert!(!recovered.is_whole && fs::read(&recovered.journal).expect("kept") == bytes);
    assert!(recovered.damages.len() > 1, "{:?}", recovered.damages);
    assert_eq!(recovered.unread[0].start, middle);
    assert!(abandoned(folder.path()).expect("list").is_empty());
}

#[test]
fn after_an_error_the_file_so_far_is_valid() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("take.mcap");
    let mut journal = journal(&path);
    fill(&mut journal, 0..57);
    // As if half a chunk had been written when the disk was full.
    let mut file = OpenOptions::new()
        .append(true)
        .open(journal.part())
        .expect("open");
    file.write_all(&[6, 0xff, 0xff, 0, 0, 0, 0, 0, 0, 1, 2, 3])
        .expect("write");
    journal.salvage().expect("salvage");
    let found = container(&path);
    assert_eq!(found.damages().count(), 0, "{:?}", found.damages().first());
    assert_eq!(found.message_count(), 50 + 25);
    let bytes = fs::read(&path).expect("read");
    let stream = mcap::MessageStream::new(&bytes).expect("valid");
    let messages: Result<Vec<_>, _> = stream.collect();
    assert_eq!(messages.expect("messages").len(), 75);
}

/// A chunk without those before it: what it needs to be understood is in it.
#[test]
fn every_chunk_is_read_alone() {
    let folder = tempfile::tempdir().expect("folder");
    let mut journal = journal(&folder.path().join("take.mcap"));
    let lengths = fill(&mut journal, 0..100);
    let bytes = fs::read(journal.part()).expect("read");
    let mut read = 0;
    for pair in lengths.windows(2) {
        let chunk = &bytes[pair[0] as usize..pair[1] as usize];
        let alone = [mcap::MAGIC, chunk].concat();
        let found = crate::wire::Container::new(alone).expect("MCAP");
        assert!(!found.damages().is_loss(), "{:?}", found.damages().first());
        assert_eq!(found.message_count(), 15);
        assert!(
            found
                .channels()
                .values()
                .all(|c| found.schema_of(c).is_some())
        );
        read += 1;
    }
    assert_eq!(read, 10);
}

/// However long nobody closes a chunk, it is bounded: what is in memory is lost by a kill.
#[test]
fn a_chunk_that_grows_too_large_is_closed() {
    let folder = tempfile::tempdir().expect("folder");
    let mut journal = journal(&folder.path().join("take.mcap"));
    let before = journal.whole;
    for k in 0..6000 {
        let receipt = Stamp(START + k * MS);
        journal.pose(0, receipt, &record(k), None).expect("write");
    }
    assert!(journal.whole > before && journal.open_bytes < CHUNK_BYTES);
}

#[test]
fn names_that_are_taken_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("take.mcap");
    let first = journal(&path);
    let again = |path: &Path| Journal::create(path, &[], "/marks", b"").map(|_| ());
    assert!(matches!(
        again(&path),
        Err(WriteError::Io {
            action: "create",
            ..
        })
    ));
    first.finish().expect("finish");
    assert!(matches!(again(&path), Err(WriteError::Exists { .. })));
    let discarded = folder.path().join("other.mcap");
    let aside = folder.path().join("discarded");
    let kept = journal(&discarded).set_aside(&aside).expect("moved");
    assert_eq!(kept, aside.join("other.mcap"));
    assert!(fs::read(&kept).is_ok());
    assert_eq!(fs::read_dir(folder.path()).expect("list").count(), 2);
}
