//! Every damage of a kind, one after the other: each bit of framing bytes, each page, each length.

use std::collections::BTreeMap;
use std::ops::Range;

use enact::service::{RecoveredLine, recover_all};
use enact::wire::container::Container;
use rayon::prelude::*;

use super::{Desk, numbers};
use crate::journals::{PAGE, Written, journal, messages_of, records};

/// Bytes of a chunk before its data: type, length, times, size, checksum, compression, length.
const CHUNK_HEAD: usize = 53;

/// Bytes of a chunk that are not needed to read it: type, length and times.
const CHUNK_SPARE: usize = 25;

/// Bytes of an index of messages before its entries: type, length, channel, length.
const INDEX_HEAD: usize = 15;

/// What is done to a journal.
#[derive(Clone, Debug)]
enum Damage {
    Flip(usize, u8),
    Zero(Range<usize>),
    Cut(usize),
}

impl Damage {
    fn of(&self, bytes: &[u8]) -> Vec<u8> {
        let mut bytes = bytes.to_vec();
        match self {
            Damage::Flip(at, bit) => bytes[*at] ^= 1 << bit,
            Damage::Zero(range) => bytes[range.clone()].fill(0),
            Damage::Cut(length) => bytes.truncate(*length),
        }
        bytes
    }

    /// Whether nothing of that range is changed.
    fn spares(&self, range: &Range<usize>) -> bool {
        match self {
            Damage::Flip(at, _) => !range.contains(at),
            Damage::Zero(zeroed) => range.end <= zeroed.start || zeroed.end <= range.start,
            Damage::Cut(length) => range.end <= *length,
        }
    }
}

/// What became of one damaged journal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Outcome {
    /// Nothing to recover: an error, and the journal as it was.
    Refused,
    /// Everything that was written.
    Whole,
    /// Less, and said so.
    Less,
}

/// Recovers what is left by the function that the command calls, and checks what must hold.
fn outcome(written: &Written, damage: &Damage) -> Outcome {
    let bytes = damage.of(&written.bytes);
    let desk = Desk::with(&bytes);
    let chunks = written.chunks.iter();
    let spared = chunks.filter(|(chunk, _)| damage.spares(chunk));
    let expected: Vec<usize> = spared.flat_map(|(_, held)| held.clone()).collect();
    let Some(line) = recovered(&desk) else {
        assert!(expected.is_empty(), "{damage:?}: chunks are whole");
        assert_eq!(std::fs::read(desk.part()).expect("kept"), bytes);
        assert!(!desk.recording().exists());
        return Outcome::Refused;
    };
    assert!(
        std::fs::read(&line.kept).expect("kept") == bytes,
        "{damage:?}"
    );
    assert_eq!(desk.names(), ["take.mcap", "take.mcap.part.recovered"]);
    let messages = messages_of(&desk.recording());
    let found = numbers(&messages, &written.messages);
    let found = found.unwrap_or_else(|error| panic!("{damage:?}: invented: {error}"));
    let is_there = |number: &usize| found.binary_search(number).is_ok();
    assert!(expected.iter().all(is_there), "{damage:?}: lost: {line:?}");
    assert_eq!(line.messages, messages.len() as u64, "{damage:?}");
    // Exit code 3 and the account of unread bytes go together.
    assert_eq!(line.whole, line.unread_bytes == 0, "{damage:?}: {line:?}");
    assert_eq!(line.whole, line.lost.is_empty(), "{damage:?}: {line:?}");
    let unread: u64 = line.unread.iter().map(|(from, to)| to - from).sum();
    assert_eq!(line.unread_bytes, unread);
    for (chunk, _) in written.chunks.iter().filter(|(c, _)| damage.spares(c)) {
        let is_in =
            |(from, to): &(u64, u64)| *from < chunk.end as u64 && (chunk.start as u64) < *to;
        assert!(!line.unread.iter().any(is_in), "{damage:?}: {line:?}");
    }
    let recording = Container::new(std::fs::read(desk.recording()).expect("read")).expect("MCAP");
    let scene = recording.attachments().first();
    let is_scene_there =
        scene.map(|scene| recording.attachment_data(scene)) == Some(&written.scene[..]);
    let is_all_there = match damage {
        // What ends early was all there is.
        Damage::Cut(_) => true,
        _ => is_scene_there && found.len() == written.messages.len(),
    };
    assert!(is_all_there || !line.whole, "{damage:?}: {line:?}");
    if line.whole {
        Outcome::Whole
    } else {
        Outcome::Less
    }
}

fn recovered(desk: &Desk) -> Option<RecoveredLine> {
    let mut lines = Vec::new();
    let folder = desk.folder.path().to_owned();
    recover_all(&[folder], |_, line| {
        lines.push(line.ok());
        Ok(())
    })
    .expect("a folder");
    assert_eq!(lines.len(), 1);
    lines.remove(0)
}

/// Bytes of no chunk's or attachment's data and of no index's entries.
fn framing(bytes: &[u8], indexed: bool) -> Vec<usize> {
    let mut found: Vec<usize> = (0..8).collect();
    for record in records(bytes, None) {
        let head = match bytes[record.start] {
            0x06 => CHUNK_HEAD,
            0x07 if !indexed => INDEX_HEAD,
            0x09 => {
                // Up to the data, and the checksum after them.
                found.extend(record.end - 4..record.end);
                let name = record.start + 9 + 16;
                let text = |at: usize| at + 4 + bytes[at] as usize;
                text(text(name)) + 8 - record.start
            }
            _ => record.len(),
        };
        found.extend(record.start..record.start + head);
    }
    found
}

fn flips(written: &Written, indexed: bool) -> Vec<Damage> {
    let places = framing(&written.bytes, indexed).into_iter();
    places
        .flat_map(|at| (0..8).map(move |bit| Damage::Flip(at, bit)))
        .collect()
}

fn pages(written: &Written) -> Vec<Damage> {
    let length = written.bytes.len();
    let starts = (0..length).step_by(PAGE);
    starts
        .map(|from| Damage::Zero(from..(from + PAGE).min(length)))
        .collect()
}

fn all(written: &Written, damages: &[Damage]) -> BTreeMap<Outcome, usize> {
    let outcomes: Vec<Outcome> = damages
        .par_iter()
        .map(|damage| outcome(written, damage))
        .collect();
    let mut counts = BTreeMap::new();
    for outcome in outcomes {
        *counts.entry(outcome).or_default() += 1;
    }
    counts
}

fn of(counts: &BTreeMap<Outcome, usize>, outcome: Outcome) -> usize {
    counts.get(&outcome).copied().unwrap_or(0)
}

#[test]
fn every_flipped_bit_of_framing_bytes_costs_at_most_its_chunk() {
    let written = journal(4, 60);
    let damages = flips(&written, false);
    assert!(damages.len() > 3000, "{}", damages.len());
    let counts = all(&written, &damages);
    // At least type, length and times of each chunk cost nothing.
    let spare = 8 * CHUNK_SPARE * written.chunks.len();
    assert!(of(&counts, Outcome::Whole) >= spare, "{counts:?}");
    assert_eq!(of(&counts, Outcome::Refused), 0, "{counts:?}");
}

#[test]
fn every_zeroed_page_is_said() {
    let written = journal(20, 40);
    let damages = pages(&written);
    assert!(damages.len() > 10, "{}", damages.len());
    let counts = all(&written, &damages);
    assert_eq!(counts, BTreeMap::from([(Outcome::Less, damages.len())]));
}

/// A journal that is cut where a record ends is whole, and nowhere else.
#[test]
fn every_cut_leaves_the_chunks_before_it() {
    let written = journal(4, 30);
    let lengths = 0..written.bytes.len();
    let damages: Vec<Damage> = lengths.map(Damage::Cut).collect();
    let counts = all(&written, &damages);
    let ends = records(&written.bytes, None).len();
    // The whole is not among the cuts.
    assert_eq!(of(&counts, Outcome::Whole), ends - 1, "{counts:?}");
    // The magic bytes and a part of the header are an error.
    let first = records(&written.bytes, None)[0].end;
    assert_eq!(of(&counts, Outcome::Refused), first, "{counts:?}");
}

/// The same through the program, where a journal begins and where chunks meet.
#[test]
fn exit_codes_say_whether_bytes_were_not_read() {
    let written = journal(3, 20);
    let chunk = &written.chunks[1].0;
    let index = records(&written.bytes, Some(0x07))[0].start;
    for (damage, expected) in [
        (Damage::Cut(8), 1),
        (Damage::Cut(0), 1),
        (Damage::Cut(chunk.start), 0),
        (Damage::Cut(chunk.end - 1), 3),
        // The type of a chunk; that of an index becomes a message, and an end; the checksum.
        (Damage::Flip(chunk.start, 2), 0),
        (Damage::Flip(index, 1), 3),
        (Damage::Flip(index, 3), 3),
        (Damage::Flip(chunk.start + 34, 0), 3),
        (Damage::Zero(0..PAGE), 3),
    ] {
        let bytes = damage.of(&written.bytes);
        let desk = Desk::with(&bytes);
        let (code, said) = desk.recover();
        assert_eq!(code, expected, "{damage:?}: {said}");
        let kept = said["kept"].as_str().map_or(desk.part(), Into::into);
        assert_eq!(desk.recording().exists(), code != 1);
        assert!(std::fs::read(kept).expect("kept") == bytes);
    }
}

/// A journal of half a megabyte, damaged in every way of a kind; the line that is committed with what was measured.
fn of_half_a_megabyte(kind: &str, damages: impl Fn(&Written) -> Vec<Damage>) {
    let written = journal(40, 110);
    let length = written.bytes.len();
    assert!((480_000..600_000).contains(&length), "{length}");
    let damages = damages(&written);
    let counts = all(&written, &damages);
    let line = serde_json::json!({
        "damage": kind,
        "journal_bytes": length,
        "chunks": written.chunks.len(),
        "messages": written.messages.len(),
        "tried": damages.len(),
        "whole": of(&counts, Outcome::Whole),
        "less_and_said": of(&counts, Outcome::Less),
        "nothing_to_recover": of(&counts, Outcome::Refused),
        "lost_of_whole_chunks": 0,
        "invented": 0,
        "journals_gone": 0,
    });
    println!("{line}");
}

#[test]
#[ignore = "half a minute: cargo test --release --test recover -- --ignored --nocapture half_a_megabyte"]
fn every_page_of_half_a_megabyte() {
    of_half_a_megabyte("zeroed pages", pages);
}

#[test]
#[ignore = "minutes: cargo test --release --test recover -- --ignored --nocapture half_a_megabyte"]
fn every_framing_bit_of_half_a_megabyte() {
    of_half_a_megabyte("flipped bits of framing bytes", |written| {
        flips(written, false)
    });
}

#[test]
#[ignore = "an hour: cargo test --release --test recover -- --ignored --nocapture half_a_megabyte"]
fn every_cut_of_half_a_megabyte() {
    of_half_a_megabyte("cuts", |written| {
        (0..written.bytes.len()).map(Damage::Cut).collect()
    });
}
