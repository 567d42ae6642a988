//! Recordings that other programs make: whatever messages carry a motion, on whatever clock, in whatever frame, and in
//! however many files, it is the same motion, or what is wrong is said.
//!
//! The motion is that of a recording of the project, put into other messages by another encoder.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use assert_cmd::cargo::cargo_bin;
use cdr::{CdrLe, Infinite};
use enact::config::scene_from_toml;
use enact::ingest::{Recording, Take};
use enact::motion::{Mark, PoseSample, Scene, TakeEvent};
use mcap::WriteOptions;
use mcap::records::MessageHeader;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde::Serialize;
use tempfile::TempDir;

/// When the recordings are logged \[ns\].
const LOGGED_NS: u64 = 1_767_607_200_000_000_000;

#[derive(Clone, Serialize)]
struct Header(i32, u32, String);
type Seven = ([f64; 3], [f64; 4]);

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn scene_toml() -> String {
    std::fs::read_to_string(root().join("config/pencil_tip.toml")).expect("a scene")
}

fn scene(topic: Option<&str>) -> Scene {
    let toml = scene_toml();
    let named = "[[body]]\nname = \"pencil\"\n";
    assert!(toml.contains(named));
    scene_from_toml(&match topic {
        Some(topic) => toml.replace(named, &format!("{named}topic = \"{topic}\"\n")),
        None => toml,
    })
    .expect("a valid scene")
}

/// The readings and marks that the project's recording has.
struct Motion {
    samples: Vec<PoseSample>,
    marks: Vec<Mark>,
}

fn motion() -> Motion {
    let recording = Recording::open(&root().join("recordings/pencil_tip.mcap")).expect("open");
    split(recording.take(&scene(None)).expect("a take"))
}

fn split(take: Take) -> Motion {
    let mut motion = Motion {
        samples: Vec::new(),
        marks: Vec::new(),
    };
    for event in take.events {
        match event {
            TakeEvent::Pose { sample, .. } => motion.samples.push(sample),
            TakeEvent::Mark(mark) => motion.marks.push(mark),
        }
    }
    motion
}

impl Motion {
    /// Nanoseconds since the first reading.
    fn since_first(&self, stamp_ns: i64) -> u64 {
        (stamp_ns - self.samples[0].stamp.0) as u64
    }
}

/// A channel by its topic, schema and encoding.
#[derive(Clone, Copy)]
struct On(&'static str, &'static str, &'static str);

type Messages = Vec<(On, u64, Vec<u8>)>;

const MARKS: On = On("/marks", "std_msgs/msg/Header", "cdr");
const TF: On = On("/tf", "tf2_msgs/msg/TFMessage", "cdr");
const TF_STATIC: On = On("/tf_static", "tf2_msgs/msg/TFMessage", "cdr");
const POSES: On = On(
    "/tracker/pencil/pose",
    "geometry_msgs/msg/PoseStamped",
    "cdr",
);

fn file(mut messages: Messages, attachments: &[&str]) -> Vec<u8> {
    messages.sort_by_key(|(_, log_time, _)| *log_time);
    let mut bytes = Vec::new();
    let mut writer = WriteOptions::new()
        .profile("ros2")
        .create(std::io::Cursor::new(&mut bytes))
        .expect("writer");
    for text in attachments {
        writer
            .attach(&mcap::Attachment {
                log_time: 0,
                create_time: 0,
                name: "scene.toml".to_owned(),
                media_type: "application/toml".to_owned(),
                data: text.as_bytes().into(),
            })
            .expect("attach");
    }
    for (On(topic, schema, encoding), log_time, data) in messages {
        let schema = writer.add_schema(schema, "ros2msg", b"").expect("schema");
        let channel_id = writer
            .add_channel(schema, topic, encoding, &BTreeMap::new())
            .expect("channel");
        let header = MessageHeader {
            channel_id,
            sequence: 0,
            log_time,
            publish_time: log_time,
        };
        writer
            .write_to_known_channel(&header, &data)
            .expect("message");
    }
    writer.finish().expect("finish");
    drop(writer);
    bytes
}

fn cdr(message: &impl Serialize) -> Vec<u8> {
    cdr::serialize::<_, _, CdrLe>(message, Infinite).expect("encode")
}

fn header(ns: u64, frame: &str) -> Header {
    let (seconds, nanoseconds) = (ns / 1_000_000_000, ns % 1_000_000_000);
    Header(seconds as i32, nanoseconds as u32, frame.to_owned())
}

fn seven(sample: &PoseSample) -> Seven {
    (sample.position_m.into(), sample.quaternion_xyzw)
}

fn isometry(sample: &PoseSample) -> Isometry3<f64> {
    let [x, y, z, w] = sample.quaternion_xyzw;
    Isometry3::from_parts(
        Translation3::from(sample.position_m),
        UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
    )
}

fn seven_of(pose: &Isometry3<f64>) -> Seven {
    let q = pose.rotation;
    (pose.translation.vector.into(), [q.i, q.j, q.k, q.w])
}

/// The marks, stamped on a clock that began so long before the first reading.
fn marks(motion: &Motion, begun_ns: u64) -> Messages {
    let marks = motion.marks.iter().map(|mark| {
        let ns = motion.since_first(mark.stamp.0);
        let name = mark.event.clone().unwrap_or_default();
        (MARKS, LOGGED_NS + ns, cdr(&header(begun_ns + ns, &name)))
    });
    marks.collect()
}

/// The readings as messages that are made of each, with the marks; logged 3 ms late.
fn told(
    motion: &Motion,
    on: On,
    begun_ns: u64,
    message: impl Fn(u64, &PoseSample) -> Vec<u8>,
) -> Messages {
    let mut messages = marks(motion, begun_ns);
    messages.extend(motion.samples.iter().map(|sample| {
        let ns = motion.since_first(sample.stamp.0);
        (
            on,
            LOGGED_NS + 3_000_000 + ns,
            message(begun_ns + ns, sample),
        )
    }));
    messages
}

fn stamped(ns: u64, frame: &str, sample: &PoseSample) -> Vec<u8> {
    cdr(&(header(ns, frame), seven(sample)))
}

fn transform(ns: u64, (parent, child): (&str, &str), pose: Seven) -> Vec<u8> {
    cdr(&vec![(header(ns, parent), child.to_owned(), pose)])
}

fn read(bytes: Vec<u8>, scene: &Scene) -> Take {
    let recording = Recording::from_bytes(Path::new("made.mcap"), bytes).expect("MCAP");
    recording
        .take(scene)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// Fails unless it is the motion, each sign of a quaternion apart, with times since the first reading.
fn assert_is(found: Take, motion: &Motion) {
    let found = split(found);
    assert_eq!(found.samples.len(), motion.samples.len());
    for (at, (own, other)) in found.samples.iter().zip(&motion.samples).enumerate() {
        let [a, b] = [isometry(own), isometry(other)];
        assert!(
            (a.translation.vector - b.translation.vector).norm() < 1e-9,
            "{at}"
        );
        assert!(a.rotation.angle_to(&b.rotation) < 1e-7, "{at}");
        let since = [
            found.since_first(own.stamp.0),
            motion.since_first(other.stamp.0),
        ];
        assert_eq!(since[0], since[1], "{at}");
    }
    let times = |of: &Motion| -> Vec<_> {
        let marks = of.marks.iter();
        marks
            .map(|mark| (mark.event.clone(), of.since_first(mark.stamp.0)))
            .collect()
    };
    assert_eq!(times(&found), times(motion));
}

#[test]
fn a_clock_that_begins_at_zero_is_one_like_others() {
    let motion = motion();
    for begun_ns in [0, 1, LOGGED_NS] {
        let poses = told(&motion, POSES, begun_ns, |ns, of| stamped(ns, "world", of));
        let take = read(file(poses, &[]), &scene(None));
        assert_eq!(take.report.topics[0].stamped_by_log_time, 0);
        assert_is(take, &motion);
    }
}

#[test]
fn without_stamps_messages_are_when_they_were_logged() {
    let motion = motion();
    // No message has a stamp: marks were logged at once, poses 3 ms late.
    let mut messages = told(&motion, POSES, 0, |_, of| stamped(0, "world", of));
    messages.retain(|(on, ..)| on.0 != "/marks");
    let logged = motion.marks.iter().map(|mark| {
        let at = LOGGED_NS + 3_000_000 + motion.since_first(mark.stamp.0);
        (
            MARKS,
            at,
            cdr(&header(0, mark.event.as_deref().unwrap_or_default())),
        )
    });
    messages.extend(logged);
    let take = read(file(messages, &[]), &scene(None));
    assert_eq!(
        take.report.topics[0].stamped_by_log_time,
        motion.samples.len() as u64
    );
    assert_is(take, &motion);
    // Marks alone have none, and the poses' clock is another than that of the log.
    let mut messages = told(&motion, POSES, 5_000_000_000, |ns, of| {
        stamped(ns, "world", of)
    });
    for (on, _, data) in &mut messages {
        if on.0 == "/marks" {
            data[4..12].fill(0);
        }
    }
    let take = read(file(messages, &[]), &scene(None));
    let found = split(take);
    for (own, other) in found.marks.iter().zip(&motion.marks) {
        let since = found.since_first(own.stamp.0) as i64;
        let expected = motion.since_first(other.stamp.0) as i64;
        assert!((since - expected).abs() <= 3_000_000, "{since} {expected}");
    }
}

#[test]
fn messages_of_drivers_are_read_and_found_by_the_name_of_the_body() {
    let motion = motion();
    let name = || "pencil".to_owned();
    let topic = "/tracker/pencil/pose";
    let no_markers = Vec::<(i8, i32, String, [f64; 3])>::new;
    for (on, message) in [
        (
            On(topic, "geometry_msgs/msg/TransformStamped", "cdr"),
            &(|ns: u64, of: &PoseSample| cdr(&(header(ns, "world"), name(), seven(of))))
                as &dyn Fn(u64, &PoseSample) -> Vec<u8>,
        ),
        (
            On(topic, "geometry_msgs/msg/PoseArray", "cdr"),
            &|ns: u64, of: &PoseSample| cdr(&(header(ns, "world"), vec![seven(of)])),
        ),
        (
            On("/rigid_bodies", "mocap4r2_msgs/msg/RigidBodies", "cdr"),
            &|ns: u64, of: &PoseSample| {
                let others = ("hand".to_owned(), no_markers(), seven(of));
                let bodies = vec![others, (name(), no_markers(), seven(of))];
                cdr(&(header(ns, "map"), 7_u32, bodies))
            },
        ),
        (
            On(
                "/poses",
                "motion_capture_tracking_interfaces/msg/NamedPoseArray",
                "cdr",
            ),
            &|ns: u64, of: &PoseSample| cdr(&(header(ns, "world"), vec![(name(), seven(of))])),
        ),
    ] {
        let take = read(
            file(told(&motion, on, LOGGED_NS, message), &[]),
            &scene(None),
        );
        let notes = &take.report.notes;
        let is_said = notes.iter().any(|note| note.contains("is taken from"));
        assert_eq!(is_said, on.0 != topic, "{notes:?}");
        assert_is(take, &motion);
    }
    // A pose alone has no stamp: it is when it was logged.
    let on = On(topic, "geometry_msgs/msg/Pose", "cdr");
    let found = split(read(
        file(
            told(&motion, on, LOGGED_NS, |_: u64, of: &PoseSample| {
                cdr(&seven(of))
            }),
            &[],
        ),
        &scene(None),
    ));
    assert_eq!(found.samples.len(), motion.samples.len());
    assert_eq!(found.samples[9].position_m, motion.samples[9].position_m);
}

#[test]
fn a_topic_that_is_not_there_is_refused_with_those_that_are() {
    let motion = motion();
    let message =
        |ns, of: &PoseSample| cdr(&(header(ns, "world"), vec![("stick".to_owned(), seven(of))]));
    let on = On(
        "/poses",
        "motion_capture_tracking_interfaces/msg/NamedPoseArray",
        "cdr",
    );
    let bytes = file(told(&motion, on, LOGGED_NS, message), &[]);
    let recording = Recording::from_bytes(Path::new("made.mcap"), bytes).expect("MCAP");
    let error = recording
        .take(&scene(None))
        .expect_err("another name")
        .to_string();
    assert!(
        error.contains("expected topic = \"/poses#stick\""),
        "{error}"
    );
    let take = recording
        .take(&scene(Some("/poses#stick")))
        .expect("as it says");
    assert_is(take, &motion);
}

#[test]
fn poses_in_a_frame_that_stands_in_another_are_read_in_that() {
    let motion = motion();
    let world_from_table = Isometry3::from_parts(
        Translation3::new(1.0, 0.5, 0.1),
        UnitQuaternion::from_euler_angles(0.2, -0.3, 1.9),
    );
    let tf = |ns: u64, of: &PoseSample| {
        let table_from_pencil = world_from_table.inverse() * isometry(of);
        transform(ns, ("table", "pencil"), seven_of(&table_from_pencil))
    };
    let fixed = |at: u64, frames, pose: &Isometry3<f64>| {
        (
            TF_STATIC,
            LOGGED_NS + at,
            transform(LOGGED_NS, frames, seven_of(pose)),
        )
    };
    // In two steps, of which the first is only known when all is over.
    let half = Isometry3::translation(0.3, 0.0, 0.0);
    let mut messages = told(&motion, TF, LOGGED_NS, tf);
    messages.push(fixed(
        0,
        ("/room", "table"),
        &(half.inverse() * world_from_table),
    ));
    messages.push(fixed(9_000_000_000, ("world", "room"), &half));
    let take = read(file(messages.clone(), &[]), &scene(Some("/tf#pencil")));
    let notes = take.report.notes.join("; ");
    assert!(
        notes.contains("poses in frame table are read in world"),
        "{notes}"
    );
    assert_eq!(take.report.frame_ids.iter().collect::<Vec<_>>(), ["world"]);
    assert_is(take, &motion);
    // Where the table moves, that is said, and poses are as they were sent.
    let moved = Isometry3::translation(0.0, 0.0, 0.2) * world_from_table;
    messages.push(fixed(9, ("room", "table"), &moved));
    let take = read(file(messages, &[]), &scene(Some("/tf#pencil")));
    let notes = take.report.notes.join("; ");
    assert!(notes.contains("itself moves in room"), "{notes}");
}

#[test]
fn two_publishers_are_told_apart_or_said() {
    let motion = motion();
    let second = |frame: &str, place: &dyn Fn(&PoseSample) -> PoseSample| -> Messages {
        let mut messages = told(&motion, POSES, LOGGED_NS, |ns, of| stamped(ns, "world", of));
        messages.extend(motion.samples.iter().map(|of| {
            let ns = motion.since_first(of.stamp.0) + 2_000_000;
            let message = stamped(LOGGED_NS + ns, frame, &place(of));
            (POSES, LOGGED_NS + 3_000_000 + ns, message)
        }));
        messages
    };
    let still = |of: &PoseSample| PoseSample {
        position_m: Vector3::new(1.0, 1.0, 1.0),
        quaternion_xyzw: [0.0, 0.0, 0.0, 1.0],
        ..*of
    };
    let beside = |of: &PoseSample| PoseSample {
        position_m: of.position_m + Vector3::new(0.5, 0.5, 0.5),
        ..*of
    };
    // In a frame of its own, and still: the other moves.
    let take = read(file(second("world2", &still), &[]), &scene(None));
    let notes = take.report.notes.join("; ");
    assert!(
        notes.contains("given in 2 frames (world, world2)"),
        "{notes}"
    );
    assert_is(take, &motion);
    // In a frame of its own, and moving: who knows which.
    let bytes = file(second("world2", &beside), &[]);
    let recording = Recording::from_bytes(Path::new("made.mcap"), bytes).expect("MCAP");
    let error = recording
        .take(&scene(None))
        .expect_err("two frames")
        .to_string();
    let topic = "/tracker/pencil/pose@world";
    assert!(error.contains(&format!("topic = {topic:?}")), "{error}");
    assert_is(
        recording.take(&scene(Some(topic))).expect("as it says"),
        &motion,
    );
    let error = recording.take(&scene(Some("/tracker/pencil/pose@moon")));
    let error = error.expect_err("no such frame").to_string();
    assert!(error.contains("never in frame \"moon\""), "{error}");
    // In one frame.
    for place in [&still as &dyn Fn(&PoseSample) -> PoseSample, &beside] {
        let take = read(file(second("world", place), &[]), &scene(None));
        let mixed = take.report.mixed.join("; ");
        assert!(
            mixed.contains("two publishers seem to share the topic"),
            "{mixed}"
        );
        assert!(take.report.is_lossy());
    }
}

#[test]
fn a_frame_of_a_camera_is_said_unless_the_scene_knows() {
    let motion = motion();
    for (frame, said) in [
        ("camera_optical_frame", "gravity is along +y"),
        ("cam0", "by its name a camera's"),
        ("world", ""),
    ] {
        let poses = || told(&motion, POSES, LOGGED_NS, |ns, of| stamped(ns, frame, of));
        let notes = read(file(poses(), &[]), &scene(None))
            .report
            .notes
            .join("; ");
        assert_eq!(notes.contains("camera"), !said.is_empty(), "{notes}");
        assert!(notes.contains(said), "{notes}");
        let toml = format!("gravity_m_s2 = [0, 9.80665, 0]\n{}", scene_toml());
        let knows = scene_from_toml(&toml).expect("a valid scene");
        let notes = read(file(poses(), &[]), &knows).report.notes.join("; ");
        assert_eq!(notes, "");
    }
}

/// A folder in which commands run.
struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        let bench = Self(TempDir::new().expect("a folder"));
        std::fs::write(bench.path("scene.toml"), scene_toml()).expect("write");
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn enact(&self, words: &[&str]) -> (Option<i32>, String) {
        let mut command = Command::new(cargo_bin("enact"));
        let Output {
            status,
            stdout,
            stderr,
        } = command
            .args(words)
            .current_dir(self.0.path())
            .output()
            .expect("it runs");
        let said = [stdout, stderr].concat();
        (status.code(), String::from_utf8(said).expect("UTF-8"))
    }
}

/// The recording in two files, one after the other, and its readings.
fn halves() -> (Motion, [Vec<u8>; 2]) {
    let motion = motion();
    let whole = told(&motion, POSES, LOGGED_NS, |ns, of| stamped(ns, "world", of));
    let middle = LOGGED_NS + motion.since_first(motion.samples[140].stamp.0);
    let (first, second): (Messages, Messages) =
        whole.into_iter().partition(|(_, at, _)| *at < middle);
    let halves = [file(first, &[]), file(second, &[])];
    (motion, halves)
}

#[test]
fn parts_of_a_bag_are_put_together_however_they_are_named() {
    let (motion, halves) = halves();
    let bench = Bench::new();
    std::fs::create_dir(bench.path("bag")).expect("a folder");
    for (name, half) in ["bag_0.mcap", "bag_1.mcap"].iter().zip(&halves) {
        std::fs::write(bench.path("bag").join(name), half).expect("write");
    }
    for inputs in [
        &["bag"][..],
        &["bag/bag_0.mcap", "bag/bag_1.mcap"],
        &["bag/bag_1.mcap", "bag/bag_0.mcap"],
    ] {
        let words = [
            &["import"],
            inputs,
            &["--scene", "scene.toml", "-o", "whole.mcap"],
        ]
        .concat();
        let (code, said) = bench.enact(&words);
        assert_eq!(code, Some(0), "{said}");
        let bytes = std::fs::read(bench.path("whole.mcap")).expect("read");
        assert_is(read(bytes, &scene(None)), &motion);
        std::fs::remove_file(bench.path("whole.mcap")).expect("remove");
    }
    // Other commands that take one recording say how; those of several take each of its files.
    let (code, said) = bench.enact(&["replay", "bag", "-o", "x.mcap"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("`enact import bag -o take.mcap`"), "{said}");
    let (_, said) = bench.enact(&["inspect", "bag"]);
    assert_eq!(said.matches(" messages, ").count(), 2, "{said}");
}

#[test]
fn what_is_no_one_bag_is_refused_or_said() {
    let (motion, [first, second]) = halves();
    let bench = Bench::new();
    std::fs::write(bench.path("a.mcap"), &first).expect("write");
    std::fs::write(bench.path("b.mcap"), &first).expect("write");
    std::fs::write(bench.path("c.mcap"), &second).expect("write");
    let (code, said) = bench.enact(&["import", "a.mcap", "b.mcap", "-o", "x.mcap"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("have the same bytes"), "{said}");
    // A whole, and a part of it: no message is there twice.
    let whole = told(&motion, POSES, LOGGED_NS, |ns, of| stamped(ns, "world", of));
    std::fs::write(bench.path("whole.mcap"), file(whole, &[])).expect("write");
    let words = [
        "import",
        "a.mcap",
        "whole.mcap",
        "--scene",
        "scene.toml",
        "-o",
        "x.mcap",
    ];
    let (code, said) = bench.enact(&words);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("messages are in several of them"), "{said}");
    let bytes = std::fs::read(bench.path("x.mcap")).expect("read");
    assert_is(read(bytes, &scene(None)), &motion);
    // Of another day.
    let late = told(&motion, POSES, LOGGED_NS, |ns, of| stamped(ns, "world", of));
    let late = late
        .into_iter()
        .map(|(on, at, data)| (on, at + 3_600_000_000_000, data));
    std::fs::write(bench.path("late.mcap"), file(late.collect(), &[])).expect("write");
    let (code, said) = bench.enact(&["import", "a.mcap", "late.mcap", "-o", "y.mcap"]);
    assert_eq!(code, Some(3), "{said}");
    assert!(said.contains("are both of one bag?"), "{said}");
    // A folder without any.
    std::fs::create_dir(bench.path("empty")).expect("a folder");
    std::fs::create_dir(bench.path("sqlite")).expect("a folder");
    std::fs::write(bench.path("sqlite/sqlite_0.db3"), "SQLite format 3\0").expect("write");
    for (folder, expected) in [
        ("empty", "is a folder without recordings"),
        (
            "sqlite",
            "rosbags-convert --src sqlite --dst sqlite_mcap --dst-storage mcap",
        ),
    ] {
        let (code, said) = bench.enact(&["import", folder, "-o", "z.mcap"]);
        assert_eq!(code, Some(1), "{said}");
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn two_scenes_that_differ_are_refused_until_one_is_named() {
    let motion = motion();
    let other = format!("gravity_m_s2 = [0, 0, -5]\n{}", scene_toml());
    let poses = || told(&motion, POSES, LOGGED_NS, |ns, of| stamped(ns, "world", of));
    let bench = Bench::new();
    let both = file(poses(), &[&scene_toml(), &other]);
    std::fs::write(bench.path("both.mcap"), both).expect("write");
    let twice = file(poses(), &[&scene_toml(), &scene_toml()]);
    std::fs::write(bench.path("twice.mcap"), twice).expect("write");
    let (code, said) = bench.enact(&["replay", "both.mcap", "-o", "x.mcap"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("2 attachments are named scene.toml"),
        "{said}"
    );
    assert!(said.contains("--scene FILE"), "{said}");
    let (_, said) = bench.enact(&["inspect", "both.mcap"]);
    assert!(
        said.contains("2 attachments are named scene.toml"),
        "{said}"
    );
    let (code, said) = bench.enact(&[
        "import",
        "both.mcap",
        "--scene",
        "scene.toml",
        "-o",
        "one.mcap",
    ]);
    assert_eq!(code, Some(0), "{said}");
    for recording in ["one.mcap", "twice.mcap"] {
        let (code, said) = bench.enact(&["replay", recording, "-o", "y.mcap"]);
        assert_eq!(code, Some(0), "{recording}: {said}");
    }
}

#[test]
fn norms_that_are_off_are_normalised_and_said() {
    let motion = motion();
    let bench = Bench::new();
    let scaled = |by: f64| {
        told(&motion, POSES, LOGGED_NS, move |ns, of| {
            let quaternion_xyzw = of.quaternion_xyzw.map(|part| by * part);
            let sample = PoseSample {
                quaternion_xyzw,
                ..*of
            };
            stamped(ns, "world", &sample)
        })
    };
    std::fs::write(bench.path("off.mcap"), file(scaled(1.02), &[])).expect("write");
    let (code, said) = bench.enact(&[
        "replay",
        "off.mcap",
        "--scene",
        "scene.toml",
        "-o",
        "x.mcap",
    ]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("in all 1.020 to 1.020"), "{said}");
    std::fs::write(bench.path("half.mcap"), file(scaled(0.5), &[])).expect("write");
    let (code, said) = bench.enact(&[
        "replay",
        "half.mcap",
        "--scene",
        "scene.toml",
        "-o",
        "x.mcap",
    ]);
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("with a quaternion whose norm is off 1 by more than a tenth"),
        "{said}"
    );
}
