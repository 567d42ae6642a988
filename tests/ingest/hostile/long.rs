//! Files that are valid, and as long as they may be: what the work on their samples costs without a time limit.

use std::path::Path;

use enact::ingest::Recording;
use enact::motion::{Mark, PoseSample, Stamp};
use enact::write::RecordingWriter;
use nalgebra::{UnitQuaternion, Vector3};

use super::{
    EXPORT, GRAVITY, IMPORT, INSPECT, MARK, PIVOT, PREDICT, PROCESS, REPORT, REST, SKETCH, cost,
};
use crate::raw_mcap::{MAGIC, SCENE, TOPIC, chunk, message, pose, record};

/// As many samples as are read of any file.
const SAMPLES: u32 = 100_000;

const OTHER: &str = "/other";

/// Where the tracker is, in metres and as a rotation vector, after so many seconds.
type Motion = fn(f64) -> ([f64; 3], [f64; 3]);

/// Motions that make work: what wanders for as long as it is looked at, what falls all the time, what bounces at every
/// third sample, what stands still.
const MOTIONS: [(&str, Motion); 4] = [
    ("wanders", |t| {
        let swing = [(0.03 * t).sin(), (0.05 * t).cos(), 0.3];
        ([0.1 * swing[0], 0.1 * swing[1], 0.4], swing)
    }),
    ("falls", |t| {
        ([t, 0.0, 3.0 * t - 4.905 * t * t], [0.1 * t, 0.0, 0.0])
    }),
    ("bounces", |t| {
        let phase = (t * 333.0).fract();
        ([0.0, 0.0, phase * (1.0 - phase)], [phase, 0.0, 0.0])
    }),
    ("stands", |_| ([0.0, 0.0, 0.4], [0.0; 3])),
];

/// The file, with a mark near each end.
fn recording(motion: Motion) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("take.mcap");
    let mut writer = RecordingWriter::create(&path).expect("create");
    let scene = SCENE.as_bytes();
    writer
        .attach("scene.toml", "application/toml", scene)
        .expect("attach");
    let stamp = |k: u32| Stamp(1_000_000_000 + i64::from(k) * 1_000_000);
    for k in 0..SAMPLES {
        let (position_m, turn) = motion(f64::from(k) * 1e-3);
        let turn = UnitQuaternion::from_scaled_axis(Vector3::from(turn)).coords;
        let sample = PoseSample::new(stamp(k), position_m.into(), turn.into());
        // One of a hundred of another tracker, for the calibration of clocks.
        for topic in [TOPIC, OTHER].iter().take(1 + usize::from(k % 100 == 0)) {
            writer
                .pose(topic, "map", sample.stamp, &sample)
                .expect("write");
        }
    }
    for k in [SAMPLES / 3, SAMPLES - 10] {
        let mark = Mark {
            stamp: stamp(k),
            event: None,
        };
        writer.mark("/marks", mark.stamp, &mark).expect("write");
    }
    writer.finish().expect("finish");
    std::fs::read(&path).expect("written")
}

#[test]
fn as_many_samples_as_there_may_be_are_worked_through() {
    let with = |command: &[&'static str], more: &[&'static str]| [command, more].concat();
    // What takes as long whatever the motion is, and what does not.
    let plain = [
        with(INSPECT, &[]),
        with(&["mark", "IN", "--add", "0.5", "-o", "OUT"], &[]),
        with(SKETCH, &[]),
        with(IMPORT, &["--start", "10"]),
        with(
            &["calibrate", "plane", "IN", "--point", "0,0,-100", "-o"],
            &[
                "OUT.toml", "--topic", TOPIC, "--at", "10", "--at", "50", "--at", "90",
            ],
        ),
        with(
            &["calibrate", "clock", "IN", "-o", "OUT.toml"],
            &["--topics", TOPIC, OTHER],
        ),
    ];
    let commands = [
        with(PROCESS, &[]),
        with(PREDICT, &[]),
        with(MARK, &[]),
        with(SKETCH, &["--estimated", "--deadline", "10s"]),
        with(PIVOT, &["--topic", TOPIC]),
        with(GRAVITY, &["--topic", TOPIC]),
        with(GRAVITY, &["--topic", TOPIC, "--from", "0.1", "--to", "99"]),
        with(REST, &["--topic", TOPIC]),
    ];
    for (name, motion) in MOTIONS {
        println!("{name}");
        let bytes = recording(motion);
        let is_first = name == MOTIONS[0].0;
        let both = plain.iter().filter(|_| is_first).chain(&commands);
        for command in both {
            cost("take.mcap", &bytes, command);
        }
    }
}

/// An estimate with a million poses more than it had.
#[test]
fn an_estimate_that_goes_on_for_ever_is_drawn_or_refused() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("out.mcap");
    let made = std::process::Command::new(env!("CARGO_BIN_EXE_enact"))
        .arg("replay")
        .arg(root.join("recordings/pencil_tip.mcap"))
        .arg("-o")
        .arg(&path)
        .output()
        .expect("run");
    assert!(made.status.success());
    let read = Recording::open(&path).expect("open");
    let mut channels = read.container().channels().iter();
    let found = channels.find(|(_, of)| of.topic == "/estimate/pencil/pose");
    let (channel, _) = found.expect("the motion");
    let mut bytes = std::fs::read(&path).expect("written");
    let end = (MAGIC.len()..).find(|at| bytes[*at..].starts_with(&record(0x0f, &[0; 4])[..9]));
    bytes.truncate(end.expect("the end of the data"));
    let first = 1_700_000_000_000_000_000_u64;
    for part in 0..8 {
        let poses = (0..100_000_u64).map(|k| (part * 100_000 + k) * 1_000);
        let poses = poses.flat_map(|at| message(*channel, first + at, &pose(first + at)));
        bytes.extend_from_slice(&chunk("zstd", &poses.collect::<Vec<u8>>()));
    }
    for command in [
        EXPORT,
        REPORT,
        &["export", "IN", "--to", "glb", "-o", "OUT"],
    ] {
        cost("take.mcap", &bytes, command);
    }
}
