//! What is inside of a file: definitions, messages, names and texts without number or end.

use super::{cost, costs};
use crate::raw_mcap::{
    CHANNEL, CHUNK, MESSAGE, METADATA, SCENE, SCHEMA, TOPIC, attachment, beginning, channel, chunk,
    chunk_head, file, message, pose, record, schema, text,
};

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
        ("large", &large, true),
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
