//! Collisions that a scene counts, of which not all are marked: events of the scene that is read and of the one that
//! is estimated have other indices.

use std::path::Path;
use std::process::Output;

use enact::math::Pose;
use enact::motion::{Mark, PoseSample, Stamp};
use enact::write::RecordingWriter;
use nalgebra::{UnitQuaternion, Vector3};
use serde_json::Value;
use tempfile::TempDir;

use crate::program::enact;

const SCENE: &str = r#"name = "counted"
[timing]
stamps = "physical"
[[body]]
name = "ball"
shape = { kind = "sphere", radius_mm = 20 }
mass_g = 5
restitution = 0.8
[[surface]]
name = "table"
point_mm = [0, 0, 0]
normal = [0, 0, 1]
[[event]]
name = "bounce"
kind = "collision"
body = "ball"
surface = "table"
count = 3
[[event]]
name = "end"
kind = "end"
"#;

const RATE_HZ: f64 = 240.0;

/// Times of the bounces of a ball that falls from 0.5 m, and of its height at any time \[s, m\].
fn fall() -> (Vec<f64>, impl Fn(f64) -> f64) {
    let (gravity, radius_m, restitution) = (9.80665, 0.02, 0.8_f64);
    let first_s = f64::sqrt(2.0 * (0.5 - radius_m) / gravity);
    let mut times_s = vec![first_s];
    let mut speed_m_s = gravity * first_s * restitution;
    for _ in 0..2 {
        times_s.push(times_s[times_s.len() - 1] + 2.0 * speed_m_s / gravity);
        speed_m_s *= restitution;
    }
    let bounces_s = times_s.clone();
    let height_m = move |time_s: f64| {
        let done = times_s.iter().filter(|at| **at <= time_s).count();
        if done == 0 {
            return 0.5 - 0.5 * gravity * time_s * time_s;
        }
        let since_s = time_s - times_s[done - 1];
        let up_m_s = gravity * times_s[0] * restitution.powi(done as i32);
        radius_m + up_m_s * since_s - 0.5 * gravity * since_s * since_s
    };
    (bounces_s, height_m)
}

/// A take, its marks (times and names), and the events that it does not mark.
type Marked<'a> = (&'a str, Vec<(f64, Option<&'a str>)>, &'a [&'a str]);

/// A recording of it with some marks: times and names.
fn record(path: &Path, marks: &[(f64, Option<&str>)]) {
    let (_, height_m) = fall();
    let stamp = |time_s: f64| Stamp(1_000_000_000 + (time_s * 1e9).round() as i64);
    let mut writer = RecordingWriter::create(path).unwrap();
    let toml = SCENE.as_bytes();
    writer
        .attach("scene.toml", "application/toml", toml)
        .unwrap();
    for step in 0..(1.5 * RATE_HZ) as usize {
        let time_s = step as f64 / RATE_HZ;
        // A tenth of a millimetre that is not the motion's.
        let off = Vector3::from_fn(|axis, _| ((step * (7 + axis * 4)) as f64).sin() * 1e-4);
        let place = Vector3::new(0.05 * time_s, 0.0, height_m(time_s)) + off;
        let pose = Pose::from_parts(place.into(), UnitQuaternion::identity());
        let sample = PoseSample::from_pose(stamp(time_s), &pose);
        writer
            .pose("/tracker/ball/pose", "world", sample.stamp, &sample)
            .unwrap();
    }
    for (time_s, event) in marks {
        let stamp = stamp(*time_s);
        let event = event.map(str::to_owned);
        writer
            .mark("/marks", stamp, &Mark { stamp, event })
            .unwrap();
    }
    writer.finish().unwrap();
}

fn json(output: &Output) -> Value {
    let text = String::from_utf8_lossy(&output.stdout);
    let first = text.lines().next().unwrap_or_default();
    serde_json::from_str(first).unwrap_or_else(|error| panic!("{error}: {output:?}"))
}

#[test]
fn events_without_a_mark_are_named_as_they_are_estimated() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let (bounces_s, _) = fall();
    let all: Vec<(f64, Option<&str>)> = bounces_s.iter().map(|at| (*at, None)).collect();
    let takes: [Marked; 4] = [
        (
            "none.mcap",
            vec![],
            &["bounce 1", "bounce 2", "bounce 3", "end"],
        ),
        (
            "end.mcap",
            vec![(1.49, Some("end"))],
            &["bounce 1", "bounce 2", "bounce 3"],
        ),
        (
            "last.mcap",
            vec![(bounces_s[2], Some("bounce 3"))],
            &["bounce 1", "bounce 2", "end"],
        ),
        ("all.mcap", all, &["end"]),
    ];
    for (name, marks, missing) in &takes {
        record(&folder.join(name), marks);
        let ran = enact(
            folder,
            &["replay", name, "--format", "ndjson", "-o", "out.mcap"],
        );
        assert!(matches!(ran.status.code(), Some(0 | 3)), "{name}: {ran:?}");
        let said = json(&ran);
        let times: Vec<f64> = said["events"]
            .as_array()
            .unwrap()
            .iter()
            .map(|event| event["time_s"].as_f64().unwrap())
            .collect();
        for (time_s, true_s) in times.iter().zip(&bounces_s) {
            assert!(
                (time_s - true_s).abs() < 0.01,
                "{name}: {times:?}, {bounces_s:?}"
            );
        }
        let warnings = said["warnings"].to_string();
        for event in *missing {
            assert!(
                warnings.contains(&format!("\\\"{event}\\\" at ")),
                "{name}: {event}: {warnings}"
            );
        }
        // What reads the estimate back, and what estimates on its own.
        for arguments in [
            &["report", "out.mcap", "-o", "out.html"][..],
            &["export", "out.mcap", "--to", "csv", "-o", "out.csv"],
            &["sketch", name, "--estimated", "-o", "out-sketch.csv"],
            &["predict", name, "-o", "predicted.mcap"],
            &["inspect", name],
        ] {
            let ran = enact(folder, arguments);
            assert!(
                matches!(ran.status.code(), Some(0 | 1 | 3)),
                "{name}: {arguments:?}: {ran:?}"
            );
            let is_predict = arguments[0] == "predict";
            assert!(
                is_predict || ran.status.code() != Some(1),
                "{name}: {ran:?}"
            );
        }
    }
    let names: Vec<&str> = takes.iter().map(|(name, ..)| *name).collect();
    let all = [
        &["process"],
        &names[..],
        &["-o", "all", "--format", "ndjson"],
    ]
    .concat();
    let ran = enact(folder, &all);
    assert!(matches!(ran.status.code(), Some(0 | 3)), "{ran:?}");
    assert_eq!(String::from_utf8_lossy(&ran.stdout).lines().count(), 4);
}

#[test]
fn proposals_name_the_events_that_a_count_stands_for() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    record(&folder.join("none.mcap"), &[]);
    let arguments = [
        "mark",
        "none.mcap",
        "--propose",
        "--format",
        "ndjson",
        "-o",
        "marked.mcap",
    ];
    let ran = enact(folder, &arguments);
    assert_eq!(ran.status.code(), Some(0), "{ran:?}");
    let said = json(&ran);
    let named: Vec<&str> = said["proposals"]
        .as_array()
        .unwrap()
        .iter()
        .map(|of| of["event"].as_str().unwrap())
        .collect();
    assert_eq!(named, ["bounce 1", "bounce 2", "bounce 3", "end"]);
    let ran = enact(folder, &["replay", "marked.mcap", "--format", "ndjson"]);
    assert!(matches!(ran.status.code(), Some(0 | 3)), "{ran:?}");
    assert!(
        !json(&ran)["warnings"].to_string().contains("no marks"),
        "{ran:?}"
    );
}
