//! Written sketches: files of keyframes become recordings that `replay` takes, and come back.

use std::fs;
use std::path::Path;

use enact::config::{scene_from_toml, sketch_from_csv, sketch_from_toml};
use enact::motion::{Keyframe, KeyframeTime, Mark, Scene, SketchRow, Stamp, TrackIndex};
use enact::write::{csv_of_sketch, toml_of_sketch};
use nalgebra::Vector3;
use proptest::prelude::*;
use tempfile::TempDir;

use crate::program::enact;

/// The files that the page shows, by their names.
fn shown() -> Vec<(String, String)> {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/sketch.md");
    let text = fs::read_to_string(page).unwrap();
    let mut files = Vec::new();
    let mut rest = text.as_str();
    while let Some((_, after)) = rest.split_once("\n```") {
        let (info, body) = after.split_once('\n').unwrap();
        let (block, next) = body.split_once("```").unwrap();
        let name = info.split_whitespace().last().unwrap_or_default();
        files.push((name.to_owned(), block.to_owned()));
        rest = next;
    }
    files
}

/// The page's files in a folder.
fn page_folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    for (name, text) in shown().iter().filter(|(name, _)| name != "console") {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let scene = fs::read_to_string(folder.path().join("scene.toml")).unwrap();
    let edited = scene.replace("\"physical\"", "\"edited\"");
    assert_ne!(edited, scene);
    fs::write(folder.path().join("edited.toml"), edited).unwrap();
    folder
}

/// Whatever a recording's marks are called, or are not: what is written of it is read again.
#[test]
fn what_is_written_of_a_recording_with_marks_without_names_is_read_again() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let recording = root.join("recordings/pencil_tip.mcap");
    let scene = root.join("config/pencil_tip.toml");
    let [recording, scene] = [&recording, &scene].map(|path| path.to_str().unwrap());
    let folder = TempDir::new().unwrap();
    for written in ["k.csv", "k.toml"] {
        let sketch = ["sketch", recording, "--per-flight", "5", "-o", written];
        let output = enact(folder.path(), &sketch);
        assert!(output.status.success(), "{output:?}");
        let text = fs::read_to_string(folder.path().join(written)).unwrap();
        for event in ["bounce", "landing"] {
            assert!(text.contains(event), "{text}");
        }
        let back = ["sketch", written, "--scene", scene, "-o", "k.mcap"];
        let output = enact(folder.path(), &back);
        assert!(output.status.success(), "{output:?}");
        let again = enact(folder.path(), &["inspect", "k.mcap", "--format", "ndjson"]);
        let line: serde_json::Value = serde_json::from_slice(&again.stdout).unwrap();
        let marks = line["marks"].as_array().unwrap().iter();
        let names: Vec<&str> = marks.map(|mark| mark["event"].as_str().unwrap()).collect();
        assert_eq!(names, ["bounce", "landing"]);
    }
}

#[test]
fn the_pages_commands_do_what_it_says() {
    let folder = page_folder();
    let consoles = shown();
    let consoles = consoles.iter().filter(|(name, _)| name == "console");
    let mut commands = 0;
    for (_, console) in consoles {
        for line in console.lines() {
            let line = line.strip_prefix("$ enact ").expect("a command");
            let arguments: Vec<&str> = line.split_whitespace().collect();
            let output = enact(folder.path(), &arguments);
            assert!(output.status.success(), "{line}: {output:?}");
            commands += 1;
        }
    }
    assert_eq!(commands, 9);
    // Both are the motion of which the keyframes are.
    for recording in ["ball.mcap", "flights.mcap", "loose.mcap"] {
        let arguments = ["replay", recording, "--format", "ndjson"];
        let output = enact(folder.path(), &arguments);
        let line: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(line["verdict"], "physical", "{line}");
        assert_eq!(line["undetermined"], serde_json::json!([]), "{line}");
        let time_s = line["events"][0]["time_s"].as_f64().unwrap();
        assert!((time_s - 0.390_166).abs() < 1e-5, "{recording}: {time_s} s");
    }
    // The motion at 30 Hz: the ball is where it falls to.
    let scene = scene_of(folder.path(), "scene.toml");
    let motion = fs::read_to_string(folder.path().join("motion.csv")).unwrap();
    let rows = sketch_from_csv(&motion, &scene).unwrap();
    let heights = rows.iter().filter_map(|row| match row {
        SketchRow::Keyframe { keyframe, .. } => match (keyframe.time, keyframe.position_m) {
            (KeyframeTime::Known(stamp), Some(at)) => Some((stamp.seconds_since(Stamp(0)), at.z)),
            _ => None,
        },
        SketchRow::Mark(_) => None,
    });
    let falling: Vec<(f64, f64)> = heights.filter(|(t, _)| *t < 0.39).collect();
    assert!(falling.len() > 10, "{falling:?}");
    for (time_s, height_m) in falling {
        let since_s = time_s + 0.05;
        let expected_m = 1.0 - 0.5 * 9.80665 * since_s * since_s;
        assert!((height_m - expected_m).abs() < 1e-5, "{time_s}: {height_m}");
    }
}

fn scene_of(folder: &Path, name: &str) -> Scene {
    scene_from_toml(&fs::read_to_string(folder.join(name)).unwrap()).unwrap()
}

#[test]
fn rows_come_back_from_the_recording() {
    let folder = page_folder();
    let cases = [
        ("ball.csv", "scene.toml", "back.toml"),
        ("flights.toml", "edited.toml", "back.csv"),
    ];
    for (written, scene, back) in cases {
        let arguments = ["sketch", written, "--scene", scene, "-o", "made.mcap"];
        assert!(enact(folder.path(), &arguments).status.success());
        let arguments = ["sketch", "made.mcap", "-o", back];
        assert!(enact(folder.path(), &arguments).status.success());
        let of = scene_of(folder.path(), scene);
        let rows = |name: &str| {
            let text = fs::read_to_string(folder.path().join(name)).unwrap();
            let read = if name.ends_with(".csv") {
                sketch_from_csv
            } else {
                sketch_from_toml
            };
            sorted(read(&text, &of).unwrap())
        };
        assert_eq!(rows(written), rows(back));
    }
}

/// Marks last: TOML has them in a list of their own.
fn sorted(mut rows: Vec<SketchRow>) -> Vec<SketchRow> {
    rows.sort_by_key(|row| matches!(row, SketchRow::Mark(_)));
    rows
}

#[test]
fn a_recorded_stream_becomes_keyframes_from_which_it_is_found_again() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = TempDir::new().unwrap();
    let die = root.join("recordings/die.mcap");
    let arguments = [
        "sketch",
        die.to_str().unwrap(),
        "--per-flight",
        "4",
        "-o",
        "die.csv",
    ];
    let output = enact(folder.path(), &arguments);
    assert!(output.status.success(), "{output:?}");
    let text = fs::read_to_string(folder.path().join("die.csv")).unwrap();
    assert_eq!(text.lines().count(), 1 + 7 * 4, "{text}");
    assert!(text.starts_with("flight,t_s,x_m,"), "{text}");
}

#[test]
fn mistakes_are_answered_with_place_and_expectation() {
    let folder = page_folder();
    let scene = scene_of(folder.path(), "scene.toml");
    let edited = scene_of(folder.path(), "edited.toml");
    let pose = "0,0,1,1,0,0,0";
    let head = "event,body,t,x,y,z,qw,qx,qy,qz";
    for (text, of, place, parts) in [
        (String::new(), &scene, (1, 1), ["empty", "column names"]),
        (
            "t,x,y,z,qv".into(),
            &scene,
            (1, 9),
            ["`qv`", "did you mean `qw`"],
        ),
        (
            "t,x,y,z,t_ms".into(),
            &scene,
            (1, 9),
            ["`t_ms`", "another column"],
        ),
        (
            format!("{head}\n,,0,{pose}\n,,0.1,1"),
            &scene,
            (3, 1),
            ["4 fields", "10"],
        ),
        (
            format!("{head}\n,,0,0,O,1,1,0,0,0"),
            &scene,
            (2, 7),
            ["`O`", "no number"],
        ),
        (
            format!("{head}\n,,0,0,nan,1,1,0,0,0"),
            &scene,
            (2, 7),
            ["`nan`", "no number"],
        ),
        (
            format!("{head}\n,bell,0,{pose}"),
            &scene,
            (2, 2),
            ["\"bell\"", "did you mean \"ball\""],
        ),
        (
            format!("{head}\nbunce,,0,,,,,,,"),
            &scene,
            (2, 1),
            ["\"bunce\"", "did you mean \"bounce\""],
        ),
        (
            format!("{head}\nbounce,,,,,,,,,"),
            &scene,
            (2, 1),
            ["no time", "expected `t`"],
        ),
        (
            format!("{head}\nbounce,,1,{pose}"),
            &scene,
            (2, 11),
            ["no pose", "one row for"],
        ),
        (
            format!("{head}\n,,0.2,{pose}\n,,0.1,{pose}"),
            &scene,
            (3, 3),
            ["not later", "order of time"],
        ),
        (
            format!("{head}\n,,-1,{pose}"),
            &scene,
            (2, 3),
            ["-1 s", "expected 0 to"],
        ),
        (
            format!("{head}\n,,0,0,0,,1,0,0,0"),
            &scene,
            (2, 5),
            ["2 of 3", "x, y and z"],
        ),
        (
            format!("{head}\n,,0,0,0,1,1,1,0,0"),
            &scene,
            (2, 11),
            ["norm 1.414", "expected 1"],
        ),
        (
            format!("{head}\n,,0,,,,,,,"),
            &scene,
            (2, 1),
            ["neither", "or both"],
        ),
        (
            "t,t_min,x,y,z\n0,0,0,0,1".into(),
            &scene,
            (2, 1),
            ["both `t`", "interval"],
        ),
        (
            "t_min,t_max,x,y,z\n2,1,0,0,1".into(),
            &scene,
            (2, 3),
            ["before t_min", ""],
        ),
        (
            "t_min,t_max,x,y,z\n2,,0,0,1".into(),
            &scene,
            (2, 1),
            ["one end", "both"],
        ),
        (
            "flight,t,x,y,z\n1,0,0,0,1".into(),
            &scene,
            (2, 1),
            ["flight", "expected none"],
        ),
        (
            "flight,t,x,y,z\n3,0,0,0,1".into(),
            &edited,
            (2, 1),
            ["flight 3", "expected 1 to 2"],
        ),
        (
            "t,x,y,z\n0,0,0,1".into(),
            &edited,
            (2, 1),
            ["no `flight`", "expected 1 to 2"],
        ),
        (
            "event,t\nbounce,0".into(),
            &edited,
            (2, 1),
            ["no marks", "leave the row out"],
        ),
        (
            "t,x,y,z\n0,\"0,0,1".into(),
            &scene,
            (2, 3),
            ["not closed", "comma"],
        ),
        (
            "t,x,y,z,position_sd_mm\n0,0,0,1,-2".into(),
            &scene,
            (2, 9),
            ["deviation", "positive"],
        ),
    ] {
        let error = sketch_from_csv(&text, of).expect_err(&text);
        let said = error.to_string();
        assert_eq!((error.line, error.column), place, "{text}: {said}");
        for part in parts {
            assert!(said.contains(part), "{text}: {said}");
        }
    }
    for (text, place, part) in [
        ("[[keyframe]]\nt_s = 0\nposition_m = [0, 0]", (3, 14), "3"),
        (
            "[[keyframe]]\nt_s = 0\nplace_m = [0, 0, 0]",
            (3, 1),
            "unknown key `place_m`",
        ),
        (
            "[[keyframe]]\nt_s = 0\nt_ms = 0\nposition_m = [0, 0, 0]",
            (3, 8),
            "both `t_s` and `t_ms`",
        ),
        (
            "[[keyframe]]\nt_s = nan\nposition_m = [0, 0, 0]",
            (2, 7),
            "finite",
        ),
        (
            "[[mark]]\nevent = \"bump\"\nt_s = 0",
            (2, 9),
            "unknown event",
        ),
    ] {
        let error = sketch_from_toml(text, &scene).expect_err(text);
        let said = error.to_string();
        assert_eq!((error.line, error.column), place, "{text}: {said}");
        assert!(said.contains(part), "{text}: {said}");
    }
}

#[test]
fn orientations_are_written_in_degrees_and_rounded_quaternions_are_taken() {
    let folder = page_folder();
    let scene = scene_of(folder.path(), "scene.toml");
    let turned = |rows: Vec<SketchRow>| -> Vec<[f64; 4]> {
        let keyframes = rows.into_iter().filter_map(|row| match row {
            SketchRow::Keyframe { keyframe, .. } => keyframe.orientation_wxyz,
            SketchRow::Mark(_) => None,
        });
        keyframes.collect()
    };
    // Rz(90°)·Rx(90°): x goes to y, and y to z.
    let csv = "t,x,y,z,roll_deg,pitch_deg,yaw_deg\n0,0,0,1,90,0,90\n0.1,0,0,1,0,0,0\n";
    let toml = "[[keyframe]]\nt_s = 0\nposition_m = [0, 0, 1]\nrpy_deg = [90, 0, 90]\n\n\
                [[keyframe]]\nt_s = 0.1\nposition_m = [0, 0, 1]\nrpy_deg = [0, 0, 0]\n";
    for found in [
        turned(sketch_from_csv(csv, &scene).unwrap()),
        turned(sketch_from_toml(toml, &scene).unwrap()),
    ] {
        let expected = [[0.5; 4], [1.0, 0.0, 0.0, 0.0]];
        for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }
    let twice = "t,qw,qx,qy,qz,roll_deg,pitch_deg,yaw_deg\n0,1,0,0,0,90,0,90\n";
    let error = sketch_from_csv(twice, &scene).unwrap_err().to_string();
    assert!(error.contains("given twice"), "{error}");
    // Of norm 0.99, which is said; positions alone, which are no keyframes.
    fs::write(
        folder.path().join("rounded.csv"),
        "t,x,y,z,qw,qx,qy,qz\n0,0,0,1,0.7,0.7,0,0\n0.1,0,0,0.9,0.7,0.7,0,0\n",
    )
    .unwrap();
    fs::write(
        folder.path().join("places.csv"),
        "t,x,y,z\n0,0,0,1\n0.1,0,0,0.9\n",
    )
    .unwrap();
    for (file, said) in [
        (
            "rounded.csv",
            "2 quaternions have a norm other than 1, the first 0.9899",
        ),
        ("places.csv", "has positions alone"),
    ] {
        let output = enact(folder.path(), &["sketch", file, "--scene", "scene.toml"]);
        assert!(output.status.success(), "{output:?}");
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(text.contains(said), "{text}");
    }
}

#[test]
fn the_program_refuses_with_a_code_and_leaves_no_file() {
    let folder = page_folder();
    fs::write(folder.path().join("bad.csv"), "t,x,y,z\n0,0,0,high\n").unwrap();
    fs::write(folder.path().join("open.csv"), ONE_SD).unwrap();
    fs::write(folder.path().join("aside.csv"), ASIDE).unwrap();
    let refused = |arguments: &[&str], code: i32, part: &str| {
        let output = enact(folder.path(), arguments);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
        assert!(said.contains(part), "{arguments:?}: {said}");
    };
    let bad = ["sketch", "bad.csv", "--scene", "scene.toml"];
    refused(&bad, 1, "bad.csv:2:7: `high` is no number");
    assert!(!folder.path().join("bad.mcap").exists());
    refused(&["sketch", "ball.csv"], 1, "--scene");
    refused(&["sketch", "ball.txt"], 1, ".csv or .toml");
    refused(
        &["sketch", "ball.csv", "-o", "other.toml"],
        1,
        "one recording",
    );
    refused(
        &["sketch", "ball.csv", "--per-flight", "0"],
        2,
        "per-flight",
    );
    // On which side of the bounce is the second?
    refused(
        &["sketch", "aside.csv", "--scene", "scene.toml"],
        1,
        "keyframe 2 of body \"ball\" may be before event \"bounce\" or after it",
    );
    assert!(!folder.path().join("aside.mcap").exists());
    // What cannot be estimated is written, said, and refused by `replay`.
    let open = ["sketch", "open.csv", "--scene", "scene.toml"];
    let output = enact(folder.path(), &open);
    assert!(output.status.success());
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("`replay` refuses the recording"), "{said}");
    refused(&["replay", "open.mcap"], 1, "keyframe 2 has one standard");
}

const ONE_SD: &str = "t,x,y,z,qw,qx,qy,qz,position_sd_mm
0,0,0,1,1,0,0,0,
0.2,0,0,0.8,1,0,0,0,5
";

const ASIDE: &str = "event,t,x,y,z
,0,0,0,1
,,0,0,0.5
,0.9,0,0,0.6
bounce,0.44,,,
";

/// A ball that does not turn: when it had its orientation nothing tells.
const UNTURNED: &str = "event,t_ms,x_mm,y_mm,z_mm,qw,qx,qy,qz
,0,0,0,1000,1,0,0,0
,,,,,1,0,0,0
,200,100,0,803.867,1,0,0,0
bounce,440,,,,,,,
,600,300,0,476.680890,1,0,0,0
,800,400,0,657.709187,1,0,0,0
";

#[test]
fn a_time_that_nothing_tells_is_named() {
    let folder = page_folder();
    fs::write(folder.path().join("unturned.csv"), UNTURNED).unwrap();
    let arguments = ["sketch", "unturned.csv", "--scene", "scene.toml"];
    let output = enact(folder.path(), &arguments);
    assert!(output.status.success(), "{output:?}");
    let output = enact(
        folder.path(),
        &["replay", "unturned.mcap", "--format", "ndjson"],
    );
    let line: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let open = line["undetermined"].to_string();
    assert!(open.contains("ball.keyframe.2.time"), "{line}");
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![-1e3..1e3, Just(0.0), Just(1.0 / 3.0), -1e-12..1e-12]
}

fn keyframe() -> impl Strategy<Value = Keyframe> {
    let position = prop::option::of(prop::array::uniform3(number()));
    let orientation = prop::option::of(prop::array::uniform4(-1.0..1.0_f64));
    let sds = (prop::option::of(1e-6..1.0), prop::option::of(1e-3..90.0));
    (position, orientation, sds, 0..3_u8, 0..1_000_000_i64).prop_map(
        |(position, orientation, (position_sd_m, orientation_sd_deg), time, lasts_ns)| {
            let unit = orientation.map(|q: [f64; 4]| {
                let norm = q.iter().map(|c| c * c).sum::<f64>().sqrt();
                if norm > 0.1 {
                    q.map(|c| c / norm)
                } else {
                    [1.0, 0.0, 0.0, 0.0]
                }
            });
            let position = match (position, unit) {
                (None, None) => Some([0.0; 3]),
                (position, _) => position,
            };
            Keyframe {
                time: match time {
                    0 => KeyframeTime::Unknown,
                    1 => KeyframeTime::Within(Stamp(5), Stamp(5 + lasts_ns)),
                    _ => KeyframeTime::Known(Stamp(0)),
                },
                position_m: position.map(Vector3::from),
                orientation_wxyz: unit,
                position_sd_m,
                orientation_sd_deg,
            }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn rows_are_the_same_after_writing_and_reading(
        keyframes in prop::collection::vec(keyframe(), 1..8),
        mark_ns in 0_i64..80_000_000_000_000,
    ) {
        let scene = scene_from_toml(&shown()[0].1).unwrap();
        let mut rows: Vec<SketchRow> = keyframes.into_iter().enumerate().map(|(index, mut keyframe)| {
            if let KeyframeTime::Known(stamp) = &mut keyframe.time {
                *stamp = Stamp(index as i64 * 123_456_789);
            }
            SketchRow::Keyframe { track: TrackIndex(0), flight: 0, keyframe }
        }).collect();
        rows.push(SketchRow::Mark(Mark { stamp: Stamp(mark_ns), event: Some("bounce".into()) }));
        let csv = csv_of_sketch(&rows, &scene);
        prop_assert_eq!(&sketch_from_csv(&csv, &scene).unwrap(), &rows);
        let toml = toml_of_sketch(&rows, &scene);
        prop_assert_eq!(&sketch_from_toml(&toml, &scene).unwrap(), &rows);
    }

    #[test]
    fn no_text_panics_and_no_row_is_lost(
        cells in prop::collection::vec(prop::collection::vec("[-0-9.eE+ \"#,a-z\u{e9}]{0,6}", 0..6), 0..6),
        is_headed in any::<bool>(),
        ends in prop_oneof![Just("\n"), Just("\r\n"), Just(",\n")],
    ) {
        let scene = scene_from_toml(&shown()[0].1).unwrap();
        let mut text = if is_headed { "t,x,y,z,event\n".to_owned() } else { String::new() };
        for row in &cells {
            text += &row.join(",");
            text += ends;
        }
        if let Ok(rows) = sketch_from_csv(&text, &scene) {
            let is_row = |line: &&str| !line.trim().is_empty() && !line.trim().starts_with('#');
            prop_assert_eq!(rows.len() + 1, text.lines().filter(is_row).count());
        }
        let _ = sketch_from_toml(&text, &scene);
    }
}
