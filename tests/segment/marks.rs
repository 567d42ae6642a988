//! Marks of a recording from outside: listed, added, moved, removed, taken from elsewhere; and proposed for a
//! whole toss, in which a ball is held, thrown, bounces and rests.

use std::fs;
use std::path::PathBuf;

use enact::motion::{Mark, PoseSample, Stamp};
use enact::write::RecordingWriter;
use nalgebra::Vector3;
use tempfile::TempDir;

use crate::program::enact;

const SCENE: &str = r#"
name = "a ball is thrown and bounces"

[timing]
stamps = "physical"

[[body]]
name = "ball"
shape = { kind = "sphere", radius_mm = 20 }
mass_g = 50

[[surface]]
name = "table"
point_mm = [0, 0, 0]
normal = [0, 0, 1]

[[event]]
name = "release"
kind = "start"

[[event]]
name = "bounce"
kind = "collision"
body = "ball"
surface = "table"
restitution = 0.6

[[event]]
name = "catch"
kind = "end"

[[free]]
quantity = "bounce.restitution"
"#;

const GRAVITY_M_S2: f64 = 9.80665;
const START: i64 = 1_700_000_000_000_000_000;
const RELEASE_S: f64 = 0.6;

/// Times of the first two impacts \[s\]: thrown up at 1 m/s from 0.4 m above the table.
fn impacts_s() -> [f64; 2] {
    let down_m_s = (1.0 + 2.0 * GRAVITY_M_S2 * 0.4_f64).sqrt();
    let first_s = RELEASE_S + (1.0 + down_m_s) / GRAVITY_M_S2;
    [first_s, first_s + 2.0 * 0.6 * down_m_s / GRAVITY_M_S2]
}

/// Held by a hand that winds up, thrown, two flights, small hops, and at rest from 2.2 s on.
fn height_m(time_s: f64) -> f64 {
    let [first_s, second_s] = impacts_s();
    let down_m_s = (1.0 + 2.0 * GRAVITY_M_S2 * 0.4_f64).sqrt();
    let flight = |from_m: f64, up_m_s: f64, since_s: f64| {
        from_m + up_m_s * since_s - 0.5 * GRAVITY_M_S2 * since_s * since_s
    };
    if time_s < RELEASE_S {
        // Still at first; then down and up again, until it moves up at 1 m/s.
        let s = (time_s - 0.3).max(0.0) / 0.3;
        0.4 + 0.3 * (s.powi(3) - s.powi(2))
    } else if time_s < first_s {
        flight(0.4, 1.0, time_s - RELEASE_S)
    } else if time_s < second_s {
        flight(0.0, 0.6 * down_m_s, time_s - first_s)
    } else {
        // Rolls and rocks to its rest, which is no flight.
        let since_s = time_s - second_s;
        0.01 * (-12.0 * since_s).exp() * (30.0 * since_s).sin().abs()
    }
}

/// At 200 Hz with a twentieth of a millimetre of noise.
fn toss() -> Vec<PoseSample> {
    let sample = |index: i64| {
        let time_s = index as f64 / 200.0;
        let (i, rest_s) = (index as f64, impacts_s()[1]);
        let noise = Vector3::new((12.9 * i).sin(), (78.2 * i).sin(), (37.7 * i).sin()) * 5e-5;
        let along_m = 0.5 * (time_s.min(rest_s + 0.1) - RELEASE_S).max(0.0);
        let at_m = Vector3::new(along_m, 0.1, 0.02 + height_m(time_s)) + noise;
        PoseSample::new(Stamp(START + index * 5_000_000), at_m, [0.0, 0.0, 0.0, 1.0])
    };
    (0..500).map(sample).collect()
}

struct Bench {
    folder: TempDir,
}

struct Ran {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Bench {
    /// A recording of the toss, logged 3 ms after it was stamped, with marks and messages of a button.
    fn new(scene: Option<&str>, marks_s: &[(f64, Option<&str>)], buttons_s: &[f64]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("scene.toml"), scene.unwrap_or(SCENE)).unwrap();
        let mut writer = RecordingWriter::create(&folder.path().join("in.mcap")).unwrap();
        if let Some(scene) = scene {
            writer
                .attach("scene.toml", "application/toml", scene.as_bytes())
                .unwrap();
        }
        for sample in toss() {
            let logged = Stamp(sample.stamp.0 + 3_000_000);
            writer
                .pose("/tracker/ball/pose", "world", logged, &sample)
                .unwrap();
        }
        let at = |time_s: f64| Stamp(START + (time_s * 1e9).round() as i64);
        for (time_s, event) in marks_s {
            let (stamp, event) = (at(*time_s), event.map(str::to_owned));
            writer
                .mark("/marks", stamp, &Mark { stamp, event })
                .unwrap();
        }
        for time_s in buttons_s {
            let sample = PoseSample::new(at(9.0), Vector3::zeros(), [0.0, 0.0, 0.0, 1.0]);
            let logged = Stamp(at(*time_s).0 + 3_000_000);
            writer.pose("/button", "world", logged, &sample).unwrap();
        }
        writer.finish().unwrap();
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn enact(&self, arguments: &[&str]) -> Ran {
        let output = enact(self.folder.path(), arguments);
        Ran {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    fn json(&self, arguments: &[&str]) -> serde_json::Value {
        let ran = self.enact(&[arguments, &["--format", "ndjson"]].concat());
        serde_json::from_str(&ran.stdout).unwrap_or_else(|_| panic!("{}{}", ran.stdout, ran.stderr))
    }

    /// Times and names of the marks that a recording has.
    fn listed(&self, name: &str) -> Vec<(f64, Option<String>)> {
        let json = self.json(&["mark", name, "--scene", "scene.toml"]);
        let marks = json["marks"].as_array().unwrap().iter();
        let mark = |mark: &serde_json::Value| {
            let time_s = mark["time_s"].as_f64().unwrap();
            (
                (time_s * 1e6).round() / 1e6,
                mark["event"].as_str().map(str::to_owned),
            )
        };
        marks.map(mark).collect()
    }

    fn written(&self, arguments: &[&str]) -> Vec<(f64, Option<String>)> {
        let before = fs::read(self.path("in.mcap")).unwrap();
        let ran = self.enact(&[&["mark", "in.mcap", "-o", "out.mcap"], arguments].concat());
        assert_eq!(ran.code, Some(0), "{arguments:?}: {}", ran.stderr);
        assert_eq!(fs::read(self.path("in.mcap")).unwrap(), before);
        self.listed("out.mcap")
    }
}

fn named(marks: &[(f64, &str)]) -> Vec<(f64, Option<String>)> {
    let mark = |(time_s, event): &(f64, &str)| {
        let event = (!event.is_empty()).then(|| (*event).to_owned());
        (*time_s, event)
    };
    marks.iter().map(mark).collect()
}

const MARKS: [(f64, Option<&str>); 3] =
    [(0.6, Some("release")), (1.0, Some("bounce")), (1.5, None)];

#[test]
fn marks_are_listed_added_moved_and_removed() {
    let bench = Bench::new(Some(SCENE), &MARKS, &[]);
    let all = named(&[(0.6, "release"), (1.0, "bounce"), (1.5, "")]);
    assert_eq!(bench.listed("in.mcap"), all);
    let text = bench.enact(&["mark", "in.mcap"]).stdout;
    for piece in ["1     0.600 s  release", "3     1.500 s  (next)"] {
        assert!(text.contains(piece), "{text}");
    }
    for (arguments, expected) in [
        (
            &["--add", "1.7:catch"][..],
            &[(0.6, "release"), (1.0, "bounce"), (1.5, ""), (1.7, "catch")][..],
        ),
        (
            &["--add", "1700000001250000000ns"],
            &[(0.6, "release"), (1.0, "bounce"), (1.25, ""), (1.5, "")],
        ),
        (
            &["--move", "bounce=1.02"],
            &[(0.6, "release"), (1.02, "bounce"), (1.5, "")],
        ),
        (
            &["--move", "3=1.6", "--move", "1=0.61"],
            &[(0.61, "release"), (1.0, "bounce"), (1.6, "")],
        ),
        (&["--remove", "1", "--remove", "3"], &[(1.0, "bounce")]),
        (
            &["--remove", "bounce", "--add", "1.1:bounce"],
            &[(0.6, "release"), (1.1, "bounce"), (1.5, "")],
        ),
        (&["--remove", "all"], &[]),
    ] {
        assert_eq!(bench.written(arguments), named(expected), "{arguments:?}");
        // Poses are as they were, with their log times, and the scene is there.
        let inspect = |name: &str| bench.json(&["inspect", name]);
        let (before, after) = (inspect("in.mcap"), inspect("out.mcap"));
        assert_eq!(before["poses"], after["poses"]);
        assert_eq!(
            (&after["scene"], &after["lost"]),
            (&before["scene"], &before["lost"])
        );
    }
}

#[test]
fn marks_are_taken_from_lists_and_from_topics() {
    let bench = Bench::new(None, &MARKS, &[0.61, 1.01, 1.51]);
    fs::write(
        bench.path("marks.json"),
        r#"[{"event": "release", "t_s": 0.59}, {"t_ms": 990}]"#,
    )
    .unwrap();
    fs::write(
        bench.path("marks.csv"),
        "event,stamp_ns\nbounce,1700000001002000000\n",
    )
    .unwrap();
    let scene = ["--scene", "scene.toml"];
    let written = |more: &[&str]| bench.written(&[&scene, more].concat());
    assert_eq!(
        written(&["--from", "marks.json"]),
        named(&[(0.59, "release"), (0.99, "")])
    );
    assert_eq!(
        written(&["--from", "marks.csv"]),
        named(&[(1.002, "bounce")])
    );
    // A button's messages are stamped by when they came, less what poses are logged late by.
    let of_button = named(&[(0.61, ""), (1.01, ""), (1.51, "")]);
    assert_eq!(written(&["--from-topic", "/button"]), of_button);
    assert_eq!(
        written(&[
            "--from-topic",
            "/button",
            "--remove",
            "2",
            "--add",
            "1.0:bounce"
        ]),
        named(&[(0.61, ""), (1.0, "bounce"), (1.51, "")])
    );
    // What `mark` prints may be edited and read again.
    let ran = bench.enact(&[
        "mark",
        "in.mcap",
        "--scene",
        "scene.toml",
        "--format",
        "ndjson",
    ]);
    fs::write(
        bench.path("printed.json"),
        ran.stdout.replace("1.5", "1.625"),
    )
    .unwrap();
    let from_printed = written(&["--from", "printed.json"]);
    assert_eq!(
        from_printed[..2],
        named(&[(0.6, "release"), (1.0, "bounce")])
    );
}

#[test]
fn what_cannot_be_changed_is_refused_and_leaves_nothing() {
    let bench = Bench::new(Some(SCENE), &MARKS, &[]);
    fs::write(
        bench.path("bad.csv"),
        "t_s,event\n0.5,bounce\nlater,catch\n",
    )
    .unwrap();
    for (arguments, code, message) in [
        (
            &["--add", "1.2:jump", "-o", "x.mcap"][..],
            1,
            "no event \"jump\" in the scene, which has release",
        ),
        (
            &["--add", "1.2:bounce", "-o", "x.mcap"],
            1,
            "a second mark of \"bounce\"",
        ),
        (
            &["--move", "catch=1.2", "-o", "x.mcap"],
            1,
            "no mark \"catch\"; there are 1 release, 2 bounce, 3 (next)",
        ),
        (&["--remove", "4", "-o", "x.mcap"], 1, "no mark \"4\""),
        (
            &["--from", "bad.csv", "-o", "x.mcap"],
            1,
            "bad.csv:3: \"later\" is no time",
        ),
        (
            &["--from-topic", "/none", "-o", "x.mcap"],
            1,
            "no topic /none; the recording has /marks",
        ),
        (
            &[
                "--from-topic",
                "/marks",
                "--from",
                "bad.csv",
                "-o",
                "x.mcap",
            ],
            2,
            "cannot be used with",
        ),
        (&["-o", "x.mcap"], 1, "nothing to write, expected --propose"),
        (&["--add", "1.2"], 2, "--output"),
        (
            &["--add", "soon", "-o", "x.mcap"],
            2,
            "expected seconds since the first pose",
        ),
        (
            &["--move", "bounce", "-o", "x.mcap"],
            2,
            "such as bounce=0.41",
        ),
        (
            &["--add", "1.2", "-o", "in.mcap"],
            1,
            "would replace an input",
        ),
        (
            &["--propose", "--add", "1.2", "-o", "x.mcap"],
            2,
            "cannot be used with",
        ),
    ] {
        let ran = bench.enact(&[&["mark", "in.mcap"], arguments].concat());
        assert_eq!(
            ran.code,
            Some(code),
            "{arguments:?}: {}{}",
            ran.stdout,
            ran.stderr
        );
        assert!(
            ran.stderr.contains(message),
            "{arguments:?}: {}",
            ran.stderr
        );
        assert!(!bench.path("x.mcap").exists());
    }
    let bare = Bench::new(None, &MARKS, &[]);
    let ran = bare.enact(&["mark", "in.mcap"]);
    assert_eq!(ran.code, Some(1));
    assert!(
        ran.stderr.contains("expected one or --scene FILE"),
        "{}",
        ran.stderr
    );
}

#[test]
fn a_whole_toss_is_proposed_from_release_to_the_next_impact() {
    let bench = Bench::new(Some(SCENE), &[], &[]);
    let [first_s, second_s] = impacts_s();
    let marks = bench.written(&["--propose"]);
    for ((found_s, event), (name, expected_s, samples)) in marks.iter().zip([
        ("release", RELEASE_S, 4.0),
        ("bounce", first_s, 1.0),
        ("catch", second_s, 2.0),
    ]) {
        assert_eq!(event.as_deref(), Some(name), "{marks:?}");
        let off = (found_s - expected_s).abs() * 200.0;
        assert!(off <= samples, "{name}: {found_s} s, {expected_s} s");
    }
    // Marked so, and without marks, it is estimated.
    for name in ["in.mcap", "out.mcap"] {
        let report = bench.json(&["replay", name, "-o", "estimate.mcap"]);
        assert_eq!(report["verdict"], "physical", "{name}: {report}");
        let found = report["parameters"]["bounce.restitution"]["value"]
            .as_f64()
            .unwrap();
        assert!((found - 0.6).abs() < 0.01, "{name}: {found}");
    }
    // Of a scene that ends with the first impact, that is the end.
    let collision =
        "kind = \"collision\"\nbody = \"ball\"\nsurface = \"table\"\nrestitution = 0.6\n";
    let flight = SCENE.replace(collision, "kind = \"end\"\n");
    let flight = flight
        .split("\n[[event]]\nname = \"catch\"")
        .next()
        .unwrap();
    let bench = Bench::new(Some(flight), &[], &[]);
    let marks = bench.written(&["--propose"]);
    assert_eq!(marks.len(), 2, "{marks:?}");
    assert!((marks[1].0 - first_s).abs() * 200.0 <= 1.0, "{marks:?}");
    // Marks that are there are left out when asked for.
    let bench = Bench::new(Some(SCENE), &MARKS, &[]);
    assert_eq!(bench.written(&["--propose", "--remove", "all"]).len(), 3);
}
