//! The reader against bytes that nobody meant: it neither panics nor allocates what a file
//! claims, and whatever it hands out of a damaged file is what was written, or the damage is
//! reported.

use std::path::Path;

use crate::skip::skip;
use enact::motion::{Mark, PoseSample, Stamp};
use enact::wire::container::{Container, Damage};
use enact::wire::decode::{FramedPose, MarkFormat, PoseFormat};
use enact::write::RecordingWriter;
use nalgebra::Vector3;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";

/// Everything that can be read: poses and marks with their log times, attachments.
#[derive(Debug, Default, PartialEq)]
struct Found {
    poses: Vec<(u64, FramedPose)>,
    marks: Vec<(u64, Option<Stamp>)>,
    attachments: Vec<Vec<u8>>,
    damages: usize,
    is_truncated: bool,
}

fn found(bytes: &[u8]) -> Option<Found> {
    let container = Container::new(bytes.to_vec()).ok()?;
    let mut found = Found {
        damages: container.damages().count(),
        is_truncated: container.damages().is_truncated(),
        ..Found::default()
    };
    let mut walk = container.walk();
    let mut poses = Vec::new();
    let mut walked = 0;
    while let Some(message) = walk.next_message() {
        walked += 1;
        assert!(walked < 1_000_000, "the walk has no end");
        let Some(channel) = container.channels().get(&message.channel_id) else {
            continue;
        };
        let name = container
            .schema_of(channel)
            .map_or("", |schema| schema.name.as_str());
        if let Some(format) = PoseFormat::of(name, &channel.message_encoding) {
            poses.clear();
            if format.decode(message.data, &mut poses).is_ok() {
                let stamped = poses.drain(..).map(|pose| (message.log_time, pose));
                found.poses.extend(stamped);
            }
        }
        if let Some(format) = MarkFormat::of(name, &channel.message_encoding)
            && let Ok(mark) = format.decode(message.data)
        {
            found.marks.push((message.log_time, mark.stamp));
        }
    }
    for attachment in container.attachments() {
        found
            .attachments
            .push(container.attachment_data(attachment).to_vec());
    }
    Some(found)
}

/// A recording of 40 poses, one mark and a scene, as we write it.
fn recording() -> Vec<u8> {
    let directory = tempfile::tempdir().expect("directory");
    let path = directory.path().join("small.mcap");
    let mut writer = RecordingWriter::create(&path).expect("create");
    writer
        .attach("scene.toml", "application/toml", b"name = \"small\"")
        .expect("attach");
    for k in 0..40 {
        let stamp = Stamp(1_700_000_000_000_000_000 + k * 10_000_000);
        let sample = PoseSample::new(
            stamp,
            Vector3::new(0.1 * k as f64, (k as f64).sin(), 0.3),
            [0.0, 0.6, 0.0, 0.8],
        );
        writer.pose("/pose", "map", stamp, &sample).expect("pose");
        if k == 20 {
            let mark = Mark { stamp, event: None };
            writer.mark("/marks", stamp, &mark).expect("mark");
        }
    }
    writer.finish().expect("finish");
    std::fs::read(&path).expect("read")
}

/// The same in many small chunks, or in none, uncompressed, compressed by lz4.
fn variants() -> Vec<Vec<u8>> {
    let original = recording();
    let container = Container::new(original.clone()).expect("MCAP");
    let mut variants = vec![original];
    for (chunks, compression) in [
        (true, None),
        (true, Some(mcap::Compression::Lz4)),
        (false, None),
    ] {
        let mut bytes = Vec::new();
        let mut writer = mcap::WriteOptions::new()
            .use_chunks(chunks)
            .chunk_size(Some(512))
            .compression(compression)
            .create(std::io::Cursor::new(&mut bytes))
            .expect("writer");
        for (&id, schema) in container.schemas() {
            writer
                .add_schema_with_id(id, &schema.name, &schema.encoding, &schema.data)
                .expect("schema");
        }
        for (&id, channel) in container.channels() {
            writer
                .add_channel_with_id(
                    id,
                    channel.schema_id.unwrap_or(0),
                    &channel.topic,
                    &channel.message_encoding,
                    &channel.metadata,
                )
                .expect("channel");
        }
        let mut walk = container.walk();
        while let Some(message) = walk.next_message() {
            let header = mcap::records::MessageHeader {
                channel_id: message.channel_id,
                sequence: message.sequence,
                log_time: message.log_time,
                publish_time: message.publish_time,
            };
            writer
                .write_to_known_channel(&header, message.data)
                .expect("message");
        }
        writer.finish().expect("finish");
        drop(writer);
        variants.push(bytes);
    }
    variants
}

fn runner(cases: u32) -> TestRunner {
    let config = Config::with_cases(cases);
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]);
    TestRunner::new_with_rng(config, rng)
}

/// Nothing is handed out that was not written, in its order.
fn is_part_of<T: PartialEq>(part: &[T], whole: &[T]) -> bool {
    let mut rest = whole.iter();
    part.iter().all(|item| rest.any(|other| other == item))
}

#[test]
fn a_whole_file_is_read_whole_and_without_complaint() {
    for (index, bytes) in variants().iter().enumerate() {
        let found = found(bytes).expect("MCAP");
        assert_eq!((found.poses.len(), found.marks.len()), (40, 1));
        assert_eq!(found.attachments.len(), usize::from(index == 0));
        assert_eq!(found.damages, 0);
    }
}

#[test]
fn a_file_cut_at_any_byte_gives_a_beginning_and_says_so() {
    for bytes in variants() {
        let whole = found(&bytes).expect("MCAP");
        let mut most = 0;
        for length in 0..bytes.len() {
            let Some(part) = found(&bytes[..length]) else {
                assert!(length <= 8, "{length} bytes");
                continue;
            };
            assert!(part.is_truncated, "{length} bytes");
            assert!(whole.poses.starts_with(&part.poses), "{length} bytes");
            assert!(whole.marks.starts_with(&part.marks), "{length} bytes");
            // More of the file never gives less.
            assert!(part.poses.len() >= most, "{length} bytes");
            most = part.poses.len();
        }
        assert_eq!(most, 40);
    }
}

#[test]
fn every_single_flipped_bit_is_noticed_or_harmless() {
    for (index, bytes) in variants().iter().enumerate() {
        let whole = found(bytes).expect("MCAP");
        for bit in 0..bytes.len() * 8 {
            // A thirteenth of the bits of each file, all of its beginning.
            if bit > 4096 && bit % 13 != index {
                continue;
            }
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let Some(part) = found(&flipped) else {
                assert!(bit / 8 < 8, "bit {bit}");
                continue;
            };
            let is_believed = |damage: &Damage| matches!(damage, Damage::Checksum { .. });
            if part.damages == 0 {
                assert!(part == whole, "variant {index}, bit {bit}");
            } else if index == 3 {
                // Without chunks what is before the damage is read, and what may be wrong is said.
                let container = Container::new(flipped).expect("MCAP");
                let damages = container.damages().first();
                let begins = whole.poses.starts_with(&part.poses);
                assert!(
                    begins || damages.iter().any(is_believed),
                    "bit {bit}: {damages:?}"
                );
            } else {
                // In chunks with checksums not even a reported datum is wrong.
                assert!(is_part_of(&part.poses, &whole.poses), "bit {bit}");
                assert!(is_part_of(&part.marks, &whole.marks), "bit {bit}");
            }
            assert!(
                is_part_of(&part.attachments, &whole.attachments),
                "bit {bit}"
            );
        }
    }
}

#[test]
fn random_damage_never_panics() {
    let variants = variants();
    let strategy = (
        0..variants.len(),
        prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..20),
        any::<prop::sample::Index>(),
        prop::collection::vec(any::<u8>(), 0..40),
    );
    runner(3000)
        .run(&strategy, |(which, edits, at, inserted)| {
            let mut bytes = variants[which].clone();
            for (index, value) in &edits {
                let length = bytes.len();
                bytes[index.index(length)] = *value;
            }
            let at = at.index(bytes.len());
            bytes.splice(at..at, inserted);
            let _ = found(&bytes);
            Ok(())
        })
        .expect("no panic");
}

#[test]
fn random_bytes_never_panic() {
    runner(3000)
        .run(&prop::collection::vec(any::<u8>(), 0..600), |bytes| {
            let _ = found(&bytes);
            let mut file = MAGIC.to_vec();
            file.extend_from_slice(&bytes);
            let _ = found(&file);
            Ok(())
        })
        .expect("no panic");
}

#[test]
fn random_records_never_panic() {
    // Frames that hold together, so that the contents are reached.
    let record = (0u8..=0x10, prop::collection::vec(any::<u8>(), 0..80));
    runner(5000)
        .run(&prop::collection::vec(record, 0..12), |records| {
            let mut inside = Vec::new();
            for (opcode, body) in records {
                inside.extend_from_slice(&framed(opcode, &body));
            }
            let _ = found(&[&MAGIC[..], &inside].concat());
            // The same in a chunk without checksum, whole and with its last record reaching out.
            for cut in [0, inside.len().min(3)] {
                let chunk = chunk(&inside[..inside.len() - cut]);
                let _ = found(&[&MAGIC[..], &chunk, &inside].concat());
            }
            Ok(())
        })
        .expect("no panic");
}

#[test]
fn a_text_that_claims_gigabytes_is_a_damaged_record() {
    let mut body = Vec::new();
    body.extend_from_slice(&u32::MAX.to_le_bytes());
    for opcode in [0x01, 0x0c] {
        let file = [&MAGIC[..], &framed(opcode, &body)].concat();
        let container = Container::new(file).expect("MCAP");
        assert!(matches!(
            container.damages().first(),
            [Damage::Record { at: 8, .. }, Damage::NoEnd]
        ));
    }
}

#[test]
fn a_record_that_reaches_out_of_its_chunk_costs_the_chunk() {
    let record = framed(0x03, &[7; 40]);
    let file = [&MAGIC[..], &chunk(&record[..30]), &record].concat();
    let container = Container::new(file).expect("MCAP");
    assert!(matches!(
        container.damages().first()[0],
        Damage::Chunk { at: 8, .. }
    ));
}

fn framed(opcode: u8, body: &[u8]) -> Vec<u8> {
    let mut record = vec![opcode];
    record.extend_from_slice(&(body.len() as u64).to_le_bytes());
    record.extend_from_slice(body);
    record
}

/// An uncompressed chunk without checksum.
fn chunk(records: &[u8]) -> Vec<u8> {
    let length = (records.len() as u64).to_le_bytes();
    let body = [&[0; 16][..], &length, &[0; 4], &[0; 4], &length, records].concat();
    framed(0x06, &body)
}

#[test]
fn random_messages_never_panic_a_decoder() {
    let formats: Vec<PoseFormat> = [
        ("foxglove.PoseInFrame", "protobuf"),
        ("foxglove.PosesInFrame", "protobuf"),
        ("foxglove.FrameTransforms", "protobuf"),
        ("foxglove.FrameTransform", "json"),
        ("geometry_msgs/msg/PoseStamped", "cdr"),
        ("nav_msgs/msg/Odometry", "cdr"),
        ("tf2_msgs/msg/TFMessage", "cdr"),
    ]
    .into_iter()
    .map(|(name, encoding)| PoseFormat::of(name, encoding).expect("supported"))
    .collect();
    runner(5000)
        .run(&prop::collection::vec(any::<u8>(), 0..300), |mut data| {
            for format in &formats {
                let _ = format.decode(&data, &mut Vec::new());
            }
            if data.len() > 2 {
                data[0] = 0;
                data[1] &= 1;
                for format in &formats {
                    let _ = format.decode(&data, &mut Vec::new());
                }
            }
            Ok(())
        })
        .expect("no panic");
}

#[test]
fn a_damaged_chunk_costs_its_own_messages_only() {
    let bytes = &variants()[1];
    let chunks: Vec<usize> = offsets(bytes, 0x06);
    assert!(chunks.len() > 4, "{} chunks", chunks.len());
    let mut damaged = bytes.clone();
    // Well inside the records of the third chunk.
    damaged[chunks[2] + 200] ^= 0x10;
    let container = Container::new(damaged.clone()).expect("MCAP");
    assert!(matches!(
        container.damages().first()[0],
        Damage::Chunk { at, .. } if at == chunks[2]
    ));
    let (part, whole) = (found(&damaged).expect("MCAP"), found(bytes).expect("MCAP"));
    assert!(is_part_of(&part.poses, &whole.poses));
    assert!(part.poses.len() >= 30, "{} poses left", part.poses.len());
    assert!(!part.is_truncated);
}

fn offsets(bytes: &[u8], wanted: u8) -> Vec<usize> {
    let mut found = Vec::new();
    let mut at = 8;
    while at + 9 <= bytes.len() - 8 {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().expect("eight"));
        if bytes[at] == wanted {
            found.push(at);
        }
        at += 9 + length as usize;
    }
    found
}

/// Real files, which are not part of the project.
fn real(test: &str, name: &str) -> Option<Vec<u8>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../shared/real/mcap")
        .join(name);
    let bytes = std::fs::read(&path).ok();
    if bytes.is_none() {
        skip(test, &format!("no {name} among the real files"));
    }
    bytes
}

#[test]
fn a_real_capture_is_read_completely() {
    let Some(bytes) = real(
        "a_real_capture_is_read_completely",
        "cub_stabilize_2025_11_13.mcap",
    ) else {
        return;
    };
    let container = Container::new(bytes).expect("MCAP");
    assert_eq!(container.damages().count(), 0);
    let mut poses = Vec::new();
    let mut counts = std::collections::BTreeMap::new();
    let mut walk = container.walk();
    while let Some(message) = walk.next_message() {
        let channel = &container.channels()[&message.channel_id];
        let schema = container.schema_of(channel).expect("a schema");
        *counts.entry(schema.name.clone()).or_insert(0) += 1;
        if let Some(format) = PoseFormat::of(&schema.name, &channel.message_encoding) {
            format.decode(message.data, &mut poses).expect("decode");
        }
    }
    assert_eq!(
        counts.get("geometry_msgs/msg/PoseStamped"),
        Some(&19_703),
        "{counts:?}"
    );
    assert_eq!(poses.len(), 19_703);
    let stamps: Vec<_> = poses
        .iter()
        .map(|pose| pose.stamp.expect("a stamp"))
        .collect();
    let span_s = stamps[stamps.len() - 1].seconds_since(stamps[0]);
    assert!((197.0..199.0).contains(&span_s), "{span_s} s");
    for pose in &poses {
        let norm: f64 = pose.quaternion_xyzw.iter().map(|c| c * c).sum();
        assert!((norm - 1.0).abs() < 1e-6 && pose.position_m.norm() < 50.0);
    }
}

#[test]
fn a_real_file_cut_off_in_a_chunk_is_empty_and_said_to_be_cut() {
    let name = "a_real_file_cut_off_in_a_chunk_is_empty_and_said_to_be_cut";
    let Some(bytes) = real(name, "chunk_not_closed.mcap") else {
        return;
    };
    let container = Container::new(bytes).expect("MCAP");
    assert!(container.damages().is_truncated());
    assert_eq!(container.message_count(), 0);
}

/// One bit makes the end of the data out of an index of messages: what follows is read all the same.
#[test]
fn a_damaged_index_ends_no_file() {
    const MESSAGE_INDEX: u8 = 0x07;
    const DATA_END: u8 = 0x0f;
    let mut tried = 0;
    for original in variants() {
        let whole = found(&original).expect("MCAP");
        let mut at = MAGIC.len();
        while original[at] != DATA_END {
            if original[at] == MESSAGE_INDEX {
                let mut bytes = original.clone();
                bytes[at] = DATA_END;
                let left = found(&bytes).expect("MCAP");
                assert_eq!((left.poses.len(), left.marks.len()), (40, 1));
                assert_eq!(left.poses, whole.poses);
                let container = Container::new(bytes).expect("MCAP");
                assert!(container.damages().is_loss());
                tried += 1;
            }
            let length = original[at + 1..at + 9].try_into().expect("eight bytes");
            at += 9 + u64::from_le_bytes(length) as usize;
        }
    }
    assert!(tried > 10, "{tried}");
}

/// Records after damage may be the inside of something else: here of an attachment that holds a
/// recording without chunks, and lost the record that would have led over it.
#[test]
fn after_damage_only_what_has_a_checksum_is_believed() {
    let inner = &variants()[3];
    let outer = &variants()[1];
    let whole = found(outer).expect("MCAP");
    // The outer recording, with the inner one in an attachment before its first chunk.
    let first_chunk = offsets(outer, 0x06)[0];
    let mut body = vec![0; 16];
    for text in ["inner.mcap", "application/octet-stream"] {
        body.extend_from_slice(&(text.len() as u32).to_le_bytes());
        body.extend_from_slice(text.as_bytes());
    }
    body.extend_from_slice(&(inner.len() as u64).to_le_bytes());
    body.extend_from_slice(inner);
    body.extend_from_slice(&crc32fast::hash(&body).to_le_bytes());
    let attachment = framed(0x09, &body);
    let mut file = outer.clone();
    file.splice(first_chunk..first_chunk, attachment.clone());
    let data_end = *offsets(&file, 0x0f).last().expect("the end");
    // No checksum of the data section, which would be another.
    file[data_end + 9..data_end + 13].fill(0);
    let undamaged = found(&file).expect("MCAP");
    assert_eq!((undamaged.damages, undamaged.poses.len()), (0, 40));
    assert!(undamaged.poses == whole.poses);
    // The length, a byte of the content, and both: a record of the inner file follows each.
    let inside = first_chunk + attachment.len() - inner.len() - 4;
    for damaged in [
        vec![first_chunk + 3],
        vec![inside + 40],
        vec![first_chunk + 1, inside + 40],
    ] {
        let mut file = file.clone();
        for at in damaged {
            file[at] ^= 0x15;
        }
        let left = found(&file).expect("MCAP");
        assert!(left.poses == whole.poses, "{} poses", left.poses.len());
        assert!(left.damages > 0);
    }
    // Messages between chunks are believed as long as each record leads to the next.
    let message = |time: u64| {
        let data = [&1_u16.to_le_bytes()[..], &[0; 4], &[0; 8], &[0; 8]].concat();
        let mut record = framed(0x05, &data);
        record[15..23].copy_from_slice(&time.to_le_bytes());
        record
    };
    let chunks = offsets(outer, 0x06);
    let mut file = outer.clone();
    let between = chunks[3];
    file.splice(between..between, [message(7), message(8)].concat());
    let count = |file: &[u8]| {
        let container = Container::new(file.to_vec()).expect("MCAP");
        let mut walk = container.walk();
        let mut messages = 0;
        while let Some(message) = walk.next_message() {
            messages += usize::from(matches!(message.log_time, 7 | 8));
        }
        (messages, container.damages().unread_bytes())
    };
    assert_eq!(count(&file).0, 2);
    // A damaged length before them: they may be anything, and are said not to have been read.
    let mut damaged = file.clone();
    damaged[chunks[2] + 4] ^= 0x40;
    let (messages, unread) = count(&damaged);
    assert_eq!(messages, 0);
    assert!(unread >= 2 * message(7).len(), "{unread}");
}
