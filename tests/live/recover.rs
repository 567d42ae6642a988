//! Journals that were damaged in every way: nothing that is still there is lost, nothing is made
//! up, and the account says what could not be read.

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use enact::wire::container::Damage;
use enact::write::{Recovered, WriteError, abandoned, recover};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use serde_json::Value;

mod every;
mod killed;

use crate::journals::{Blow, Hit, Message, PAGE, Written, journal, messages_of, open_journal};

/// A folder with one journal in it.
struct Desk {
    folder: tempfile::TempDir,
}

impl Desk {
    fn with(bytes: &[u8]) -> Self {
        // In memory, where there is such a place: a recording is synced, and there are hundreds.
        let memory = Path::new("/dev/shm");
        let folder = if memory.is_dir() {
            tempfile::tempdir_in(memory)
        } else {
            tempfile::tempdir()
        };
        let folder = folder.expect("folder");
        let desk = Self { folder };
        std::fs::write(desk.part(), bytes).expect("write");
        desk
    }

    fn part(&self) -> PathBuf {
        self.folder.path().join("take.mcap.part")
    }

    fn recording(&self) -> PathBuf {
        self.folder.path().join("take.mcap")
    }

    /// The files in it.
    fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).expect("list");
        let name = |entry: std::fs::DirEntry| entry.file_name().to_string_lossy().into_owned();
        let mut names: Vec<String> = entries.map(|entry| name(entry.expect("entry"))).collect();
        names.sort();
        names
    }

    /// Runs the program on it: exit code and account.
    fn recover(&self) -> (i32, Value) {
        let mut command = Command::cargo_bin("enact").expect("enact");
        command
            .args(["recover", "--format", "ndjson"])
            .arg(self.folder.path());
        let output = command.output().expect("run");
        let said = String::from_utf8_lossy(&output.stdout);
        let said = serde_json::from_str(said.trim()).unwrap_or(Value::Null);
        (output.status.code().expect("a code"), said)
    }
}

/// The numbers of the messages of `part` in `whole`: every one of them is there, bit for bit, and
/// after the one before.
fn numbers(part: &[Message], whole: &[Message]) -> Result<Vec<usize>, TestCaseError> {
    let mut from = 0;
    let mut found = Vec::new();
    for message in part {
        let at = whole[from..].iter().position(|other| other == message);
        let Some(at) = at else {
            return Err(TestCaseError::fail(format!(
                "{} {} was not written, or not there",
                message.0, message.1
            )));
        };
        found.push(from + at);
        from += at + 1;
    }
    Ok(found)
}

/// What must hold of any journal that was hit and recovered.
fn check(written: &Written, hit: &Hit) -> Result<(), TestCaseError> {
    let bytes = hit.bytes();
    let desk = Desk::with(&bytes);
    let untouched = hit.untouched(written);
    let holds = |number: &usize| !written.chunks[*number].1.is_empty();
    let recovered = match recover(&desk.part()) {
        Ok(recovered) => recovered,
        Err(WriteError::Container { .. }) => {
            prop_assert!(untouched.is_empty(), "chunks are whole and were not found");
            prop_assert!(std::fs::read(desk.part()).expect("kept") == bytes);
            return Ok(());
        }
        Err(error) => return Err(TestCaseError::fail(error.to_string())),
    };
    prop_assert!(std::fs::read(&recovered.journal).expect("kept") == bytes);
    prop_assert!(!desk.part().exists());
    prop_assert!(abandoned(desk.folder.path()).expect("list").is_empty());

    let messages = messages_of(&desk.recording());
    let found = numbers(&messages, &written.messages)?;
    for number in untouched.keys().filter(|number| holds(number)) {
        let all = written.chunks[*number].1.clone();
        prop_assert!(
            all.clone()
                .all(|message| found.binary_search(&message).is_ok()),
            "chunk {} is whole and its messages are not all there",
            number
        );
    }
    let said: u64 = recovered.topics.iter().map(|(_, messages)| messages).sum();
    prop_assert_eq!(said, messages.len() as u64);
    check_unread(&recovered, (written, hit), &found)
}

/// Bytes that were not read are stated exactly where something is missing.
fn check_unread(
    recovered: &Recovered,
    (written, hit): (&Written, &Hit),
    found: &[usize],
) -> Result<(), TestCaseError> {
    let untouched = hit.untouched(written);
    let unread = &recovered.unread;
    let length = hit.bytes().len();
    prop_assert_eq!(recovered.bytes, length as u64);
    prop_assert!(
        unread
            .iter()
            .all(|range| range.start < range.end && range.end <= length)
    );
    prop_assert!(unread.windows(2).all(|pair| pair[0].end < pair[1].start));
    for (number, chunk) in &untouched {
        let is_in =
            |range: &std::ops::Range<usize>| range.start < chunk.end && chunk.start < range.end;
        prop_assert!(
            !unread.iter().any(is_in),
            "chunk {number} is said not to be read"
        );
    }
    prop_assert!(unread.is_empty() || !recovered.is_whole);
    for (chunk, held) in &written.chunks {
        let is_missing = |message: &usize| found.binary_search(message).is_err();
        if held.clone().any(|message| is_missing(&message)) {
            // A chunk whose type, length and times are gone is read, and those of another may
            // stand in their place.
            let is_head = |damage: &Damage, at: usize| matches!(*damage, Damage::Frame { at: from } if (from..from + 25).contains(&at));
            let is_unread = |at: &usize| {
                let is_in_head = recovered.damages.iter().any(|damage| is_head(damage, *at));
                is_in_head || unread.iter().any(|range| range.contains(at))
            };
            let remains = hit.remains_of(chunk);
            let left = remains.iter().filter(|at| !is_unread(at));
            let left: Vec<&usize> = left.take(9).collect();
            prop_assert!(
                left.is_empty(),
                "{left:?} of {chunk:?}: {:?}",
                recovered.damages
            );
            prop_assert!(remains.is_empty() || !recovered.is_whole);
        }
    }
    Ok(())
}

fn blow() -> impl Strategy<Value = Blow> {
    prop_oneof![
        (any::<u32>(), any::<u8>()).prop_map(|(at, bit)| Blow::FlipBit(at, bit)),
        any::<u32>().prop_map(Blow::ZeroPage),
        any::<u32>().prop_map(Blow::Cut),
        (any::<u32>(), any::<u16>()).prop_map(|(at, count)| Blow::Repeat(at, count)),
        (any::<u32>(), 0..9000_u16).prop_map(|(at, count)| Blow::Remove(at, count)),
    ]
}

fn runner(cases: u32, seed: u8) -> TestRunner {
    let config = Config::with_cases(cases);
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[seed; 32]);
    TestRunner::new_with_rng(config, rng)
}

#[test]
fn whatever_happens_to_a_journal_what_is_left_is_recovered_and_nothing_else() {
    let sizes = [(1, 3), (3, 40), (12, 10), (40, 25), (60, 75)];
    let written: Vec<Written> = sizes.iter().map(|(c, s)| journal(*c, *s)).collect();
    let blows = prop::collection::vec(blow(), 1..5);
    runner(400, 11)
        .run(&(0..written.len(), blows), |(which, blows)| {
            let mut hit = Hit::new(&written[which].bytes);
            blows.iter().for_each(|blow| hit.strike(blow));
            check(&written[which], &hit)
        })
        .expect("recovered");
}

#[test]
fn no_bit_of_a_chunks_frame_and_header_costs_more_than_its_chunk() {
    let written = journal(6, 20);
    for (chunk, held) in [0, 1, 6].map(|number| &written.chunks[number]) {
        // Type, length, times, size, checksum, compression, length.
        for bit in chunk.start * 8..(chunk.start + 53) * 8 {
            let mut hit = Hit::new(&written.bytes);
            let share = ((bit / 8) as u64) << 32;
            let share = share.div_ceil(written.bytes.len() as u64) as u32;
            hit.strike(&Blow::FlipBit(share, (bit % 8) as u8));
            assert_ne!(hit.bytes()[bit / 8], written.bytes[bit / 8]);
            check(&written, &hit).unwrap_or_else(|error| panic!("bit {bit}: {error}"));
            // Type, length and times are not needed.
            if bit / 8 < chunk.start + 25 {
                let desk = Desk::with(&hit.bytes());
                let recovered = recover(&desk.part()).expect("recovered");
                assert!(
                    recovered.is_whole && recovered.unread.is_empty(),
                    "bit {bit}"
                );
                assert_eq!(messages_of(&desk.recording()), written.messages, "{held:?}");
            }
        }
    }
}

#[test]
fn without_damage_every_byte_is_read_and_a_missing_end_is_no_loss() {
    let written = journal(5, 30);
    let desk = Desk::with(&written.bytes);
    let (code, said) = desk.recover();
    assert_eq!(
        (code, &said["whole"], &said["unread_bytes"]),
        (0, &true.into(), &0.into())
    );
    assert_eq!(said["lost"].as_array().map(Vec::len), Some(0), "{said}");
    assert_eq!(messages_of(&desk.recording()), written.messages);
    let kept = PathBuf::from(said["kept"].as_str().expect("a path"));
    assert_eq!(kept, desk.folder.path().join("take.mcap.part.recovered"));
    assert!(std::fs::read(kept).expect("kept") == written.bytes);
    // Nothing is left to recover.
    assert_eq!(desk.recover(), (0, Value::Null));
}

#[test]
fn a_journal_whose_last_chunk_is_not_whole_is_said_to_have_lost_those_bytes() {
    let written = journal(5, 30);
    let last = &written.chunks[5];
    let desk = Desk::with(&written.bytes[..last.0.start + 100]);
    let (code, said) = desk.recover();
    assert_eq!((code, &said["unread_bytes"]), (3, &100.into()), "{said}");
    assert_eq!(said["unread"][0][0], last.0.start);
    assert_eq!(
        messages_of(&desk.recording()),
        written.messages[..last.1.start]
    );
}

/// A bit of the length of the second chunk: it is read as its own header says.
#[test]
fn a_damaged_length_costs_nothing() {
    let written = journal(90, 75);
    assert!(written.messages.len() > 6863, "{}", written.messages.len());
    for bit in [0, 9, 21, 40, 63] {
        let mut bytes = written.bytes.clone();
        bytes[written.chunks[1].0.start + 1 + bit / 8] ^= 1 << (bit % 8);
        let desk = Desk::with(&bytes);
        let (code, said) = desk.recover();
        assert_eq!(messages_of(&desk.recording()), written.messages);
        assert_eq!((code, &said["unread_bytes"]), (0, &0.into()), "{said}");
        assert_eq!(said["notes"].as_array().map(Vec::len), Some(2), "{said}");
        assert!(std::fs::read(said["kept"].as_str().expect("a path")).expect("kept") == bytes);
    }
}

/// Every page of a journal zeroed, through the program: what is not in the page is there, whatever
/// was defined in it.
#[test]
fn a_zeroed_page_costs_the_chunks_it_touches_and_is_said() {
    let written = journal(24, 40);
    for page in 0..written.bytes.len() / PAGE {
        let mut hit = Hit::new(&written.bytes);
        let at = ((page * PAGE + 9) as u64) << 32;
        hit.strike(&Blow::ZeroPage((at / written.bytes.len() as u64) as u32));
        let desk = Desk::with(&hit.bytes());
        let (code, said) = desk.recover();
        assert_eq!((code, &said["whole"]), (3, &false.into()), "{said}");
        assert!(
            said["unread_bytes"].as_u64() >= Some(PAGE as u64 / 2),
            "{said}"
        );
        assert_eq!(
            desk.recording().exists(),
            said["messages"].as_u64() > Some(0)
        );
        let whole = hit.untouched(&written);
        let expected: usize = whole.keys().map(|n| written.chunks[*n].1.len()).sum();
        assert_eq!(
            messages_of(&desk.recording()).len(),
            expected,
            "page {page}"
        );
        assert!(
            std::fs::read(said["kept"].as_str().expect("a path")).expect("kept") == hit.bytes()
        );
    }
}

#[test]
fn no_file_is_ever_replaced() {
    let written = journal(2, 10);
    let desk = Desk::with(&written.bytes);
    let beside = |name: &str| desk.folder.path().join(name);
    std::fs::write(beside("take.mcap.part.recovered"), b"earlier").expect("write");
    std::fs::write(beside("take.mcap.part.recovered.2"), b"later").expect("write");
    let recovered = recover(&desk.part()).expect("recovered");
    assert_eq!(recovered.journal, beside("take.mcap.part.recovered.3"));
    assert_eq!(
        std::fs::read(beside("take.mcap.part.recovered")).expect("read"),
        b"earlier"
    );
    // The recording's name is taken now, and another journal waits for it.
    std::fs::write(desk.part(), &journal(3, 10).bytes).expect("write");
    let before = std::fs::read(desk.recording()).expect("read");
    assert!(matches!(
        recover(&desk.part()),
        Err(WriteError::Exists { .. })
    ));
    assert_eq!(desk.recover().0, 1);
    assert!(std::fs::read(desk.recording()).expect("read") == before && desk.part().exists());
}

/// A file that comes by a take's name while it is recorded is left alone, and the take is whole
/// under its own.
#[test]
fn closing_a_take_replaces_nothing() {
    let written = journal(3, 20);
    for is_salvaged in [false, true] {
        let desk = Desk::with(b"");
        std::fs::remove_file(desk.part()).expect("remove");
        let journal = open_journal(&desk.recording(), 3, 20);
        std::fs::write(desk.recording(), b"came meanwhile").expect("write");
        let ended = if is_salvaged {
            journal.salvage()
        } else {
            journal.finish()
        };
        let error = ended.expect_err("the name is taken");
        assert!(matches!(error, WriteError::Exists { .. }), "{error}");
        let theirs = std::fs::read(desk.recording()).expect("read");
        assert_eq!(theirs, b"came meanwhile");
        assert_eq!(desk.recover().0, 1);
        assert_eq!(desk.names(), ["take.mcap", "take.mcap.part"]);
        std::fs::remove_file(desk.recording()).expect("remove");
        assert_eq!(desk.recover().0, 0);
        assert_eq!(messages_of(&desk.recording()), written.messages);
    }
}

/// One kind of damage, many times: share of messages kept, journals gone, exit codes.
fn shares(name: &str, mut blow: impl FnMut(usize) -> Blow) {
    use std::collections::BTreeMap;
    let (mut kept, mut least, mut gone, mut whole) = (0.0, 1.0_f64, 0, 0);
    let mut codes: BTreeMap<i32, usize> = BTreeMap::new();
    for k in 0..200 {
        let written = journal(20 + k % 60, 5 + k * 7 % 70);
        let mut hit = Hit::new(&written.bytes);
        hit.strike(&blow(k));
        let desk = Desk::with(&hit.bytes());
        let (code, said) = desk.recover();
        *codes.entry(code).or_default() += 1;
        let found = said["messages"].as_u64().unwrap_or(0) as f64;
        let share = found / written.messages.len() as f64;
        kept += share / 200.0;
        least = least.min(share);
        whole += usize::from(share == 1.0);
        let path = said["kept"].as_str().map_or(desk.part(), PathBuf::from);
        gone += usize::from(std::fs::read(path).ok() != Some(hit.bytes()));
    }
    println!(
        "{name}: kept {:.2} % of messages, least {:.2} %, all in {whole} of 200; journals gone {gone}; exit codes {codes:?}",
        kept * 100.0,
        least * 100.0
    );
    assert_eq!(gone, 0);
}

#[test]
#[ignore = "measures: cargo test --test recover -- --ignored --nocapture shares"]
fn shares_of_damaged_journals_that_are_kept() {
    use rand::{RngExt, SeedableRng};
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(2026);
    shares("a zeroed page", |_| Blow::ZeroPage(random.random()));
    shares("a flipped bit", |_| {
        Blow::FlipBit(random.random(), random.random())
    });
    shares("a cut", |_| Blow::Cut(random.random()));
}
