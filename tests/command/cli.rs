//! The commands from outside: what they print, where, with which exit code, and what they leave
//! behind when something is wrong.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use crate::skip::skip;
use assert_cmd::Command;
use enact::math::Pose;
use enact::motion::{Mark, PoseSample, Stamp};
use enact::write::RecordingWriter;
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use tempfile::TempDir;

const SCENE: &str = r#"
name = "a ball bounces once"

[timing]
stamps = "physical"

[[body]]
name = "ball"
shape = { kind = "sphere", radius_mm = 20 }
mass_g = 50
features_mm = { south = [0, 0, -20] }

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
feature = "south"
surface = "table"
restitution = 0.5

[[event]]
name = "catch"
kind = "end"

[[free]]
quantity = "bounce.restitution"
"#;

const GRAVITY_M_S2: f64 = 9.80665;
const HEIGHT_M: f64 = 0.5;
const START: i64 = 1_700_000_000_000_000_000;

fn at(time_s: f64) -> Stamp {
    Stamp(START + (time_s * 1e9).round() as i64)
}

fn bounce_s() -> f64 {
    (2.0 * (HEIGHT_M - 0.02) / GRAVITY_M_S2).sqrt()
}

/// Dropped, bounces with half its speed; does not turn, so that its south stays south.
fn pose(time_s: f64) -> Pose {
    let after_s = time_s - bounce_s();
    let height_m = if after_s < 0.0 {
        HEIGHT_M - 0.5 * GRAVITY_M_S2 * time_s * time_s
    } else {
        let speed_m_s = 0.5 * GRAVITY_M_S2 * bounce_s();
        0.02 + speed_m_s * after_s - 0.5 * GRAVITY_M_S2 * after_s * after_s
    };
    Pose::from_parts(
        Translation3::new(0.1 * time_s, 0.0, height_m),
        UnitQuaternion::identity(),
    )
}

/// What is in a recording.
struct Plan {
    scene: Option<String>,
    topic: &'static str,
    times_s: Vec<f64>,
    marks: Vec<(f64, Option<&'static str>)>,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            scene: Some(SCENE.into()),
            topic: "/tracker/ball/pose",
            times_s: (0..=110).map(|i| f64::from(i) * 0.005).collect(),
            marks: vec![(0.0, None), (bounce_s(), None), (0.55, None)],
        }
    }
}

impl Plan {
    fn write(&self, path: &Path) {
        let mut writer = RecordingWriter::create(path).unwrap();
        if let Some(scene) = &self.scene {
            writer
                .attach("scene.toml", "application/toml", scene.as_bytes())
                .unwrap();
        }
        for time_s in &self.times_s {
            let sample = PoseSample::from_pose(at(*time_s), &pose(*time_s));
            writer
                .pose(self.topic, "world", at(*time_s), &sample)
                .unwrap();
        }
        for (time_s, event) in &self.marks {
            let mark = Mark {
                stamp: at(*time_s),
                event: event.map(str::to_owned),
            };
            writer.mark("/marks", at(0.6), &mark).unwrap();
        }
        writer.finish().unwrap();
    }
}

/// A folder with `take.mcap` and an empty folder `out`.
struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new(plan: &Plan) -> Self {
        let bench = Self {
            folder: TempDir::new().unwrap(),
        };
        fs::create_dir(bench.path("out")).unwrap();
        plan.write(&bench.path("take.mcap"));
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn enact(&self, arguments: &[&str]) -> Ran {
        let output = enact()
            .current_dir(self.folder.path())
            .args(arguments)
            .output()
            .unwrap();
        Ran {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Replays `take.mcap` and asserts an error with that message and nothing left behind.
    fn refuses(&self, more: &[&str], message: &str) {
        let mut arguments = vec!["replay", "take.mcap", "-o", "out/x.mcap"];
        arguments.extend(more);
        let ran = self.enact(&arguments);
        ran.failed_with(message);
        assert_eq!(ran.stdout, "");
        self.left_nothing();
    }

    fn left_nothing(&self) {
        let left: Vec<_> = fs::read_dir(self.path("out")).unwrap().collect();
        assert!(left.is_empty(), "{left:?}");
    }
}

struct Ran {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Ran {
    fn failed_with(&self, message: &str) {
        assert_eq!(self.code, Some(1), "{}", self.stderr);
        assert!(self.stderr.starts_with("error: "), "{}", self.stderr);
        assert!(
            self.stderr.contains(message),
            "{:?} is not in {}",
            message,
            self.stderr
        );
        assert_eq!(self.stderr.lines().count(), 1, "{}", self.stderr);
    }

    /// Wrote an estimate, whatever its verdict.
    fn finished(&self) {
        assert!(
            matches!(self.code, Some(0 | 3)),
            "{:?}: {}",
            self.code,
            self.stderr
        );
        assert_eq!(self.stderr, "");
    }

    fn json(&self) -> Vec<serde_json::Value> {
        let lines = self.stdout.lines();
        lines
            .map(|line| serde_json::from_str(line).unwrap())
            .collect()
    }
}

fn enact() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_enact"));
    command.env_remove("RUST_LOG").env_remove("NO_COLOR");
    command
}

#[test]
fn marks_must_fit_the_scene() {
    let elsewhere = Plan {
        scene: Some(format!("marks_topic = \"/notes\"\n{SCENE}")),
        ..Plan::default()
    };
    Bench::new(&elsewhere).refuses(&[], "no marks: topic /notes is not in the recording");
    // Nobody lets go twice.
    let two = Plan {
        marks: vec![(0.0, None), (0.01, None)],
        ..Plan::default()
    };
    Bench::new(&two).refuses(
        &[],
        "take.mcap: 2 marks, expected 3: \"release\", \"bounce\", \"catch\"",
    );
    let other = Plan {
        marks: vec![(0.0, None), (bounce_s(), Some("bonk")), (0.55, None)],
        ..Plan::default()
    };
    Bench::new(&other).refuses(&[], "is for \"bonk\", expected one of \"release\"");
    let outside = Plan {
        marks: vec![(0.0, None), (bounce_s(), None), (7.0, None)],
        ..Plan::default()
    };
    Bench::new(&outside).refuses(
        &[],
        "the mark of \"catch\" is at 7.000 s, outside the data: expected 0.000 to 0.550 s",
    );
}

#[test]
fn marks_that_are_absent_are_put_at_the_kinks_and_that_is_said() {
    for marks in [vec![], vec![(0.0, None), (0.55, None)]] {
        let plan = Plan {
            marks,
            ..Plan::default()
        };
        let bench = Bench::new(&plan);
        let ran = bench.enact(&["replay", "take.mcap", "-o", "out/x.mcap"]);
        ran.finished();
        let note = "note: no marks for some events, put where the stream suggests: ";
        assert!(ran.stdout.contains(note), "{}", ran.stdout);
        assert!(ran.stdout.contains("\"bounce\" at 0.31"), "{}", ran.stdout);
    }
}

#[test]
fn segments_need_samples() {
    let sparse = Plan {
        times_s: vec![0.01, 0.35, 0.45],
        marks: vec![(0.05, None), (0.3, None), (0.5, None)],
        ..Plan::default()
    };
    Bench::new(&sparse).refuses(
        &[],
        "`ball` has 0 usable samples between `release` and `bounce`: at least 1 are needed",
    );
}

#[test]
fn a_body_without_a_tracker_is_named() {
    let elsewhere = Plan {
        topic: "/vrpn_mocap/ball/pose",
        ..Plan::default()
    };
    Bench::new(&elsewhere).refuses(
        &[],
        "no topic /tracker/ball/pose, which body \"ball\" of the scene wants; the recording has /marks, /vrpn_mocap/ball/pose",
    );
}

#[test]
fn the_scene_must_be_there_be_right_and_match() {
    let bare = Plan {
        scene: None,
        ..Plan::default()
    };
    let bench = Bench::new(&bare);
    bench.refuses(
        &[],
        "take.mcap: no scene.toml attached, expected one or --scene FILE",
    );
    bench.refuses(
        &["--scene", "no.toml"],
        "no.toml: cannot read the scene: No such file",
    );
    fs::write(
        bench.path("typo.toml"),
        SCENE.replace("mass_g = 50", "mass_lb = 50"),
    )
    .unwrap();
    bench.refuses(
        &["--scene", "typo.toml"],
        "typo.toml:10:1: unknown key `mass_lb`, expected one of mass_g, mass_kg, density_kg_m3",
    );
    let two_balls = SCENE.replace(
        "[[surface]]",
        "[[body]]\nname = \"cue\"\nmass_g = 50\nshape = { kind = \"sphere\", radius_mm = 20 }\n[[surface]]",
    );
    fs::write(bench.path("other.toml"), two_balls).unwrap();
    bench.refuses(
        &["--scene", "other.toml"],
        "no topic /tracker/cue/pose, which body \"cue\" of the scene wants",
    );
    let broken = Plan {
        scene: Some("name = ".into()),
        ..Plan::default()
    };
    Bench::new(&broken).refuses(&[], "take.mcap#scene.toml:1:");
}

#[test]
fn files_that_are_no_recordings_are_refused() {
    let bench = Bench::new(&Plan::default());
    for (content, message) in [
        (&b""[..], "take.mcap: the file is empty"),
        (b"not at all an MCAP file", "take.mcap: not an MCAP file"),
    ] {
        fs::write(bench.path("take.mcap"), content).unwrap();
        bench.refuses(&[], message);
    }
    fs::remove_file(bench.path("take.mcap")).unwrap();
    bench.refuses(&[], "take.mcap: cannot read: No such file");
    fs::create_dir(bench.path("take.mcap")).unwrap();
    bench.refuses(&[], "take.mcap: is a folder, expected a recording");
}

#[test]
fn outputs_that_cannot_be_written_are_refused() {
    let bench = Bench::new(&Plan::default());
    for output in ["nowhere/x.mcap", "take.mcap/x.mcap"] {
        let ran = bench.enact(&["replay", "take.mcap", "-o", output]);
        ran.failed_with(&format!("{output}: cannot create"));
    }
    bench
        .enact(&["replay", "take.mcap", "-o", "./take.mcap"])
        .failed_with("the output would replace an input");
    let before = fs::read(bench.path("take.mcap")).unwrap();
    fs::write(bench.path("file"), "").unwrap();
    bench
        .enact(&["process", "take.mcap", "-o", "file"])
        .failed_with("file: cannot make the folder");
    assert_eq!(fs::read(bench.path("take.mcap")).unwrap(), before);
    assert_eq!(fs::read_dir(bench.folder.path()).unwrap().count(), 3);
}

/// A rename over a device replaces it, where the right is there.
#[cfg(unix)]
#[test]
fn outputs_of_all_commands_that_are_no_files_are_refused() {
    use std::os::unix::{fs::symlink, net::UnixListener};
    let bench = Bench::new(&Plan::default());
    let _socket = UnixListener::bind(bench.path("socket.csv")).unwrap();
    for name in [
        "device.mcap",
        "device.csv",
        "device.toml",
        "out/take.estimate.mcap",
    ] {
        symlink("/dev/null", bench.path(name)).unwrap();
    }
    let inertia = r#"<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>"#;
    let link = format!(r#"<link name="a"><inertial><mass value="1"/>{inertia}</inertial></link>"#);
    let robot = format!(r#"<robot name="arm">{link}</robot>"#);
    fs::write(bench.path("arm.urdf"), robot).unwrap();
    let before = fs::read_dir(bench.folder.path()).unwrap().count();
    for arguments in [
        &["replay", "take.mcap", "-o", "device.mcap"][..],
        &["process", "take.mcap", "-o", "out"],
        &["mark", "take.mcap", "--propose", "-o", "device.mcap"],
        &["sketch", "take.mcap", "-o", "device.csv"],
        &["sketch", "take.mcap", "-o", "socket.csv"],
    ] {
        let ran = bench.enact(arguments);
        ran.failed_with("is a device, a pipe or a socket");
    }
    bench
        .enact(&["scene", "from-urdf", "arm.urdf", "-o", "device.toml"])
        .failed_with("is there already");
    for name in [
        "device.mcap",
        "device.csv",
        "device.toml",
        "out/take.estimate.mcap",
    ] {
        let leads = fs::read_link(bench.path(name)).unwrap();
        assert_eq!(leads, Path::new("/dev/null"), "{name}");
    }
    use std::os::unix::fs::FileTypeExt;
    let kind = |path: &Path| fs::metadata(path).unwrap().file_type();
    assert!(kind(Path::new("/dev/null")).is_char_device());
    assert!(kind(&bench.path("socket.csv")).is_socket());
    assert_eq!(fs::read_dir(bench.folder.path()).unwrap().count(), before);
}

#[test]
fn a_full_disk_is_said_and_leaves_nothing() {
    let name = "a_full_disk_is_said_and_leaves_nothing";
    let bench = Bench::new(&Plan::default());
    // A file system of our own, of two pages, that ends with the shell.
    let script = r#"
        mount -t tmpfs -o size=8k tmpfs out || exit 42
        "$0" replay take.mcap -o out/x.mcap
        code=$?
        ls -A out
        exit $code
    "#;
    let output = Command::new("unshare")
        .args(["--mount", "sh", "-c", script])
        .arg(env!("CARGO_BIN_EXE_enact"))
        .current_dir(bench.folder.path())
        .output();
    match output {
        Ok(output) if output.status.code() == Some(1) => {
            let stderr = String::from_utf8_lossy(&output.stderr);
            assert!(stderr.contains("No space left on device"), "{stderr}");
            assert!(stderr.starts_with("error: out/x.mcap: cannot"), "{stderr}");
            assert_eq!(String::from_utf8_lossy(&output.stdout), "");
        }
        Ok(output) if output.status.code() == Some(42) => {
            skip(name, "no right to mount a small file system");
        }
        Ok(output) => panic!("{output:?}"),
        Err(error) => skip(name, &format!("unshare: {error}")),
    }
}

#[test]
fn a_full_stdout_is_an_error_and_a_closed_one_is_not() {
    let bench = Bench::new(&Plan::default());
    let inspect = |stdout: Stdio| {
        std::process::Command::new(env!("CARGO_BIN_EXE_enact"))
            .args(["inspect", "take.mcap"])
            .current_dir(bench.folder.path())
            .stdout(stdout)
            .stderr(Stdio::piped())
            .output()
            .unwrap()
    };
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let closed = inspect(writer.into());
    assert_eq!(closed.status.code(), Some(0));
    assert_eq!(String::from_utf8_lossy(&closed.stderr), "");
    let Ok(full) = fs::OpenOptions::new().write(true).open("/dev/full") else {
        let name = "a_full_stdout_is_an_error_and_a_closed_one_is_not";
        skip(name, "no /dev/full");
        return;
    };
    let full = inspect(full.into());
    assert_eq!(full.status.code(), Some(1));
    let stderr = String::from_utf8_lossy(&full.stderr);
    assert!(
        stderr.starts_with("error: ") && stderr.contains("No space left"),
        "{stderr}"
    );
}

#[test]
fn a_truncated_recording_is_used_as_far_as_it_goes_and_said() {
    let bench = Bench::new(&Plan::default());
    let whole = fs::read(bench.path("take.mcap")).unwrap();
    fs::write(bench.path("take.mcap"), &whole[..whole.len() - 20]).unwrap();
    let ran = bench.enact(&["replay", "take.mcap", "-o", "out/x.mcap"]);
    assert_eq!(ran.code, Some(3), "{}", ran.stderr);
    assert!(ran.stdout.contains("  lost: "), "{}", ran.stdout);
    assert!(bench.path("out/x.mcap").exists());
    let ran = bench.enact(&["inspect", "take.mcap"]);
    assert_eq!(ran.code, Some(3));
    assert!(ran.stdout.contains(", truncated\n"), "{}", ran.stdout);
    for cut in (0..whole.len()).step_by(whole.len() / 16) {
        fs::write(bench.path("take.mcap"), &whole[..cut]).unwrap();
        let ran = bench.enact(&["replay", "take.mcap", "-o", "out/x.mcap"]);
        assert!(matches!(ran.code, Some(1 | 3)), "{cut}: {}", ran.stderr);
        assert!(!ran.stderr.contains("panicked"), "{cut}: {}", ran.stderr);
    }
}

#[test]
fn replay_and_process_write_the_same_bytes() {
    let bench = Bench::new(&Plan::default());
    bench.enact(&["replay", "take.mcap"]).finished();
    bench
        .enact(&["replay", "take.mcap", "-o", "out/paced.mcap", "--rate", "8"])
        .finished();
    bench
        .enact(&["process", "take.mcap", "-o", "out/new"])
        .finished();
    let replayed = fs::read(bench.path("take.estimate.mcap")).unwrap();
    assert!(replayed.len() > 1000);
    for other in ["out/paced.mcap", "out/new/take.estimate.mcap"] {
        assert!(
            fs::read(bench.path(other)).unwrap() == replayed,
            "{other} differs"
        );
    }
}

#[test]
fn one_json_object_per_recording_says_everything() {
    let bench = Bench::new(&Plan::default());
    let ran = bench.enact(&[
        "replay",
        "take.mcap",
        "-o",
        "out/x.mcap",
        "--format",
        "ndjson",
    ]);
    // The motion is one that physics allows, so the estimate must say so.
    assert_eq!(ran.code, Some(0), "{}", ran.stdout);
    assert_eq!(ran.stderr, "");
    let [report] = ran.json().try_into().unwrap();
    assert_eq!(report["verdict"], "physical");
    let restitution = &report["parameters"]["bounce.restitution"]["value"];
    assert!((restitution.as_f64().unwrap() - 0.5).abs() < 1e-6);
    assert!((report["events"][1]["time_s"].as_f64().unwrap() - bounce_s()).abs() < 1e-6);
    assert_eq!(report["recording"], "take.mcap");
    assert_eq!(report["output"], "out/x.mcap");
    assert_eq!(report["samples"]["read"], 111);
    assert_eq!(report["events"].as_array().unwrap().len(), 3);
    assert_eq!(report["events"][1]["name"], "bounce");
    assert_eq!(report["events"][1]["kind"], "collision");
    assert_eq!(report["events"][1]["bodies"], serde_json::json!(["ball"]));
    assert_eq!(
        report["parameters"]["bounce.restitution"]["bounds"],
        serde_json::json!([0.0, 1.0])
    );
    for (pointer, is_right) in [
        ("/verdict", serde_json::Value::is_string as fn(&_) -> bool),
        ("/reason", serde_json::Value::is_string),
        ("/termination/kind", serde_json::Value::is_string),
        (
            "/termination/measured/0/value",
            serde_json::Value::is_number,
        ),
        (
            "/termination/measured/0/bound",
            serde_json::Value::is_number,
        ),
        ("/objective", serde_json::Value::is_number),
        ("/iterations", serde_json::Value::is_u64),
        ("/assignment_rounds", serde_json::Value::is_u64),
        ("/solve_seconds", serde_json::Value::is_f64),
        ("/phase_seconds/clean", serde_json::Value::is_f64),
        ("/events/1/time_s", serde_json::Value::is_f64),
        (
            "/events/1/time_is_determined",
            serde_json::Value::is_boolean,
        ),
        ("/events/1/gap_m", serde_json::Value::is_number),
        ("/events/1/gap_rad", serde_json::Value::is_number),
        ("/events/1/gap_m_s", serde_json::Value::is_number),
        ("/events/1/gap_rad_s", serde_json::Value::is_number),
        (
            "/parameters/bounce.restitution/value",
            serde_json::Value::is_f64,
        ),
        ("/residual_mm", serde_json::Value::is_f64),
        ("/residual_deg", serde_json::Value::is_f64),
        ("/undetermined", serde_json::Value::is_array),
        ("/physical_sd_s", serde_json::Value::is_number),
        ("/physical_is_determined", serde_json::Value::is_boolean),
        ("/samples/used", serde_json::Value::is_u64),
        ("/phase_seconds/verify", serde_json::Value::is_f64),
        ("/verification/deepest", serde_json::Value::is_null),
        ("/verification/wrong_features", serde_json::Value::is_array),
        (
            "/verification/single_shot/position_m",
            serde_json::Value::is_number,
        ),
        ("/settled", serde_json::Value::is_null),
        ("/samples/dropped", serde_json::Value::is_object),
    ] {
        let value = report.pointer(pointer);
        assert!(value.is_some_and(is_right), "{pointer}: {value:?}");
    }
    for pointer in ["/events/1/time_sd_s", "/parameters/bounce.restitution/sd"] {
        assert!(report.pointer(pointer).is_some(), "{pointer}");
    }
}

#[test]
fn infinite_bounds_are_null() {
    let free = Plan {
        scene: Some(SCENE.replace("\"bounce.restitution\"", "\"gravity.x\"\nupper = 1")),
        ..Plan::default()
    };
    let bench = Bench::new(&free);
    let ran = bench.enact(&["replay", "take.mcap", "--format", "ndjson"]);
    ran.finished();
    assert_eq!(
        ran.json()[0]["parameters"]["gravity.x"]["bounds"],
        serde_json::json!([null, 1.0])
    );
}

#[test]
fn one_failure_does_not_stop_the_others() {
    let bench = Bench::new(&Plan::default());
    Plan::default().write(&bench.path("last.mcap"));
    fs::write(bench.path("bad.mcap"), "").unwrap();
    let ran = bench.enact(&[
        "process",
        "take.mcap",
        "bad.mcap",
        "last.mcap",
        "-o",
        "out",
        "--format",
        "ndjson",
    ]);
    ran.failed_with("bad.mcap: the file is empty");
    let [first, second, third] = ran.json().try_into().unwrap();
    assert_eq!(first["output"], "out/take.estimate.mcap");
    assert_eq!(
        second,
        serde_json::json!({
            "schema": "enact.failure/1",
            "recording": "bad.mcap",
            "error": "bad.mcap: the file is empty",
            "diagnoses": []
        })
    );
    assert_eq!(third["output"], "out/last.estimate.mcap");
    // A recording of that name has that estimate, wherever it is; those of others say another name.
    fs::create_dir(bench.path("sub")).unwrap();
    Plan::default().write(&bench.path("sub/take.mcap"));
    let there = ["process", "sub/take.mcap", "-o", "sub"];
    bench.enact(&there).finished();
    assert_eq!(
        fs::read(bench.path("out/take.estimate.mcap")).unwrap(),
        fs::read(bench.path("sub/take.estimate.mcap")).unwrap()
    );
    bench
        .enact(&["process", "take.mcap", "sub/take.mcap", "-o", "out"])
        .failed_with("take.mcap and sub/take.mcap would both be written to out/take.estimate.mcap");
}

#[test]
fn the_text_account_is_aligned_and_names_what_matters() {
    let bench = Bench::new(&Plan::default());
    let ran = bench.enact(&["replay", "take.mcap", "-o", "out/x.mcap"]);
    ran.finished();
    let account = ran.stdout;
    assert!(account.starts_with("take.mcap: "), "{account}");
    for piece in [
        "a ball bounces once: 0.550 s acted, ",
        "event    kind",
        "\n  bounce   collision",
        "largest gaps  ",
        "\n  flight",
        "bounce.restitution",
        "[0, 1]",
        "samples   111 read, ",
        "checked   no overlap beyond 500 µm",
        "simulated from its first state it ends within < 1 µm, < 0.001°",
        "written   out/x.mcap\n",
    ] {
        assert!(account.contains(piece), "{piece:?} is not in\n{account}");
    }
    assert!(!account.contains('\u{1b}'), "{account}");
    assert!(account.lines().all(|line| line == line.trim_end()));
    let verbose = bench.enact(&["-v", "replay", "take.mcap", "-o", "out/x.mcap"]);
    assert!(verbose.stdout.contains("clean  "), "{}", verbose.stdout);
    assert!(verbose.stderr.contains("estimated"), "{}", verbose.stderr);
}

#[test]
fn inspect_says_what_is_in_a_recording() {
    let bench = Bench::new(&Plan::default());
    let ran = bench.enact(&["inspect", "take.mcap", "--format", "ndjson"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let [inspection] = ran.json().try_into().unwrap();
    assert_eq!(inspection["scene"], "a ball bounces once");
    assert_eq!(inspection["truncated"], false);
    assert_eq!(inspection["messages"], 114);
    let poses = &inspection["topics"][1];
    assert_eq!(poses["topic"], "/tracker/ball/pose");
    assert_eq!(poses["schema"], "foxglove.PoseInFrame");
    assert_eq!(poses["messages"], 111);
    assert!((poses["rate_hz"].as_f64().unwrap() - 200.0).abs() < 1e-6);
    assert_eq!(inspection["marks"].as_array().unwrap().len(), 3);
    let text = bench.enact(&["inspect", "take.mcap"]).stdout;
    for piece in ["scene: a ball bounces once", "200.0 Hz", "0.313 s"] {
        assert!(text.contains(piece), "{piece:?} is not in\n{text}");
    }
}

#[test]
fn usage_is_an_exit_code_of_its_own() {
    let bench = Bench::new(&Plan::default());
    for arguments in [
        &["replay"][..],
        &["replay", "take.mcap", "--rate", "-1"],
        &["replay", "take.mcap", "--format", "xml"],
        &["process", "take.mcap"],
        &["process", "-o", "out"],
        &["perform"],
        &[],
    ] {
        let ran = bench.enact(arguments);
        assert_eq!(ran.code, Some(2), "{arguments:?}: {}", ran.stderr);
        assert_eq!(ran.stdout, "");
    }
    let help = bench.enact(&["--help"]);
    assert_eq!(help.code, Some(0));
    assert!(help.stdout.contains("3 finished, but data were lost"));
}

#[test]
fn completions_know_the_commands() {
    let bench = Bench::new(&Plan::default());
    for shell in ["bash", "zsh", "fish"] {
        let ran = bench.enact(&["completion", shell]);
        assert_eq!(ran.code, Some(0));
        assert!(ran.stdout.contains("inspect") && ran.stdout.contains("replay"));
    }
}

#[test]
fn readings_that_are_no_poses_are_counted_not_used() {
    let bench = Bench::new(&Plan::default());
    let path = bench.path("take.mcap");
    let mut writer = RecordingWriter::create(&path).unwrap();
    writer
        .attach("scene.toml", "application/toml", SCENE.as_bytes())
        .unwrap();
    for i in 0..=110 {
        let time_s = f64::from(i) * 0.005;
        let mut sample = PoseSample::from_pose(at(time_s), &pose(time_s));
        if i % 50 == 7 {
            sample.position_m = Vector3::new(f64::NAN, 0.0, 0.0);
        }
        writer
            .pose("/tracker/ball/pose", "world", at(time_s), &sample)
            .unwrap();
    }
    for time_s in [0.0, bounce_s(), 0.55] {
        let mark = Mark {
            stamp: at(time_s),
            event: None,
        };
        writer.mark("/marks", at(0.6), &mark).unwrap();
    }
    writer.finish().unwrap();
    let ran = bench.enact(&["replay", "take.mcap", "--format", "ndjson"]);
    ran.finished();
    assert_eq!(ran.json()[0]["samples"]["dropped"]["not_finite"], 3);
}
