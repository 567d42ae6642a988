//! Sessions that pages in browsers captured: a throw of a controller becomes a recording that is estimated, its trigger
//! a mark, and real ones are read.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use assert_cmd::Command;
use enact::ingest::Recording;
use tempfile::TempDir;

use super::truth;
use crate::skip::skip;

/// Runs the program in a folder; its exit code and what it says.
fn enact(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::cargo_bin("enact").expect("enact");
    let output = command.current_dir(folder).args(arguments).output();
    let output = output.expect("enact");
    let said = [output.stdout, output.stderr].concat();
    (
        output.status.code(),
        String::from_utf8_lossy(&said).into_owned(),
    )
}

/// The truth as a headset sees it, y up: x, z and -y of ours are its x, y and -z.
fn poses() -> Vec<(f64, [f64; 7])> {
    let of = truth();
    let poses = of.iter().map(|sample| {
        let [x, y, z] = sample.position_m.into();
        let turn = {
            let [a, b, c, w] = sample.quaternion_xyzw;
            nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, a, b, c))
        };
        let back = nalgebra::UnitQuaternion::from_scaled_axis(
            nalgebra::Vector3::x() * -std::f64::consts::FRAC_PI_2,
        );
        let q = back * turn;
        (sample.stamp.0 as f64 * 1e-6, [x, z, -y, q.i, q.j, q.k, q.w])
    });
    poses.collect()
}

/// As iwer records it, with the trigger down for 60 ms at the bounce.
fn session() -> String {
    let mut frames = String::new();
    for (time_ms, [x, y, z, a, b, c, d]) in poses() {
        let pressed = u8::from((315.0..375.0).contains(&time_ms));
        // Who looks on nods a little.
        let nod = 1e-5 * time_ms;
        let comma = if frames.is_empty() { "" } else { "," };
        write!(
            frames,
            "{comma}[{time_ms},{nod},1.6,0,0,0,0,1,[0,0,0,0,0,0,0,1,[{x},{y},{z},{a},{b},{c},{d}],[[{pressed},0,{pressed}],[0,0,0],0,0]]]"
        )
        .expect("a text");
    }
    format!(
        r#"{{"schema":[[0,{{"handedness":"right","targetRayMode":"tracked-pointer","profiles":[],"hasGrip":true,"hasHand":false,"hasGamepad":true,"mapping":"xr-standard","numButtons":2,"numAxes":2}}]],"frames":[{frames}]}}"#
    )
}

#[test]
fn a_session_becomes_a_recording_with_its_trigger_as_a_mark() {
    let folder = TempDir::new().expect("folder");
    fs::write(folder.path().join("throw.json"), session()).expect("write");
    let arguments = [
        "import",
        "throw.json",
        "-o",
        "throw.mcap",
        "--topic",
        "right=/tracker/ball/pose",
    ];
    let (code, said) = enact(folder.path(), &arguments);
    assert_eq!(code, Some(0), "{said}");
    for part in [
        "recorded by iwer",
        "a trigger was pressed 1 times",
        "1 events of the files are marks",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let recording = Recording::open(&folder.path().join("throw.mcap")).expect("a recording");
    let marks = recording.container().channels().values();
    let marks: Vec<u64> = marks
        .filter(|channel| channel.topic == "/marks")
        .map(|channel| channel.messages)
        .collect();
    assert_eq!(marks, [1]);
    // Where it was, z up: the flights say so.
    assert!(said.contains("-9.8") || said.contains("9.81"), "{said}");
    // Marks by hand are instead of those.
    let by_hand = [&arguments[..4], &["--mark", "0.3"]].concat();
    let (code, said) = enact(folder.path(), &by_hand);
    assert_eq!(code, Some(0), "{said}");
    assert!(!said.contains("events of the files are marks"), "{said}");
}

#[test]
fn what_is_wrong_with_a_session_is_said_with_its_place() {
    let folder = TempDir::new().expect("folder");
    let whole = session();
    for (text, part) in [
        (
            whole.replacen(",[0,0,0,0,0,0,0,1,[", ",[3,0,0,0,0,0,0,1,[", 1),
            "frames[0]: a source that the schema lacks",
        ),
        (whole[..whole.len() / 2].to_owned(), "no whole JSON"),
        (
            r#"{"right":{"poses":[{"timestamp":1}]}}"#.to_owned(),
            "right.poses[0]",
        ),
        (r#"{"a":[1,2]}"#.to_owned(), "none of A-Frame's"),
    ] {
        fs::write(folder.path().join("x.json"), text).expect("write");
        let (code, said) = enact(folder.path(), &["import", "x.json", "-o", "x.mcap"]);
        assert_eq!(code, Some(1), "{said}");
        assert!(
            said.contains("x.json") && said.contains(part),
            "{part}: {said}"
        );
        assert!(!folder.path().join("x.mcap").exists());
    }
}

#[test]
fn a_real_controller_of_a_vive_is_read() {
    let real = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../shared/real/controllers/vive_controller.json");
    if !real.exists() {
        return skip(
            "a_real_controller_of_a_vive_is_read",
            "no recording of a real controller",
        );
    }
    let folder = TempDir::new().expect("folder");
    let real = real.to_str().expect("UTF-8");
    let (code, said) = enact(folder.path(), &["import", real, "-o", "vive.mcap"]);
    assert!(matches!(code, Some(0 | 3)), "{said}");
    assert!(said.contains("A-Frame's motion capture"), "{said}");
    let recording = Recording::open(&folder.path().join("vive.mcap")).expect("a recording");
    let mut topics: Vec<(&str, u64)> = recording
        .container()
        .channels()
        .values()
        .map(|channel| (channel.topic.as_str(), channel.messages))
        .collect();
    topics.sort_unstable();
    let expected = ["camera", "left", "right"].map(|name| format!("/tracker/{name}/pose"));
    let expected: Vec<(&str, u64)> = expected.iter().map(|topic| (topic.as_str(), 816)).collect();
    assert_eq!(topics, expected);
}
