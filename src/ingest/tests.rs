//! Sources agree with one another; every reason why a recording is unusable is reported.

use std::collections::BTreeMap;
use std::path::Path;

use mcap::WriteOptions;
use mcap::records::MessageHeader;
use nalgebra::Vector3;

use super::*;
use crate::config::scene_from_toml;
use crate::motion::{FreeBody, LinkIndex, Mark, PoseSample, Scene, Stamp, TakeEvent, TrackIndex};
use crate::wire::encode::{self, Transform};
use crate::write::RecordingWriter;

const PENCIL: &str = r#"
name = "test"
[timing]
stamps = "physical"
[[body]]
name = "pencil"
topic = "TOPIC"
shape = { kind = "cylinder", length_mm = 190, radius_mm = 3.75 }
mass_g = 6.0
[[event]]
name = "start"
kind = "start"
[[event]]
name = "end"
kind = "end"
"#;

fn scene(topic: &str) -> Scene {
    scene_from_toml(&PENCIL.replace("TOPIC", topic)).expect("a valid scene")
}

fn sample(k: i64) -> PoseSample {
    PoseSample::new(
        Stamp(1_000_000_000 + k * 10_000_000),
        Vector3::new(0.0, 0.1, k as f64),
        [0.0, 0.0, 0.0, 1.0],
    )
}

/// What is put into a file for a test: topic, schema name, message encoding.
#[derive(Clone, Copy)]
struct Track(&'static str, &'static str, &'static str);

fn file(messages: &[(Track, u64, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = WriteOptions::new()
        .create(std::io::Cursor::new(&mut bytes))
        .expect("writer");
    for (Track(topic, schema, encoding), log_time, data) in messages {
        let schema = writer.add_schema(schema, "", b"").expect("schema");
        let channel_id = writer
            .add_channel(schema, topic, encoding, &BTreeMap::new())
            .expect("channel");
        let header = MessageHeader {
            channel_id,
            sequence: 0,
            log_time: *log_time,
            publish_time: *log_time,
        };
        writer
            .write_to_known_channel(&header, data)
            .expect("message");
    }
    writer.finish().expect("finish");
    drop(writer);
    bytes
}

const POSES: Track = Track("/pose", "foxglove.PoseInFrame", "protobuf");
const MARKS: Track = Track("/marks", "foxglove.Event", "protobuf");
const FRAMES: Track = Track("/tf", "foxglove.FrameTransforms", "protobuf");

fn pose(k: i64) -> Vec<u8> {
    encode::pose_in_frame("map", &sample(k)).expect("encode")
}

fn mark(stamp: i64) -> Vec<u8> {
    let mark = Mark {
        stamp: Stamp(stamp),
        event: None,
    };
    encode::event(&mark).expect("encode")
}

fn frames(children: &[&str]) -> Vec<u8> {
    let transforms: Vec<_> = children
        .iter()
        .enumerate()
        .map(|(k, child)| Transform {
            parent: "map",
            child,
            sample: sample(k as i64),
        })
        .collect();
    encode::frame_transforms(&transforms).expect("encode")
}

fn opened(messages: &[(Track, u64, Vec<u8>)]) -> Recording {
    Recording::from_bytes(Path::new("test.mcap"), file(messages)).expect("MCAP")
}

fn drained(source: &mut impl Source) -> Vec<(Stamp, TakeEvent)> {
    let mut events = Vec::new();
    while let Some(event) = source.next().expect("readable") {
        events.push(event);
        assert!(events.len() < 100_000, "it has no end");
    }
    events
}

#[test]
fn recording_and_memory_deliver_the_same() {
    let directory = tempfile::tempdir().expect("directory");
    let path = directory.path().join("take.mcap");
    let mut events = Vec::new();
    let mut writer = RecordingWriter::create(&path).expect("create");
    writer
        .attach("truth.json", "application/json", b"{}")
        .expect("attach");
    writer
        .attach(SCENE_NAME, "application/toml", b"a scene")
        .expect("attach");
    for k in 0..50 {
        let (log_time, sample) = (Stamp(sample(k).stamp.0 + 4_000_000 + k), sample(k));
        writer
            .pose("/pose", "map", log_time, &sample)
            .expect("pose");
        events.push((
            log_time,
            TakeEvent::Pose {
                track: TrackIndex(0),
                stream: 0,
                sample,
            },
        ));
        if k % 20 == 10 {
            let mark = Mark {
                stamp: sample.stamp,
                event: (k == 10).then(|| "start".to_owned()),
            };
            writer.mark("/marks", log_time, &mark).expect("mark");
            events.push((log_time, TakeEvent::Mark(mark)));
        }
    }
    writer.finish().expect("finish");
    let recording = Recording::open(&path).expect("open");
    assert_eq!(recording.scene_toml(), Some(&b"a scene"[..]));
    let mut source = recording.source(&scene("/pose")).expect("source");
    assert_eq!(drained(&mut source), events);
    assert_eq!(drained(&mut MemorySource::new(events.clone())), events);
    let take = recording.take(&scene("/pose")).expect("take");
    let plain: Vec<_> = events.into_iter().map(|(_, event)| event).collect();
    assert_eq!(take.events, plain);
    assert_eq!(&take.report, source.report());
    assert_eq!(take.report.log_offset_ns, Some(4_000_000));
    assert_eq!(take.report.frame_ids.iter().collect::<Vec<_>>(), ["map"]);
    let counts: Vec<_> = take
        .report
        .topics
        .iter()
        .map(|t| (t.messages, t.events))
        .collect();
    assert_eq!(counts, [(50, 50), (2, 2)]);
    assert!(!take.report.is_lossy());
}

#[test]
fn undecodable_messages_and_missing_stamps_are_counted() {
    let unstamped = encode::pose_in_frame(
        "map",
        &PoseSample {
            stamp: Stamp(0),
            ..sample(0)
        },
    )
    .expect("encode");
    let take = opened(&[
        (POSES, 10, pose(1)),
        (POSES, 20, b"\xff\xff".to_vec()),
        (POSES, 30, unstamped),
        (POSES, 40, Vec::new()),
        (MARKS, 50, mark(0)),
    ])
    .take(&scene("/pose"))
    .expect("take");
    let stamps: Vec<_> = take
        .events
        .iter()
        .map(|event| match event {
            TakeEvent::Pose { sample, .. } => sample.stamp.0,
            TakeEvent::Mark(mark) => mark.stamp.0,
        })
        .collect();
    // The first was stamped 1.00999999 s after it was logged: so are the others.
    assert_eq!(stamps, [1_010_000_000, 1_010_000_020, 1_010_000_040]);
    let [poses, marks] = &take.report.topics[..] else {
        panic!("{:?}", take.report.topics);
    };
    assert_eq!((poses.messages, poses.events, poses.undecodable), (4, 2, 2));
    assert_eq!(
        (poses.stamped_by_log_time, marks.stamped_by_log_time),
        (1, 1)
    );
    let first = poses.first_error.as_ref().expect("an error").to_string();
    assert!(first.starts_with("not a protobuf message"), "{first}");
    assert!(take.report.is_lossy());
}

#[test]
fn a_child_of_many_is_picked_by_name_and_several_bodies_share_a_topic() {
    let messages = [
        (FRAMES, 1, frames(&["hat", "pencil"])),
        (FRAMES, 2, frames(&["pencil"])),
        (MARKS, 3, mark(5)),
    ];
    let recording = opened(&messages);
    let mut scene = scene("/tf#pencil");
    let pencil = scene.links[LinkIndex(0)].clone();
    scene.add(FreeBody {
        name: "hat".to_owned(),
        topic: "/tf#hat".to_owned(),
        body: pencil.body,
        shape: pencil.shape,
        body_from_tracker: scene.tracks[TrackIndex(0)].link_from_tracker,
        features: pencil.features,
    });
    let take = recording.take(&scene).expect("take");
    let heights_m: Vec<_> = take
        .events
        .iter()
        .filter_map(|event| match event {
            TakeEvent::Pose { track, sample, .. } => Some((track.0, sample.position_m.z)),
            TakeEvent::Mark(_) => None,
        })
        .collect();
    assert_eq!(heights_m, [(0, 1.0), (1, 0.0), (0, 0.0)]);
}

#[test]
fn several_children_without_a_name_are_an_error_even_in_separate_messages() {
    for messages in [
        [(FRAMES, 1, frames(&["hat", "pencil"])), (MARKS, 3, mark(5))],
        [(FRAMES, 1, frames(&["pencil"])), (MARKS, 3, mark(5))],
    ] {
        let mut messages = messages.to_vec();
        messages.push((FRAMES, 4, frames(&["hat"])));
        let error = opened(&messages)
            .take(&scene("/tf"))
            .expect_err("ambiguous");
        assert_eq!(
            error.to_string(),
            "test.mcap: topic /tf carries hat, pencil; name one of them in the scene, as in \
             \"/tf#hat\""
        );
    }
}

#[test]
fn a_child_that_never_comes_is_an_error() {
    let recording = opened(&[(FRAMES, 1, frames(&["hat"])), (MARKS, 3, mark(5))]);
    let error = recording.take(&scene("/tf#pen")).expect_err("absent");
    assert_eq!(
        error.to_string(),
        "test.mcap: topic /tf#pen never carries \"pen\", only hat"
    );
}

#[test]
fn what_is_no_recording_is_said_to_be_none() {
    let directory = tempfile::tempdir().expect("directory");
    let path = directory.path().join("none.mcap");
    let text = |path: &Path| Recording::open(path).expect_err("no recording").to_string();
    assert!(
        text(&path).contains("none.mcap: cannot read: "),
        "{}",
        text(&path)
    );
    assert!(text(directory.path()).contains("is a folder, expected a recording"));
    std::fs::write(&path, b"").expect("write");
    assert!(text(&path).ends_with("none.mcap: the file is empty"));
    std::fs::write(&path, b"ply\nformat ascii 1.0\n").expect("write");
    assert!(text(&path).contains("none.mcap: not an MCAP file"));
}

#[test]
fn absent_topics_are_named_beside_those_that_are_there() {
    let recording = opened(&[(POSES, 1, pose(1)), (FRAMES, 1, frames(&["a"]))]);
    let error = recording
        .take(&scene("/tracker/pencil/pose"))
        .expect_err("absent");
    assert_eq!(
        error.to_string(),
        "test.mcap: no topic /tracker/pencil/pose, which body \"pencil\" of the scene wants; \
         the recording has /pose, /tf; expected one with poses as its topic: /pose, /tf#a"
    );
    // A recording may have no marks at all, but not on another topic than the scene's.
    let take = recording.take(&scene("/pose")).expect("no marks");
    assert_eq!(take.events.len(), 1);
    let elsewhere = Track("/notes", "foxglove.Event", "protobuf");
    let error = opened(&[(POSES, 1, pose(1)), (elsewhere, 1, vec![])])
        .take(&scene("/pose"))
        .expect_err("marks elsewhere");
    assert_eq!(
        error.to_string(),
        "test.mcap: no marks: topic /marks is not in the recording, which has /notes, /pose"
    );
    let error = opened(&[]).take(&scene("/pose")).expect_err("absent");
    assert!(
        error.to_string().ends_with("the recording has none"),
        "{error}"
    );
}

#[test]
fn unsupported_schemas_are_named_beside_the_supported() {
    let twist = Track("/pose", "geometry_msgs/msg/TwistStamped", "cdr");
    let recording = opened(&[(twist, 1, vec![]), (MARKS, 1, mark(5))]);
    let error = recording.take(&scene("/pose")).expect_err("unsupported");
    let text = error.to_string();
    assert!(
        text.starts_with(
            "test.mcap: topic /pose carries geometry_msgs/msg/TwistStamped (cdr); supported are \
             foxglove.PoseInFrame"
        ),
        "{text}"
    );
    let recording = opened(&[
        (POSES, 1, pose(1)),
        (Track("/marks", "x", "json"), 1, vec![]),
    ]);
    let error = recording.take(&scene("/pose")).expect_err("unsupported");
    assert!(
        error.to_string().contains("topic /marks carries x (json)"),
        "{error}"
    );
}
