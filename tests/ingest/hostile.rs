//! Files that were made to cost memory and time: what the program takes for any of them is bounded by
//! their size, what it does not read it says, and it never panics.
#![cfg(target_os = "linux")]

mod inside;
mod long;
mod run;

use crate::raw_mcap::{
    CHUNK, MAGIC, MESSAGE, beginning, chunk, chunk_head, file, message, pose, record,
};
use run::{Cost, run};
use std::path::Path;

/// What any file may cost beside a hundred times its size.
const LEAST_BYTES: u64 = 256 << 20;

/// The tests' program is built with little optimisation; a build for users takes a quarter.
const PROCESSOR_S: f64 = 30.0;

/// Runs a command on a file of these bytes and checks that the cost is bounded.
fn cost(name: &str, bytes: &[u8], command: &[&str]) -> Cost {
    let folder = tempfile::tempdir().expect("folder");
    let input = folder.path().join(name);
    std::fs::write(&input, bytes).expect("write");
    let output = folder.path().join("out");
    let [output_csv, output_toml] = ["csv", "toml"].map(|ending| output.with_extension(ending));
    let arguments: Vec<&str> = command
        .iter()
        .map(|word| match *word {
            "IN" => input.to_str().expect("a name"),
            "OUT" => output.to_str().expect("a name"),
            "OUT.csv" => output_csv.to_str().expect("a name"),
            "OUT.toml" => output_toml.to_str().expect("a name"),
            word => word,
        })
        .collect();
    let cost = run(&arguments, folder.path());
    let Cost {
        peak_bytes,
        processor_s,
        ..
    } = cost;
    println!(
        "{:>9} bytes, {:>4} MB, {processor_s:>5.2} s, exit {:?}: {}",
        bytes.len(),
        peak_bytes >> 20,
        cost.code,
        command.join(" ")
    );
    let said = format!("{}{}", cost.stdout, cost.stderr);
    let said: String = said.chars().take(2000).collect();
    assert!(matches!(cost.code, Some(0 | 1 | 3)), "{command:?}: {said}");
    assert!(!said.contains("panicked"), "{said}");
    let limit = 100 * bytes.len() as u64 + LEAST_BYTES;
    // Of one that has ended at once nothing was seen.
    assert!(peak_bytes < limit, "{command:?}: {peak_bytes} bytes");
    assert!(processor_s < PROCESSOR_S, "{command:?}: {processor_s} s");
    assert!(cost.stdout.len() < 4 << 20 && cost.stderr.len() < 1 << 20);
    cost
}

const INSPECT: &[&str] = &["inspect", "IN"];
const PROCESS: &[&str] = &["process", "IN", "-o", "OUT", "--deadline", "10s"];
const MARK: &[&str] = &["mark", "IN", "--propose"];
const EXPORT: &[&str] = &["export", "IN", "--to", "csv", "-o", "OUT"];
const REPORT: &[&str] = &["report", "IN", "-o", "OUT"];
const PREDICT: &[&str] = &["predict", "IN", "-o", "OUT", "--deadline", "10s"];
const SKETCH: &[&str] = &["sketch", "IN", "-o", "OUT.csv"];
const IMPORT: &[&str] = &["import", "IN", "-o", "OUT"];
const PIVOT: &[&str] = &["calibrate", "pivot", "IN", "-o", "OUT.toml"];
const GRAVITY: &[&str] = &["calibrate", "gravity", "IN", "-o", "OUT.toml"];
const REST: &[&str] = &["calibrate", "rest", "IN", "-o", "OUT.toml"];
const RECOVER: &[&str] = &["recover", "IN"];

/// All commands that read recordings; returns what `inspect` said.
fn costs(bytes: &[u8]) -> Cost {
    for command in [
        PROCESS, PREDICT, MARK, SKETCH, IMPORT, EXPORT, REPORT, PIVOT, GRAVITY, REST,
    ] {
        cost("take.mcap", bytes, command);
    }
    cost("take.mcap.part", bytes, RECOVER);
    cost("take.mcap", bytes, INSPECT)
}

/// Messages that repeat until they fill `bytes`, beginning with a different one for each `seed`.
fn repeated(message: &[u8], bytes: usize, seed: u64) -> Vec<u8> {
    let mut records = crate::raw_mcap::message(9, seed, b"");
    while records.len() < bytes {
        records.extend_from_slice(message);
    }
    records
}

/// Chunks that unpack to gigabytes, with poses of one time on the scene's topic.
#[test]
fn a_bomb_of_chunks_is_read_up_to_a_limit_that_is_said() {
    for (compression, each, count) in [("zstd", 60 << 20, 12), ("lz4", 16 << 20, 8)] {
        let pose = message(1, 5, &pose(5));
        let chunks: Vec<Vec<u8>> = (0..count)
            .map(|seed| chunk(compression, &repeated(&pose, each, seed)))
            .collect();
        let bytes = file(&[&beginning(), &chunks.concat()]);
        let found = costs(&bytes);
        assert_eq!(found.code, Some(3), "{}", found.stdout);
        assert!(
            found.peak_bytes > 16 << 20,
            "{} is not measured",
            found.peak_bytes
        );
        if compression == "zstd" {
            let said = "the chunks unpack to more than 64 times the file's size and 64 MiB";
            assert!(bytes.len() < 200_000, "{}", bytes.len());
            assert!(found.stdout.contains(said), "{}", found.stdout);
        }
        let said = "messages on the scene's topics were not read";
        assert!(found.stdout.contains(said), "{}", found.stdout);
    }
}

/// What was read before the limit is estimated, and the account says what was not read.
#[test]
fn a_bomb_behind_a_take_costs_what_is_in_the_bomb() {
    let recording = Path::new(env!("CARGO_MANIFEST_DIR")).join("recordings/pencil_tip.mcap");
    let mut bytes = std::fs::read(recording).expect("a recording");
    let end = (MAGIC.len()..).find(|at| bytes[*at..].starts_with(&record(0x0f, &[0; 4])[..9]));
    bytes.truncate(end.expect("the end of the data"));
    for seed in 0..3 {
        bytes.extend_from_slice(&chunk(
            "zstd",
            &repeated(&message(9, 5, b""), 60 << 20, seed),
        ));
    }
    let found = cost("take.mcap", &bytes, PROCESS);
    assert_eq!(found.code, Some(3), "{}", found.stdout);
    assert!(
        found.stdout.contains("physical, fits well"),
        "{}",
        found.stdout
    );
    let said = "bytes were not read: the chunks unpack to more than";
    assert!(found.stdout.contains(said), "{}", found.stdout);
}

/// The beginning of a chunk at every sixty bytes, each of which unpacks to 64 MiB and fails its
/// checksum: a block of zstd skips those that follow, and all share the blocks at the end.
#[test]
fn a_search_through_bombs_is_given_up() {
    const STEP: usize = 64;
    const COUNT: usize = 1000;
    let mut tail = Vec::new();
    for block in 0..512_u32 {
        // A block that repeats one byte 131,072 times; the last says so.
        let head = (128 << 10) << 3 | 1 << 1 | u32::from(block == 511);
        tail.extend_from_slice(&head.to_le_bytes()[..3]);
        tail.push(0);
    }
    let mut bytes = MAGIC.to_vec();
    bytes.extend_from_slice(b"no record");
    for index in 0..COUNT {
        let skipped = (COUNT - index - 1) * STEP;
        let frame = [0x28, 0xb5, 0x2f, 0xfd, 0, 0x80];
        let raw = ((skipped as u32) << 3).to_le_bytes();
        let packed = frame.len() + 3 + skipped + tail.len();
        let mut head = vec![CHUNK];
        head.extend_from_slice(&u64::MAX.to_le_bytes());
        head.extend_from_slice(&chunk_head("zstd", 64 << 20, 77, packed as u64));
        head.extend_from_slice(&frame);
        head.extend_from_slice(&raw[..3]);
        assert!(head.len() <= STEP);
        // What is left of the step is skipped too.
        let mut step = vec![0; STEP - head.len()];
        step.extend_from_slice(&head);
        bytes.extend_from_slice(&step);
    }
    bytes.extend_from_slice(&tail);
    let found = costs(&bytes);
    assert_eq!(found.code, Some(3), "{}", found.stdout);
    let said = "after too much work in vain";
    assert!(found.stdout.contains(said), "{}", found.stdout);
}

/// Every record could be an attachment, or a chunk, that reaches to the end of the file and fails
/// its checksum.
#[test]
fn records_that_would_each_be_hashed_to_the_end_are_not() {
    const COUNT: usize = 30_000;
    let step = record(0x90, &[0; 47]).len();
    for is_chunk in [false, true] {
        let mut records = Vec::new();
        for index in 0..COUNT {
            let after = (COUNT - index - 1) * step;
            let mut body = if is_chunk {
                let length = (after + 3) as u64;
                chunk_head("", length, 77, length)
            } else {
                let length = (after + 3) as u64;
                [&[0; 24][..], &length.to_le_bytes()].concat()
            };
            body.resize(47, 1);
            records.extend_from_slice(&record(0x90, &body));
        }
        records.extend_from_slice(&[1; 8]);
        let found = costs(&file(&[&beginning(), &records]));
        assert!(matches!(found.code, Some(0 | 3)), "{}", found.stdout);
    }
}

/// With too little time reading ends, which is said, and nothing is written.
#[test]
fn a_deadline_ends_reading_and_estimating() {
    let poses: Vec<u8> = (0..200_000)
        .flat_map(|k| message(1, k * 1_000_000, &pose(k * 1_000_000)))
        .collect();
    let bytes = file(&[&beginning(), &poses]);
    let found = cost("take.mcap", &bytes, &["inspect", "IN", "--deadline", "1ms"]);
    assert_eq!(found.code, Some(3), "{}", found.stdout);
    assert!(found.stdout.contains("the time limit"), "{}", found.stdout);
    let command = ["process", "IN", "-o", "OUT", "--deadline", "1ms"];
    let found = cost("take.mcap", &bytes, &command);
    assert_eq!(found.code, Some(1), "{}", found.stdout);
    assert!(
        found.stderr.contains("give it more by --deadline"),
        "{}",
        found.stderr
    );
    // An estimation that is stopped says so too.
    let recording = Path::new(env!("CARGO_MANIFEST_DIR")).join("recordings/pencil_tip.mcap");
    let recording = std::fs::read(recording).expect("a recording");
    let begun = std::time::Instant::now();
    let command = ["replay", "IN", "-o", "OUT", "--deadline", "1000s"];
    let whole = cost("take.mcap", &recording, &command);
    assert_eq!(whole.code, Some(0), "{}", whole.stdout);
    // Between a limit that is over before all is read and one that is not over before all is done; how
    // long that takes differs from run to run.
    let takes_s = begun.elapsed().as_secs_f64();
    let (mut low_s, mut high_s) = (0.0, takes_s);
    let mut stopped = false;
    for _ in 0..60 {
        let limit_s = 0.5 * (low_s + high_s);
        let limit = format!("{}us", (limit_s * 1e6) as u64 + 1);
        let command = ["replay", "IN", "-o", "OUT", "--deadline", &limit];
        let found = cost("take.mcap", &recording, &command);
        let is_stopped = found.stdout.contains("ended at its deadline");
        let is_unread = found.stderr.contains("give it more by --deadline");
        let expected = if is_unread {
            Some(1)
        } else if is_stopped {
            Some(3)
        } else {
            Some(0)
        };
        assert_eq!(
            found.code, expected,
            "{limit}: {}{}",
            found.stdout, found.stderr
        );
        match (is_unread, is_stopped) {
            (true, _) => low_s = limit_s,
            (_, false) => high_s = limit_s,
            (_, true) => stopped = true,
        }
        if stopped {
            break;
        }
        if high_s - low_s < 1e-4 {
            (low_s, high_s) = (0.5 * low_s, 1.5 * high_s);
        }
    }
    assert!(stopped, "no estimation of {takes_s} s was stopped");
    for wrong in ["0s", "1", "-1s", "soon", "inf"] {
        let folder = tempfile::tempdir().expect("folder");
        let found = run(&["inspect", "x.mcap", "--deadline", wrong], folder.path());
        assert_eq!(found.code, Some(2), "{wrong}");
    }
}

/// Commands that have nothing to show before they are done end at their deadline, say so, and leave
/// nothing beside their input.
#[test]
fn a_deadline_ends_every_other_command() {
    let poses: Vec<u8> = (0..200_000)
        .flat_map(|k| message(1, k * 1_000_000, &pose(k * 1_000_000)))
        .collect();
    let bytes = file(&[&beginning(), &poses]);
    for command in [MARK, EXPORT, REPORT, IMPORT, PIVOT, GRAVITY, REST, RECOVER] {
        let [folder, aside] = [0, 1].map(|_| tempfile::tempdir().expect("folder"));
        let is_journal = command == RECOVER;
        let input = folder
            .path()
            .join(if is_journal { "a.mcap.part" } else { "a.mcap" });
        std::fs::write(&input, &bytes).expect("write");
        let output = folder.path().join("out.toml");
        let words = command.iter().map(|word| match *word {
            "IN" => input.to_str().expect("a name"),
            "OUT" | "OUT.toml" => output.to_str().expect("a name"),
            word => word,
        });
        let words: Vec<&str> = words.chain(["--deadline", "1ms"]).collect();
        let found = run(&words, aside.path());
        assert_eq!(found.code, Some(1), "{command:?}: {}", found.stdout);
        let is_said = found.stderr.contains("give it more by --deadline");
        assert!(is_said, "{command:?}: {}", found.stderr);
        let left = std::fs::read_dir(folder.path()).expect("list");
        let left: Vec<_> = left.map(|entry| entry.expect("an entry").path()).collect();
        assert_eq!(left, std::slice::from_ref(&input), "{command:?}");
        assert_eq!(std::fs::read(&input).expect("read"), bytes);
    }
}

/// A file without chunks whose checksum fails is used, and what may be wrong is said; one whose records do
/// not lead from one to the next is read up to there.
#[test]
fn of_a_damaged_file_it_is_said_what_is_believed() {
    let mut records = beginning();
    let mut starts = Vec::new();
    for k in 0..200_u64 {
        starts.push(records.len());
        records.extend_from_slice(&message(1, k * 5_000_000, &pose(k * 5_000_000)));
    }
    let mut bytes = file(&[&records]);
    // Before the records are the magic bytes and the header.
    let first = MAGIC.len() + 9 + 8;
    assert_eq!(bytes[first + starts[50]], MESSAGE);
    // The checksum of the data section.
    let end = first + records.len();
    assert_eq!(bytes[end], 0x0f);
    let crc = crc32fast::hash(&bytes[..end]);
    bytes[end + 9..end + 13].copy_from_slice(&crc.to_le_bytes());
    let whole = cost("take.mcap", &bytes, INSPECT);
    assert_eq!(whole.code, Some(0), "{}", whole.stdout);
    assert!(whole.stdout.contains(" 200 messages"), "{}", whole.stdout);
    // A byte of a position: no record of it is verified.
    let mut wrong = bytes.clone();
    wrong[first + starts[50] + 60] ^= 1;
    let found = cost("take.mcap", &wrong, INSPECT);
    assert_eq!(found.code, Some(3), "{}", found.stdout);
    let said = "any of the 200 messages without one of their own may be wrong";
    assert!(found.stdout.contains(said), "{}", found.stdout);
    // A byte of a length.
    let mut broken = bytes.clone();
    broken[first + starts[50] + 4] ^= 0x20;
    for command in [INSPECT, MARK, PROCESS] {
        let found = cost("take.mcap", &broken, command);
        assert_ne!(found.code, Some(0), "{}", found.stdout);
    }
    let found = cost("take.mcap", &broken, INSPECT);
    assert_eq!(found.code, Some(3), "{}", found.stdout);
    assert!(found.stdout.contains(" 50 messages"), "{}", found.stdout);
    assert!(found.stdout.contains("cut off"), "{}", found.stdout);
}
