//! Files that were made to cost memory and time: what the program takes for any of them is bounded by
//! their size, what it does not read it says, and it never panics.
#![cfg(target_os = "linux")]

#[path = "hostile/mcap.rs"]
mod mcap;
#[path = "hostile/run.rs"]
mod run;

use mcap::{
    CHANNEL, CHUNK, MAGIC, MESSAGE, METADATA, SCENE, SCHEMA, TOPIC, attachment, beginning, channel,
    chunk, chunk_head, file, message, pose, record, schema, text,
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
    assert!(cost.stdout.len() < 1 << 20 && cost.stderr.len() < 1 << 20);
    cost
}

const INSPECT: &[&str] = &["inspect", "IN"];
const PROCESS: &[&str] = &["process", "IN", "-o", "OUT", "--deadline", "10s"];
const MARK: &[&str] = &["mark", "IN", "--propose"];
const EXPORT: &[&str] = &["export", "IN", "--to", "csv", "-o", "OUT"];
const RECOVER: &[&str] = &["recover", "IN"];

/// All commands that read recordings; returns what `inspect` said.
fn costs(bytes: &[u8]) -> Cost {
    for command in [PROCESS, MARK, EXPORT] {
        cost("take.mcap", bytes, command);
    }
    cost("take.mcap.part", bytes, RECOVER);
    cost("take.mcap", bytes, INSPECT)
}

/// Messages that repeat until they fill `bytes`, beginning with a different one for each `seed`.
fn repeated(message: &[u8], bytes: usize, seed: u64) -> Vec<u8> {
    let mut records = mcap::message(9, seed, b"");
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

#[test]
fn definitions_without_number_are_bounded() {
    let long = "n".repeat(1000);
    let zstd = |records: &[u8]| chunk("zstd", records);
    // As many channels as there can be, with long names; and one that is defined again and again.
    let channels: Vec<u8> = (1..=u16::MAX)
        .flat_map(|id| channel(id, 0, &format!("/{long}{id}"), &long[..20], b""))
        .collect();
    let mut again = Vec::new();
    for index in 0..1_000_000_u32 {
        again.extend_from_slice(&channel(7, 3, &format!("/{index}"), "", b""));
    }
    let mut schemas = Vec::new();
    for index in 0..1_000_000_u32 {
        schemas.extend_from_slice(&schema(3, &format!("{index}"), b""));
    }
    // Each pair takes ten times as much in memory.
    let mut pairs = Vec::new();
    for index in 0..4_000_000_u32 {
        pairs.extend_from_slice(&text(&index.to_le_bytes()));
        pairs.extend_from_slice(&text(b""));
    }
    let one = channel(8, 0, "/pairs", "", &pairs);
    let many: Vec<u8> = (1..60_u16)
        .flat_map(|id| channel(id, 0, &format!("/{id}"), "", &pairs[..12 * 80_000]))
        .collect();
    let large = schema(3, "large", &vec![0; 60 << 20]);
    for (name, records, is_lossy) in [
        (
            "channels",
            &channels[..whole_records(&channels, 60 << 20)],
            true,
        ),
        ("again", &again, true),
        ("schemas", &schemas, true),
        ("pairs", &one, true),
        ("many pairs", &many, true),
        ("large", &large, false),
    ] {
        println!("{name}");
        let bytes = file(&[&beginning(), &zstd(records)]);
        let found = costs(&bytes);
        let expected = if is_lossy { Some(3) } else { Some(0) };
        assert_eq!(found.code, expected, "{name}: {}", head(&found.stdout));
    }
}

/// The length of the whole records among the first bytes.
fn whole_records(bytes: &[u8], most: usize) -> usize {
    let mut at = 0;
    loop {
        let Some(length) = bytes.get(at + 1..at + 9) else {
            return at;
        };
        let length = u64::from_le_bytes(length.try_into().expect("eight")) as usize;
        if at + 9 + length > most {
            return at;
        }
        at += 9 + length;
    }
}

fn head(text: &str) -> String {
    text.chars().take(1500).collect()
}

/// Lengths and counts that are claimed and not there.
#[test]
fn what_is_claimed_and_not_there_costs_nothing() {
    let mut parts = vec![beginning()];
    for opcode in [SCHEMA, CHANNEL, METADATA, 0x07, 0x08, 0x0a, 0x0b] {
        parts.push(record(opcode, &[0xff; 40]));
    }
    // Chunks of any size that hold nothing of it.
    for compression in ["", "zstd", "lz4"] {
        let head = chunk_head(compression, u64::MAX, 1, u64::MAX);
        parts.push(record(CHUNK, &head));
        let head = chunk_head(compression, 64 << 20, 1, 40);
        parts.push(record(CHUNK, &[head, vec![0; 40]].concat()));
    }
    // A hundred indices of one chunk, as a reader by index would follow them.
    let index = [vec![0; 16], 100_u64.to_le_bytes().to_vec(), vec![0xff; 60]].concat();
    parts.extend((0..100).map(|_| record(0x08, &index)));
    let bytes = file(&[&parts.concat()]);
    assert_eq!(costs(&bytes).code, Some(3));
    let mut cut = bytes.clone();
    cut.extend_from_slice(&[MESSAGE, 0xff, 0xff, 0xff, 0xff, 0xff, 0, 0, 0]);
    costs(&cut);
}

/// Messages that stand for many poses or nest deeply, in each encoding.
#[test]
fn messages_that_are_larger_inside_are_bounded() {
    let formats = [
        // Two bytes are a pose.
        (
            "foxglove.PosesInFrame",
            "protobuf",
            [0x1a, 0].repeat(30 << 20),
        ),
        (
            "foxglove.FrameTransforms",
            "protobuf",
            [0x0a, 0].repeat(100_000),
        ),
        // A count of transforms that are not there.
        (
            "tf2_msgs/msg/TFMessage",
            "cdr",
            [vec![0, 1, 0, 0], vec![0xff; 400]].concat(),
        ),
        (
            "geometry_msgs/msg/PoseStamped",
            "cdr",
            [vec![0, 1, 0, 0], vec![0xff; 400]].concat(),
        ),
        ("foxglove.PoseInFrame", "json", b"[".repeat(10 << 20)),
        (
            "foxglove.PoseInFrame",
            "json",
            br#"{"pose":"#.repeat(20_000),
        ),
        (
            "enact.Keyframe",
            "json",
            br#"{"position_m":["#.repeat(20_000),
        ),
    ];
    for (name, encoding, data) in formats {
        let definitions = [
            attachment("scene.toml", SCENE.as_bytes(), false),
            schema(1, name, b""),
            channel(1, 1, TOPIC, encoding, b""),
        ];
        let messages = message(1, 5, &data);
        let bytes = file(&[&definitions.concat(), &chunk("zstd", &messages)]);
        println!("{name} {encoding}");
        costs(&bytes);
    }
}

/// Frames of many names, of which a list would be as long as the file unpacked.
#[test]
fn names_without_number_are_listed_up_to_a_limit() {
    let mut records = Vec::new();
    for index in 0..200_000_u64 {
        let mut pose = pose(index * 1_000_000);
        // Another frame each time: the name follows its tag and length.
        let at = pose
            .windows(3)
            .position(|w| w == b"map")
            .expect("the frame");
        pose.splice(
            at - 1..at + 3,
            [vec![8], format!("{index:08}").into_bytes()].concat(),
        );
        records.extend_from_slice(&message(1, index, &pose));
    }
    let found = costs(&file(&[&beginning(), &chunk("zstd", &records)]));
    assert!(
        found.stdout.contains("1000 frames"),
        "{}",
        head(&found.stdout)
    );
    assert!(
        found.stdout.contains("and 950 more"),
        "{}",
        head(&found.stdout)
    );
}

/// Stamps as far apart as there are, and log times: frames between them would fill the disk.
#[test]
fn stamps_that_are_far_apart_are_bounded() {
    const FAR: u64 = 9_000_000_000_000_000_000;
    for spans in [
        vec![0, FAR],
        vec![0, 3_600_000_000_000, FAR],
        (0..200).map(|k| k * (FAR / 200)).collect(),
    ] {
        let mut records = beginning();
        for span in spans {
            for k in 0..100_u64 {
                let stamp = span + k * 5_000_000;
                records.extend_from_slice(&message(1, stamp, &pose(stamp)));
            }
        }
        let bytes = file(&[&records]);
        costs(&bytes);
        for command in ["csv", "toml"] {
            let output = format!("OUT.{command}");
            let command = ["sketch", "IN", "-o", &output, "--per-second", "1000"];
            cost("take.mcap", &bytes, &command);
        }
    }
}

/// Scenes in which brackets, tables or keys nest, and robots of many links.
#[test]
fn text_that_nests_is_refused_with_a_place() {
    for scene in [
        format!("a = {}", "[".repeat(100_000)),
        format!("a = {}", "{a=".repeat(100_000)),
        format!("{} = 1", vec!["a"; 100_000].join(".")),
        "[a]\n".repeat(50_000),
        format!("name = \"{}\"", "x".repeat(1 << 20)),
    ] {
        let bytes = file(&[&attachment("scene.toml", scene.as_bytes(), false)]);
        costs(&bytes);
    }
    let chain = |count: usize| {
        let link = |k: usize| {
            format!(
                "<link name=\"l{k}\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>"
            )
        };
        let joint = |k: usize| {
            format!(
                "<joint name=\"j{k}\" type=\"fixed\"><parent link=\"l{}\"/><child link=\"l{k}\"/></joint>",
                k - 1
            )
        };
        let links: String = (0..count).map(link).collect();
        let joints: String = (1..count).map(joint).collect();
        format!("<robot name=\"r\">{links}{joints}</robot>")
    };
    for robot in [
        "<a>".repeat(100_000),
        format!("<robot name=\"r\">{}", "<link>".repeat(50_000)),
        chain(5000),
        format!(
            "<!DOCTYPE r [<!ENTITY a \"{}\">{}]><robot name=\"&a9;\"/>",
            "x".repeat(1000),
            (1..10)
                .map(|k| format!("<!ENTITY a{k} \"{}\">", format!("&a{};", k - 1).repeat(10)))
                .collect::<String>()
        ),
    ] {
        cost(
            "robot.urdf",
            robot.as_bytes(),
            &["scene", "from-urdf", "IN", "-o", "OUT"],
        );
    }
}

/// The data of an attachment are a range of the file: in a chunk there is none.
#[test]
fn an_attachment_in_a_chunk_is_refused() {
    let inside = attachment("scene.toml", SCENE.as_bytes(), false);
    for compression in ["", "zstd", "lz4"] {
        let bytes = file(&[&chunk(compression, &inside)]);
        let found = costs(&bytes);
        assert_eq!(found.code, Some(3));
        assert!(
            found.stdout.contains("does not belong into a chunk"),
            "{}",
            found.stdout
        );
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
    let takes_s = begun.elapsed().as_secs_f64();
    let mut stopped = 0;
    for share in 1..10 {
        let limit = format!("{}us", (takes_s * f64::from(share) * 1e5) as u64);
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
        stopped += usize::from(is_stopped);
    }
    assert!(stopped > 0, "no estimation of {takes_s} s was stopped");
    for wrong in ["0s", "1", "-1s", "soon", "inf"] {
        let folder = tempfile::tempdir().expect("folder");
        let found = run(&["inspect", "x.mcap", "--deadline", wrong], folder.path());
        assert_eq!(found.code, Some(2), "{wrong}");
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
