//! Outputs read back: what came in is there unchanged, what was added is right and alone.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::PathBuf;

use mcap::records::MessageHeader;
use mcap::{Attachment, WriteOptions};
use tempfile::TempDir;

#[path = "../../../tests/support/skip.rs"]
mod skip;

use self::skip::skip;
use super::*;
use crate::fixture::{FIRST_NS, SCENE_TOML, counts, estimate, scene, sketch};
use crate::motion::{
    Against, LinkIndex, LinkSpread, Mark, Penetration, Settled, Spread, TrackIndex, Verification,
};
use crate::sampling::SamplingError;
use crate::settle::settle;
use crate::verify::verify;
use crate::wire::{FramedPose, PoseFormat};
use crate::write::RecordingWriter;

/// A message with its topic, for comparison.
type Plain = (String, u32, u64, u64, Vec<u8>);

fn messages(container: &Container, is_wanted: impl Fn(bool) -> bool) -> Vec<Plain> {
    let mut found = Vec::new();
    let mut walk = container.walk();
    while let Some(message) = walk.next_message() {
        let channel = &container.channels()[&message.channel_id];
        if is_wanted(topics::is_ours(&channel.metadata)) {
            found.push((
                channel.topic.clone(),
                message.sequence,
                message.log_time,
                message.publish_time,
                message.data.to_vec(),
            ));
        }
    }
    found
}

fn read(path: &Path) -> Container {
    Container::new(fs::read(path).expect("read")).expect("MCAP")
}

/// A recording of the sketch, logged 3 ms late.
fn recording(directory: &TempDir) -> PathBuf {
    let path = directory.path().join("in.mcap");
    let mut recording = RecordingWriter::create(&path).expect("create");
    recording
        .attach("scene.toml", "application/toml", SCENE_TOML.as_bytes())
        .expect("attach");
    for sample in &sketch().tracks[TrackIndex(0)].samples {
        let log_time = Stamp(sample.stamp.0 + 3_000_000);
        let pose = crate::math::Pose::from_parts(
            sample.seen.position_m().unwrap().into(),
            sample.seen.orientation().unwrap(),
        );
        let sample = PoseSample::from_pose(sample.stamp, &pose);
        recording
            .pose("/tracker/pencil/pose", "map", log_time, &sample)
            .expect("pose");
    }
    let mark = Mark {
        stamp: Stamp(FIRST_NS + 1_900_000_000),
        event: None,
    };
    recording
        .mark("/marks", Stamp(mark.stamp.0 + 3_000_000), &mark)
        .expect("mark");
    recording.finish().expect("finish");
    path
}

fn made_from() -> Provenance {
    Provenance {
        program: "enact 1".to_owned(),
        command: "enact replay in.mcap".to_owned(),
        recording: "in.mcap".to_owned(),
        recording_sha256: "00".repeat(32),
        scene_sha256: "11".repeat(32),
        ended_after_s: None,
    }
}

/// Writes the estimate of the sample scene beside `input`; returns the file's name.
fn written(input: &Path, name: &str, scene_toml: &str) -> PathBuf {
    written_with(input, name, scene_toml, None, None)
}

fn written_with(
    input: &Path,
    name: &str,
    scene_toml: &str,
    verification: Option<&Verification>,
    settled: Option<&Settled>,
) -> PathBuf {
    let path = input.with_file_name(name);
    let container = read(input);
    let (scene, sketch, counts, estimate) = (scene(), sketch(), counts(), estimate());
    let result = write_estimate(
        &path,
        &EstimateFile {
            input: &container,
            made_of: &[input],
            of: Reported {
                scene: &scene,
                inferred: &[],
                sketch: &sketch,
                counts: &counts,
                estimate: &estimate,
                verification,
                settled,
                diagnoses: &[],
                seen: &[],
                freed: &[],
                rest: None,
            },
            scene_toml: scene_toml.as_bytes(),
            provenance: Some(&made_from()),
            world_frame: "map",
            log_offset_ns: 3_000_000,
            frame_rate_hz: DEFAULT_FRAME_RATE_HZ,
        },
    );
    result.expect("write");
    path
}

/// Checked and continued as the pipeline would.
fn checked_and_settled(input: &Path, name: &str) -> (PathBuf, Verification, Settled) {
    let (scene, estimate) = (scene(), estimate());
    let verification = verify(&scene, &estimate);
    let settled = settle(&scene, &estimate, 0.5).expect("a motion");
    let path = written_with(input, name, SCENE_TOML, Some(&verification), Some(&settled));
    (path, verification, settled)
}

fn poses(container: &Container, topic: &str) -> Vec<FramedPose> {
    let mut found = Vec::new();
    let mut walk = container.walk();
    while let Some(message) = walk.next_message() {
        let channel = &container.channels()[&message.channel_id];
        if channel.topic == topic {
            let schema = container.schema_of(channel).expect("schema");
            PoseFormat::of(&schema.name, &channel.message_encoding)
                .expect("a pose format")
                .decode(message.data, &mut found)
                .expect("decode");
        }
    }
    found
}

#[test]
fn what_came_in_is_there_unchanged_and_in_order() {
    let directory = tempfile::tempdir().expect("directory");
    let input = recording(&directory);
    let (before, after) = (read(&input), read(&written(&input, "out.mcap", SCENE_TOML)));
    assert_eq!(after.damages().count(), 0);
    assert!(after.is_sorted());
    assert_eq!(messages(&before, |_| true), messages(&after, |ours| !ours));
    for (id, channel) in before.channels() {
        assert_eq!(after.channels().get(id), Some(channel));
    }
    for (id, schema) in before.schemas() {
        assert_eq!(after.schemas().get(id), Some(schema));
    }
    assert_eq!(before.attachments().len(), after.attachments().len());
    let scene = &after.attachments()[0];
    assert_eq!(after.attachment_data(scene), SCENE_TOML.as_bytes());
}

#[test]
fn the_motion_is_on_the_frame_grid_and_exact_at_events() {
    let directory = tempfile::tempdir().expect("directory");
    let container = read(&written(&recording(&directory), "out.mcap", SCENE_TOML));
    let motion = poses(&container, "/estimate/pencil/pose");
    let stamps: Vec<i64> = motion
        .iter()
        .map(|pose| pose.stamp.expect("stamped").0 - FIRST_NS)
        .collect();
    let frames = (0..=114).map(|frame| (f64::from(frame) / 240.0 * 1e9).round() as i64);
    // The bounce, at 0.2 s, is frame 48; the landing, at 0.475 s, is frame 114.
    assert_eq!(stamps, frames.collect::<Vec<_>>());
    for pose in &motion {
        assert_eq!(pose.parent, "map");
        let t = (pose.stamp.expect("stamped").0 - FIRST_NS) as f64 * 1e-9;
        let (epoch, z, vz) = if t <= 0.2 {
            (0.1, 0.35, -1.0)
        } else {
            (0.2, 0.2, 2.0)
        };
        let dt = t - epoch;
        let expected = z + vz * dt - 0.5 * 9.80665 * dt * dt;
        assert!((pose.position_m.z - expected).abs() < 1e-8, "{t}");
        let [x, y, z, w] = pose.quaternion_xyzw;
        assert!((x * x + y * y + z * z + w * w - 1.0).abs() < 1e-12);
    }
    for pair in motion.windows(2) {
        let dot: f64 = (0..4)
            .map(|k| pair[0].quaternion_xyzw[k] * pair[1].quaternion_xyzw[k])
            .sum();
        assert!(dot > 0.0, "signs are continuous");
    }
}

#[test]
fn what_was_simulated_follows_the_estimate_and_is_said_to_be() {
    let directory = tempfile::tempdir().expect("directory");
    let (path, _, settled) = checked_and_settled(&recording(&directory), "out.mcap");
    let container = read(&path);
    let motion = poses(&container, "/estimate/pencil/pose");
    let simulated = &settled.links[LinkIndex(0)].poses;
    // The seam is in both and written once.
    assert_eq!(motion.len(), 115 + simulated.len() - 1);
    for (pose, expected) in motion[114..].iter().zip(simulated) {
        assert_eq!(pose.position_m, expected.translation.vector);
    }
    let stamp_ns = |pose: &FramedPose| pose.stamp.expect("stamped").0;
    for pair in motion[113..].windows(2) {
        let interval_ns = stamp_ns(&pair[1]) - stamp_ns(&pair[0]);
        assert!((interval_ns - 4_166_667).abs() <= 1, "{interval_ns}");
    }
    let all = messages(&container, |ours| ours);
    let report = all.iter().find(|message| message.0 == topics::REPORT);
    let report: serde_json::Value =
        serde_json::from_slice(&report.expect("report").4).expect("JSON");
    assert_eq!(report["settled"]["from_s"], 0.475);
    assert_eq!(report["settled"]["end_s"], settled.end_s());
    let events = all.iter().filter(|message| message.0 == topics::EVENTS);
    assert_eq!(events.count(), 3);
}

#[test]
fn the_performance_is_restamped_and_frames_have_names_of_their_own() {
    let directory = tempfile::tempdir().expect("directory");
    let container = read(&written(&recording(&directory), "out.mcap", SCENE_TOML));
    let sketched = poses(&container, "/sketch/pencil/pose");
    assert_eq!(sketched.len(), 20);
    for (k, pose) in sketched.iter().enumerate() {
        assert_eq!(pose.stamp, Some(Stamp(FIRST_NS + k as i64 * 25_000_000)));
        assert_eq!(pose.position_m.z, 0.3 + 0.01 * k as f64);
    }
    let transforms = poses(&container, topics::TRANSFORMS);
    let of = |child: &str| transforms.iter().filter(|t| t.child == child).count();
    assert_eq!((of("pencil_estimate"), of("pencil_sketch")), (115, 20));
    assert_eq!(transforms.len(), 135);
    // Log times are the stamps' plus the recording's delay.
    let first = messages(&container, |ours| ours)
        .into_iter()
        .find(|(topic, ..)| topic == "/estimate/pencil/pose")
        .expect("a pose");
    assert_eq!(first.2, FIRST_NS as u64 + 3_000_000);
}

#[test]
fn the_report_says_everything_and_obeys_its_schema() {
    let directory = tempfile::tempdir().expect("directory");
    let input = recording(&directory);
    let (_, mut verification, mut settled) = checked_and_settled(&input, "clear.mcap");
    let ends = settled.links[LinkIndex(0)].poses.clone();
    let up = vec!["+z".to_owned(); ends.len()];
    settled.spread = LinkSpread::new(LinkIndex(0), &ends, &up).map(|of| Spread {
        draws: ends.len(),
        at_rest: 1,
        exact: vec!["pencil".to_owned()],
        links: vec![of],
    });
    assert!(settled.spread.is_some());
    // The motion is clear; with an overlap every field is there.
    assert_eq!(verification.touches.len(), 1);
    verification.deepest = Some(Penetration {
        link: LinkIndex(0),
        against: Against::Obstacle(0),
        time_s: 0.3,
        depth_m: 0.002,
        point_m: nalgebra::Vector3::new(0.0, 0.0, -0.095),
    });
    let (checked, settled) = (Some(&verification), Some(&settled));
    let path = written_with(&input, "out.mcap", SCENE_TOML, checked, settled);
    let container = read(&path);
    let all = messages(&container, |ours| ours);
    for (topic, schema) in [
        (topics::REPORT, REPORT_SCHEMA),
        (topics::TIME_MAP, TIME_MAP_SCHEMA),
    ] {
        let found: Vec<_> = all.iter().filter(|message| message.0 == topic).collect();
        assert_eq!(found.len(), 1);
        let value: serde_json::Value = serde_json::from_slice(&found[0].4).expect("JSON");
        let schema: serde_json::Value = serde_json::from_str(schema).expect("schema");
        check_against(&value, &schema, topic);
    }
    let report = all.iter().find(|message| message.0 == topics::REPORT);
    let report: serde_json::Value =
        serde_json::from_slice(&report.expect("report").4).expect("JSON");
    assert_eq!(report["verdict"], "physical");
    assert_eq!(report["arcs"][1]["velocity_m_s"][2], 2.0);
    assert_eq!(report["events"][0]["name"], "bounce");
    let restitution = &report["parameters"]["bounce.restitution"];
    assert_eq!(restitution["bounds"], serde_json::json!([0.0, null]));
    assert_eq!(report["undetermined"][0], "bounce.restitution");
    assert_eq!(report["termination"]["kind"], "converged");
    assert_eq!(report["events"][0]["time_sd_s"], 0.001);
    assert_eq!(report["physical_sd_s"], 0.012);
    assert_eq!(report["time_map"]["bodies"][0]["physical_s"][4], 0.1);
    assert_eq!(report["time_map"]["origin"]["sec"], 1_700_000_000);
    assert_eq!(report["verification"]["deepest"]["against"], "mug floor");
    assert_eq!(report["verification"]["touches"][0]["expected"][0], "tip");
    let said: Provenance = serde_json::from_value(report["provenance"].clone()).expect("it");
    assert_eq!(said, made_from());
}

/// The part of JSON schema that ours use: types, properties, items, maps.
fn check_against(value: &serde_json::Value, schema: &serde_json::Value, place: &str) {
    let kind = match value {
        serde_json::Value::Null => "null",
        serde_json::Value::Bool(_) => "boolean",
        serde_json::Value::Number(_) => "number",
        serde_json::Value::String(_) => "string",
        serde_json::Value::Array(_) => "array",
        serde_json::Value::Object(_) => "object",
    };
    let allowed = match &schema["type"] {
        serde_json::Value::Array(kinds) => kinds.clone(),
        kind => vec![kind.clone()],
    };
    assert!(
        allowed
            .iter()
            .any(|a| a == kind || (a == "integer" && (value.is_i64() || value.is_u64()))),
        "{place}: {kind}, allowed {allowed:?}"
    );
    if let Some(words) = schema["enum"].as_array() {
        assert!(words.contains(value), "{place}: {value}");
    }
    if let (Some(fields), Some(known)) = (value.as_object(), schema["properties"].as_object()) {
        let names: Vec<_> = fields.keys().collect();
        let wanted: Vec<_> = known.keys().collect();
        assert_eq!(names, wanted, "{place}");
        for (name, field) in fields {
            check_against(field, &known[name], &format!("{place}.{name}"));
        }
    }
    for item in value.as_array().into_iter().flatten() {
        check_against(item, &schema["items"], &format!("{place}[]"));
    }
    if let (Some(fields), true) = (
        value.as_object(),
        schema["additionalProperties"].is_object(),
    ) {
        for (name, field) in fields {
            check_against(
                field,
                &schema["additionalProperties"],
                &format!("{place}.{name}"),
            );
        }
    }
}

#[test]
fn an_output_as_input_is_not_doubled() {
    let directory = tempfile::tempdir().expect("directory");
    let once = written(&recording(&directory), "once.mcap", SCENE_TOML);
    let twice = written(&once, "twice.mcap", SCENE_TOML);
    assert_eq!(
        fs::read(&once).expect("once"),
        fs::read(&twice).expect("twice")
    );
}

#[test]
fn another_scene_goes_beside_the_recordings_own() {
    let directory = tempfile::tempdir().expect("directory");
    let other = SCENE_TOML.replace("\"pencil\"\n[timing]", "\"other\"\n[timing]");
    let once = written(&recording(&directory), "once.mcap", &other);
    let twice = written(&once, "twice.mcap", &other);
    for path in [once, twice] {
        let container = read(&path);
        let names: Vec<_> = container
            .attachments()
            .iter()
            .map(|attachment| attachment.name.as_str())
            .collect();
        assert_eq!(names, ["scene.toml", "estimate_scene.toml"]);
        let last = &container.attachments()[1];
        assert_eq!(container.attachment_data(last), other.as_bytes());
    }
}

/// An input as others write it: ids with holes, schemaless channels, a foreign `/tf`,
/// metadata, no order.
fn foreign(directory: &TempDir) -> PathBuf {
    let path = directory.path().join("foreign.mcap");
    let file = fs::File::create(&path).expect("create");
    let mut writer = WriteOptions::new()
        .profile("ros2")
        .create(file)
        .expect("writer");
    writer
        .add_schema_with_id(
            70,
            "tf2_msgs/msg/TFMessage",
            "ros2msg",
            b"TransformStamped[] transforms",
        )
        .expect("schema");
    for (id, schema, topic, encoding) in [(40, 70, "/tf", "cdr"), (3, 0, "/raw", "octets")] {
        let metadata = BTreeMap::from([("made by".to_owned(), "somebody".to_owned())]);
        writer
            .add_channel_with_id(id, schema, topic, encoding, &metadata)
            .expect("channel");
    }
    for (sequence, log_time) in [50u64, 20, 50, 30, 20].into_iter().enumerate() {
        let header = MessageHeader {
            channel_id: if sequence % 2 == 0 { 40 } else { 3 },
            sequence: sequence as u32,
            log_time,
            publish_time: log_time + 1,
        };
        writer
            .write_to_known_channel(&header, &[sequence as u8; 3])
            .expect("message");
    }
    writer
        .attach(&Attachment {
            log_time: 5,
            create_time: 6,
            name: "calibration".to_owned(),
            media_type: "text/plain".to_owned(),
            data: Cow::Borrowed(b"abc"),
        })
        .expect("attachment");
    writer
        .write_metadata(&mcap::records::Metadata {
            name: "site".to_owned(),
            metadata: BTreeMap::from([("room".to_owned(), "2".to_owned())]),
        })
        .expect("metadata");
    writer.finish().expect("finish");
    path
}

#[test]
fn a_foreign_file_keeps_its_topics_and_is_sorted_stably() {
    let directory = tempfile::tempdir().expect("directory");
    let input = foreign(&directory);
    let (before, after) = (read(&input), read(&written(&input, "out.mcap", SCENE_TOML)));
    assert!(!before.is_sorted());
    assert!(after.is_sorted());
    let order: Vec<_> = messages(&after, |ours| !ours)
        .iter()
        .map(|message| (message.1, message.2, message.3))
        .collect();
    assert_eq!(
        order,
        [
            (1, 20, 21),
            (4, 20, 21),
            (3, 30, 31),
            (0, 50, 51),
            (2, 50, 51)
        ]
    );
    assert_eq!(after.channels()[&40], before.channels()[&40]);
    assert_eq!(after.channels()[&3], before.channels()[&3]);
    assert_eq!(after.metadata(), before.metadata());
    let ours: Vec<_> = after
        .channels()
        .values()
        .filter(|channel| topics::is_ours(&channel.metadata))
        .map(|channel| channel.topic.as_str())
        .collect();
    assert!(
        ours.contains(&"/estimate/tf") && !ours.contains(&"/tf"),
        "{ours:?}"
    );
    let names: Vec<_> = after
        .attachments()
        .iter()
        .map(|attachment| (attachment.name.as_str(), attachment.create_time))
        .collect();
    assert_eq!(names, [("calibration", 6), ("scene.toml", 0)]);
}

#[test]
fn a_ros_2_recording_stays_one_and_says_the_same() {
    let directory = tempfile::tempdir().expect("directory");
    let ros = read(&written(&foreign(&directory), "ros.mcap", SCENE_TOML));
    let plain = read(&written(&recording(&directory), "plain.mcap", SCENE_TOML));
    assert_eq!((ros.profile(), plain.profile()), ("ros2", ""));
    let ours = ros.channels().values();
    let ours: Vec<_> = ours.filter(|c| topics::is_ours(&c.metadata)).collect();
    assert_eq!(ours.len(), 7);
    for channel in ours {
        let schema = ros.schema_of(channel).expect("a schema");
        let encodings = (&channel.message_encoding[..], &schema.encoding[..]);
        assert_eq!(encodings, ("cdr", "ros2msg"), "{}", channel.topic);
    }
    for topic in ["/estimate/pencil/pose", "/sketch/pencil/pose"] {
        let (theirs, expected) = (poses(&ros, topic), poses(&plain, topic));
        assert!(expected.len() > 10 && theirs == expected, "{topic}");
    }
    let count = |container: &Container, topic: &str| {
        let mut channels = container.channels().values();
        channels.find(|c| c.topic == topic).map(|c| c.messages)
    };
    for (of_ros, of_plain) in [
        ("/estimate/tf", "/tf"),
        (topics::EVENTS, topics::EVENTS),
        (topics::REPORT, topics::REPORT),
    ] {
        assert_eq!(count(&ros, of_ros), count(&plain, of_plain), "{of_ros}");
    }
    // And so does a copy with marks.
    let (input, output) = (foreign(&directory), directory.path().join("marked.mcap"));
    let mark = Mark {
        stamp: Stamp(40),
        event: Some("bounce".to_owned()),
    };
    let marks = [(mark.stamp, mark)];
    super::super::write_marks(
        &output,
        &read(&input),
        &input,
        "/marks",
        &marks,
        BTreeSet::new(),
    )
    .expect("write");
    let marked = read(&output);
    assert_eq!(
        (marked.profile(), count(&marked, "/marks")),
        ("ros2", Some(1))
    );
    let mut schemas = marked.schemas().values();
    assert!(schemas.all(|schema| schema.encoding == "ros2msg"));
}

#[test]
fn the_input_is_never_overwritten_under_any_of_its_names() {
    let directory = tempfile::tempdir().expect("directory");
    let input = recording(&directory);
    let other = directory.path().join("other.mcap");
    fs::hard_link(&input, &other).expect("link");
    let before = fs::read(&input).expect("read");
    let container = read(&input);
    let (scene, sketch, counts, estimate) = (scene(), sketch(), counts(), estimate());
    let mut file = EstimateFile {
        input: &container,
        made_of: &[&input],
        of: Reported {
            scene: &scene,
            inferred: &[],
            sketch: &sketch,
            counts: &counts,
            estimate: &estimate,
            verification: None,
            settled: None,
            diagnoses: &[],
            seen: &[],
            freed: &[],
            rest: None,
        },
        scene_toml: b"",
        provenance: None,
        world_frame: "map",
        log_offset_ns: 0,
        frame_rate_hz: DEFAULT_FRAME_RATE_HZ,
    };
    for path in [&input, &other] {
        let error = write_estimate(path, &file).expect_err("the input");
        assert!(matches!(error, WriteError::IsInput { .. }), "{error}");
    }
    assert_eq!(fs::read(&input).expect("read"), before);
    // What cannot be written leaves nothing behind.
    let out = directory.path().join("out.mcap");
    file.frame_rate_hz = f64::NAN;
    let error = write_estimate(&out, &file).expect_err("no frame rate");
    let is_rate = |source: &_| matches!(source, SamplingError::FrameRate { .. });
    assert!(
        matches!(&error, WriteError::Sampling { source, .. } if is_rate(source)),
        "{error}"
    );
    file.frame_rate_hz = 240.0;
    let mut endless = estimate.clone();
    endless.arcs[1].end_s = 1e9;
    file.of.estimate = &endless;
    let error = write_estimate(&out, &file).expect_err("thirty years");
    let is_span = |source: &_| matches!(source, SamplingError::Span { .. });
    assert!(
        matches!(&error, WriteError::Sampling { source, .. } if is_span(source)),
        "{error}"
    );
    file.of.estimate = &estimate;
    let nowhere = directory.path().join("none").join("out.mcap");
    let error = write_estimate(&nowhere, &file).expect_err("no directory");
    assert!(matches!(error, WriteError::Io { .. }), "{error}");
    assert_eq!(fs::read_dir(directory.path()).expect("list").count(), 2);
}

#[test]
fn a_real_capture_comes_out_unchanged() {
    let input = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../shared/real/mcap/cub_stabilize_2025_11_13.mcap");
    let Ok(bytes) = fs::read(&input) else {
        let name = "a_real_capture_comes_out_unchanged";
        skip(name, &format!("no {}", input.display()));
        return;
    };
    let directory = tempfile::tempdir().expect("directory");
    let copy = directory.path().join("in.mcap");
    fs::write(&copy, bytes).expect("copy");
    let (before, after) = (read(&copy), read(&written(&copy, "out.mcap", SCENE_TOML)));
    let mut theirs = messages(&before, |_| true);
    theirs.sort_by_key(|message| message.2);
    assert_eq!(theirs.len() as u64, before.message_count());
    assert!(theirs == messages(&after, |ours| !ours));
    assert_eq!(before.metadata(), after.metadata());
}
