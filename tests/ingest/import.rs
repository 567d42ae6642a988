//! `enact import` from outside: tables of many programs become recordings that are estimated, and what the
//! data show of a wrong guess is said.

mod captured;
mod controllers;
mod said;

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use enact::config::scene_from_toml;
use enact::ingest::Recording;
use enact::motion::{PoseSample, TakeEvent};
use nalgebra::{UnitQuaternion, Vector3};
use tempfile::TempDir;

const SCENE: &str = r#"
name = "a ball is thrown and bounces"

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
surface = "table"
restitution = 0.5

[[event]]
name = "catch"
kind = "end"

[[free]]
quantity = "bounce.restitution"
"#;

const GRAVITY_M_S2: f64 = 9.80665;
const RATE_HZ: f64 = 200.0;
const BOUNCE_S: f64 = 0.312_9;

/// A drop from 0.48 m above the ball's lowest place, and half the speed back: 111 samples.
fn truth() -> Vec<PoseSample> {
    let bounce_s = (2.0 * 0.48 / GRAVITY_M_S2).sqrt();
    assert!((bounce_s - BOUNCE_S).abs() < 1e-3);
    let sample = |index: i32| {
        let time_s = f64::from(index) / RATE_HZ;
        let height_m = if time_s < bounce_s {
            0.5 - 0.5 * GRAVITY_M_S2 * time_s * time_s
        } else {
            let since_s = time_s - bounce_s;
            let up_m_s = 0.5 * GRAVITY_M_S2 * bounce_s;
            0.02 + up_m_s * since_s - 0.5 * GRAVITY_M_S2 * since_s * since_s
        };
        let q = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, 0.2, 2.0 * time_s));
        let stamp = enact::motion::Stamp(i64::from(index) * 5_000_000);
        let position_m = Vector3::new(0.1 + 0.4 * time_s, -0.2, height_m);
        PoseSample::new(stamp, position_m, [q.i, q.j, q.k, q.w])
    };
    (0..111).map(sample).collect()
}

/// Rows of a table with a line per sample.
fn rows(line: impl Fn(usize, &PoseSample) -> String) -> String {
    let truth = truth();
    let lines = truth.iter().enumerate().map(|(index, of)| line(index, of));
    lines.map(|line| line + "\n").collect()
}

fn plain_csv() -> String {
    let rows = rows(|_, of| {
        let ([qx, qy, qz, qw], p) = (of.quaternion_xyzw, of.position_m);
        format!(
            "{qw},{qx},{qy},{qz},{},{},{},{}",
            p.z,
            p.y,
            p.x,
            of.stamp.seconds_since(enact::motion::Stamp(0))
        )
    });
    format!("qw,qx,qy,qz,z,y,x,t\n{rows}")
}

/// Motive: y up, so that our (x, y, z) is its (x, z, −y), and its world turns our bodies' axes back.
fn motive_csv() -> String {
    let back = UnitQuaternion::from_scaled_axis(Vector3::x() * -std::f64::consts::FRAC_PI_2);
    let rows = rows(|index, of| {
        let [qx, qy, qz, qw] = of.quaternion_xyzw;
        let q = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(qw, qx, qy, qz));
        let (q, p) = (back * q, back * of.position_m);
        let time_s = index as f64 / RATE_HZ;
        format!(
            "{index},{time_s:.6},{},{},{},{},{},{},{}",
            q.i, q.j, q.k, q.w, p.x, p.y, p.z
        )
    });
    format!(
        "Format Version,1.23,Take Name,drop,Export Frame Rate,200.000000,Rotation Type,Quaternion,Length Units,Meters,Coordinate Space,Global\n\n\
         ,,{of}\n,,{name}\n,,{id}\n,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position\n\
         Frame,Time (Seconds),X,Y,Z,W,X,Y,Z\n{rows}",
        of = ["Rigid Body"; 7].join(","),
        name = ["Ball"; 7].join(","),
        id = ["1"; 7].join(","),
    )
}

fn vicon_csv() -> String {
    let rows = rows(|index, of| {
        let ([qx, qy, qz, qw], p) = (of.quaternion_xyzw, of.position_m * 1e3);
        format!(
            "{},0,{qx},{qy},{qz},{qw},{},{},{}",
            index + 7,
            p.x,
            p.y,
            p.z
        )
    });
    format!(
        "Objects\n200\n,,Ball:Ball,,,,,,\nFrame,Sub Frame,RX,RY,RZ,RW,TX,TY,TZ\n,,,,,,mm,mm,mm\n{rows}"
    )
}

fn tum_txt() -> String {
    rows(|index, of| {
        let ([qx, qy, qz, qw], p) = (of.quaternion_xyzw, of.position_m);
        let time_s = index as f64 / RATE_HZ;
        format!("{time_s:.6} {} {} {} {qx} {qy} {qz} {qw}", p.x, p.y, p.z)
    })
}

fn euroc_csv() -> String {
    let rows = rows(|_, of| {
        let ([qx, qy, qz, qw], p) = (of.quaternion_xyzw, of.position_m);
        let ns = of.stamp.0 + 1_403_636_580_838_555_574;
        format!("{ns},{},{},{},{qw},{qx},{qy},{qz}", p.x, p.y, p.z)
    });
    format!(
        "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []\n{rows}"
    )
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
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            fs::write(folder.path().join(name), text).unwrap();
        }
        fs::write(folder.path().join("scene.toml"), SCENE).unwrap();
        Self { folder }
    }

    fn enact(&self, arguments: &[&str]) -> Ran {
        let output = Command::cargo_bin("enact")
            .unwrap()
            .current_dir(self.folder.path())
            .env_remove("RUST_LOG")
            .args(arguments)
            .output()
            .unwrap();
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

    fn poses(&self, name: &str) -> Vec<PoseSample> {
        let recording = Recording::open(&self.folder.path().join(name)).unwrap();
        let take = recording.take(&scene_from_toml(SCENE).unwrap()).unwrap();
        let poses = take.events.into_iter().filter_map(|event| match event {
            TakeEvent::Pose { sample, .. } => Some(sample),
            TakeEvent::Mark(_) => None,
        });
        poses.collect()
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        Path::new(self.folder.path()).join(name)
    }
}

#[test]
fn every_table_becomes_the_same_recording_without_a_flag() {
    for (name, text) in [
        ("ball.csv", plain_csv()),
        ("motive.csv", motive_csv()),
        ("vicon.csv", vicon_csv()),
        ("tum.txt", tum_txt()),
        ("euroc.csv", euroc_csv()),
    ] {
        let bench = Bench::new(&[(name, &text)]);
        let arguments = ["import", name, "--scene", "scene.toml", "-o", "x.mcap"];
        let ran = bench.enact(&arguments);
        assert_eq!(ran.code, Some(0), "{name}: {}{}", ran.stdout, ran.stderr);
        assert!(
            ran.stdout.contains("axes and units agree"),
            "{name}: {}",
            ran.stdout
        );
        let found = bench.poses("x.mcap");
        let truth = truth();
        assert_eq!(found.len(), truth.len(), "{name}");
        let origin = found[0].stamp.0;
        for (found, truth) in found.iter().zip(&truth) {
            assert_eq!(found.stamp.0 - origin, truth.stamp.0, "{name}");
            assert!(
                (found.position_m - truth.position_m).norm() < 1e-9,
                "{name}: {found:?}"
            );
            let parts = found.quaternion_xyzw.iter().zip(truth.quaternion_xyzw);
            let cosine: f64 = parts.map(|(a, b)| a * b).sum();
            assert!(1.0 - cosine.abs() < 1e-12, "{name}: {found:?}");
        }
        // It is estimated with what is attached and nothing else.
        if name == "euroc.csv" {
            let report = bench.json(&["replay", "x.mcap", "-o", "out.mcap"]);
            assert_eq!(report["verdict"], "physical", "{name}");
        }
    }
}

#[test]
fn a_wrong_guess_is_seen_by_what_falls_and_said_with_the_flag() {
    let millimetres = {
        let rows = rows(|index, of| {
            let ([qx, qy, qz, qw], p) = (of.quaternion_xyzw, of.position_m * 1e3);
            format!(
                "{},{},{},{},{qx},{qy},{qz},{qw}",
                index as f64 / RATE_HZ,
                p.x,
                p.y,
                p.z
            )
        });
        format!("t,x,y,z,qx,qy,qz,qw\n{rows}")
    };
    // Without Motive's head nothing says that y is up.
    let motive = motive_csv();
    let (_, rows) = motive.split_once("W,X,Y,Z\n").unwrap();
    let y_up = format!("frame,t,qx,qy,qz,qw,x,y,z\n{rows}");
    for (text, advice, flags) in [
        (
            &millimetres,
            "positions are in millimetres, not in metres; expected --length-unit mm",
            ["--length-unit", "mm"],
        ),
        (
            &y_up,
            "falls along −y as read with z-up; its world is right-handed, y up, metres: glTF, Maya: expected --from y-up",
            ["--from", "y-up"],
        ),
    ] {
        let bench = Bench::new(&[("ball.csv", text)]);
        let arguments = ["import", "ball.csv", "-o", "x.mcap"];
        let ran = bench.enact(&arguments);
        assert_eq!(ran.code, Some(3), "{}{}", ran.stdout, ran.stderr);
        assert!(ran.stdout.contains(advice), "{}", ran.stdout);
        let ran = bench.enact(&[&arguments[..], &flags].concat());
        assert_eq!(ran.code, Some(0), "{}{}", ran.stdout, ran.stderr);
        let found = bench.poses("x.mcap");
        assert!((found[0].position_m - truth()[0].position_m).norm() < 1e-9);
    }
    // A preset that is wrong for a file is seen as well.
    let bench = Bench::new(&[("ball.csv", &plain_csv())]);
    let ran = bench.enact(&["import", "ball.csv", "--from", "openvr", "-o", "x.mcap"]);
    assert_eq!(ran.code, Some(3), "{}", ran.stdout);
    assert!(
        ran.stdout.contains("expected --from z-up"),
        "{}",
        ran.stdout
    );
}

#[test]
fn points_alone_are_points_and_stdin_is_a_file() {
    let rows = rows(|index, of| {
        let p = of.position_m;
        format!("{},{},{},{}", index as f64 / RATE_HZ, p.x, p.y, p.z)
    });
    let bench = Bench::new(&[("marker.csv", &format!("t,x,y,z\n{rows}"))]);
    let ran = bench.enact(&["import", "marker.csv", "-o", "plain.mcap"]);
    assert_eq!(ran.code, Some(0), "{}{}", ran.stdout, ran.stderr);
    for said in [
        "points are taken",
        "/tracker/marker/point",
        "axes and units agree",
    ] {
        assert!(ran.stdout.contains(said), "{said}: {}", ran.stdout);
    }
    let listed = bench.json(&["inspect", "plain.mcap"]);
    let schema = &listed["topics"][0]["schema"];
    assert!(
        schema
            .as_str()
            .unwrap()
            .starts_with("foxglove.Point3InFrame"),
        "{listed}"
    );
    // A scene whose track sees a point is estimated of it; its bounce as it was.
    let features = "features_mm = { south = [0, 0, -20] }\n";
    let track = "[[body.track]]\ntopic = \"/ball\"\nsees = \"point\"\npoint = \"centre\"\n";
    let scene = SCENE.replace(features, &format!("{features}{track}"));
    fs::write(bench.path("points.toml"), scene).unwrap();
    let cli = [
        "import",
        "-",
        "--scene",
        "points.toml",
        "-o",
        "x.mcap",
        "--mark",
        "0:release",
    ];
    let marks = ["--mark", "0.3129:bounce", "--mark", "0.55:catch"];
    let ran = Command::cargo_bin("enact")
        .unwrap()
        .current_dir(bench.folder.path())
        .args(cli)
        .args(marks)
        .write_stdin(fs::read(bench.path("marker.csv")).unwrap())
        .output()
        .unwrap();
    assert_eq!(
        ran.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&ran.stderr)
    );
    let report = bench.json(&["replay", "x.mcap", "-o", "out.mcap"]);
    assert_eq!(report["verdict"], "physical", "{report}");
    let restitution = report["parameters"]["bounce.restitution"]["value"]
        .as_f64()
        .unwrap();
    assert!((restitution - 0.5).abs() < 0.01, "{restitution}");
    // Where a scene wants poses, points are not silently taken for such.
    let wants = [
        "import",
        "marker.csv",
        "--scene",
        "scene.toml",
        "-o",
        "y.mcap",
    ];
    let ran = bench.enact(&[&wants[..], &marks].concat());
    assert_eq!(ran.code, Some(3), "{}{}", ran.stdout, ran.stderr);
    assert!(ran.stdout.contains("sees = \"point\""), "{}", ran.stdout);
}

#[test]
fn positions_too_large_for_a_room_are_doubted() {
    // Carried about, so that nothing falls.
    let text = rows(|index, _| {
        let s = index as f64 / RATE_HZ;
        format!(
            "{s},{},{},1000,0,0,0,1",
            40_000.0 * s,
            500.0 * (3.0 * s).sin()
        )
    });
    let bench = Bench::new(&[("hand.csv", &format!("t,x,y,z,qx,qy,qz,qw\n{text}"))]);
    let ran = bench.enact(&["import", "hand.csv", "-o", "x.mcap"]);
    assert_eq!(ran.code, Some(3), "{}", ran.stdout);
    assert!(
        ran.stdout
            .contains("positions span 22000 m, taken in metres"),
        "{}",
        ran.stdout
    );
    let ran = bench.enact(&["import", "hand.csv", "-o", "x.mcap", "--length-unit", "mm"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stdout);
}

#[test]
fn a_take_is_cut_out_of_a_table_and_out_of_a_recording() {
    let bench = Bench::new(&[("ball.csv", &plain_csv())]);
    let cut = ["--start", "0.1", "--end", "0.4"];
    let arguments = [
        &[
            "import",
            "ball.csv",
            "-o",
            "a.mcap",
            "--mark",
            "0.3129:bounce",
            "--scene",
            "scene.toml",
        ],
        &cut[..],
    ]
    .concat();
    let json = bench.json(&arguments);
    assert_eq!(
        (&json["left_out"], &json["marks"]),
        (&50.into(), &1.into()),
        "{json}"
    );
    assert_eq!(json["bodies"][0]["poses"], 61);
    let listed = bench.json(&["inspect", "a.mcap"]);
    let time_s = listed["marks"][0]["time_s"].as_f64().unwrap();
    assert!((time_s - 0.2129).abs() < 1e-9, "{listed}");
    // Of a whole recording without a scene, with that added.
    let json = bench.json(&["import", "ball.csv", "-o", "whole.mcap"]);
    assert_eq!(json["bodies"][0]["topic"], "/tracker/ball/pose");
    let whole = fs::read(bench.path("whole.mcap")).unwrap();
    let arguments = [
        "import",
        "whole.mcap",
        "-o",
        "b.mcap",
        "--scene",
        "scene.toml",
    ];
    let json = bench.json(&[&arguments, &cut[..]].concat());
    assert_eq!(
        (&json["copied"], &json["left_out"]),
        (&61.into(), &50.into()),
        "{json}"
    );
    assert_eq!(bench.poses("b.mcap"), bench.poses("a.mcap"));
    assert_eq!(fs::read(bench.path("whole.mcap")).unwrap(), whole);
    let listed = bench.json(&["inspect", "b.mcap"]);
    assert_eq!(listed["scene"], "a ball is thrown and bounces");
    // A scene that takes the place of another does so.
    let other = SCENE.replace("a ball is thrown and bounces", "another");
    fs::write(bench.path("other.toml"), other).unwrap();
    bench.json(&["import", "b.mcap", "-o", "c.mcap", "--scene", "other.toml"]);
    let listed = bench.json(&["inspect", "c.mcap"]);
    assert_eq!(
        (
            &listed["scene"],
            listed["attachments"].as_array().unwrap().len()
        ),
        (&"another".into(), 1)
    );
}

#[test]
fn several_files_are_several_bodies() {
    let bench = Bench::new(&[("cup.csv", &plain_csv()), ("my hand.csv", &tum_txt())]);
    let topics = |more: &[&str]| -> Vec<String> {
        let json =
            bench.json(&[&["import", "cup.csv", "my hand.csv", "-o", "x.mcap"], more].concat());
        let bodies = json["bodies"].as_array().unwrap().iter();
        bodies
            .map(|body| body["topic"].as_str().unwrap().to_owned())
            .collect()
    };
    assert_eq!(topics(&[]), ["/tracker/cup/pose", "/tracker/my_hand/pose"]);
    assert_eq!(
        topics(&["--topic", "my hand=/h", "--topic", "/c"]),
        ["/c", "/h"]
    );
    let listed = bench.json(&["inspect", "x.mcap"]);
    assert_eq!(listed["poses"][1]["topic"], "/h");
    assert_eq!(listed["poses"][1]["poses"], 111);
    // With a scene of one body it is to be said which is which.
    let ran = bench.enact(&[
        "import",
        "cup.csv",
        "my hand.csv",
        "-o",
        "y.mcap",
        "--scene",
        "scene.toml",
    ]);
    assert_eq!(ran.code, Some(1));
    assert!(
        ran.stderr.contains("which body of the scene is \"cup\"?"),
        "{}",
        ran.stderr
    );
    assert!(!bench.path("y.mcap").exists());
}

#[test]
fn what_cannot_be_imported_is_refused_with_what_to_do() {
    let bench = Bench::new(&[
        ("ros1.bag", "#ROSBAG V2.0\n"),
        ("ros2.db3", "SQLite format 3\0"),
        ("man.bvh", "HIERARCHY\nROOT Hips\n"),
        ("empty.csv", ""),
        (
            "bad.csv",
            "t,x,y,z,qx,qy,qz,qw\n0,1,2,3,0,0,0,1\n0.01,1,2,oops,0,0,0,1\n",
        ),
        ("ball.csv", &plain_csv()),
    ]);
    fs::write(bench.path("markers.c3d"), [2, 0x50, 0xff, 0xfe, 0]).unwrap();
    fs::write(bench.path("picture.png"), [0x89, b'P', 0xff, 0]).unwrap();
    for (input, code, message) in [
        (
            "ros1.bag",
            1,
            "rosbags-convert --src ros1.bag --dst ros1_mcap --dst-storage mcap",
        ),
        (
            "ros2.db3",
            1,
            "rosbags-convert --src . --dst ros2_mcap --dst-storage mcap",
        ),
        ("man.bvh", 1, "is BVH"),
        ("markers.c3d", 1, "is C3D"),
        ("picture.png", 1, "neither text nor MCAP"),
        ("empty.csv", 1, "is empty"),
        ("bad.csv", 1, "bad.csv:3: column 4: \"oops\" is no number"),
        ("absent.csv", 1, "absent.csv: cannot read"),
    ] {
        let ran = bench.enact(&["import", input, "-o", "x.mcap"]);
        assert_eq!(ran.code, Some(code), "{input}: {}", ran.stdout);
        assert!(ran.stderr.contains(message), "{input}: {}", ran.stderr);
        assert!(!bench.path("x.mcap").exists());
    }
    for (arguments, code, message) in [
        (&["ball.csv", "-o", "ball.csv"][..], 1, "would replace"),
        (
            &["ball.csv", "-o", "x.mcap", "--start", "3"],
            1,
            "no pose is within --start and --end",
        ),
        (
            &[
                "ball.csv",
                "-o",
                "x.mcap",
                "--mark",
                "0.3:jump",
                "--scene",
                "scene.toml",
            ],
            1,
            "no event \"jump\"",
        ),
        (
            &["ball.csv", "-o", "x.mcap", "--from", "sideways"],
            2,
            "motive-y-up",
        ),
        (
            &["ball.csv", "-o", "x.mcap", "--time-unit", "hours"],
            2,
            "expected s, ms, us, 100ns, ns or frame",
        ),
        (&["ball.csv"], 2, "--output"),
    ] {
        let ran = bench.enact(&[&["import"], arguments].concat());
        assert_eq!(ran.code, Some(code), "{arguments:?}: {}", ran.stderr);
        assert!(
            ran.stderr.contains(message),
            "{arguments:?}: {}",
            ran.stderr
        );
        assert!(!bench.path("x.mcap").exists());
    }
    assert_eq!(
        fs::read_to_string(bench.path("ball.csv")).unwrap(),
        plain_csv()
    );
}

#[test]
fn inspect_says_what_poses_are_like() {
    let bench = Bench::new(&[("ball.csv", &plain_csv())]);
    let lines = rows(|index, of| {
        let p = of.position_m;
        format!(
            "{},{},{},{},0,0,0,1.25",
            index as f64 / RATE_HZ,
            p.x,
            p.y,
            p.z
        )
    });
    fs::write(
        bench.path("norm.csv"),
        format!("t,x,y,z,qx,qy,qz,qw\n{lines}"),
    )
    .unwrap();
    let ran = bench.enact(&["import", "norm.csv", "-o", "norm.mcap"]);
    assert_eq!(ran.code, Some(3), "{}", ran.stdout);
    assert!(
        ran.stdout
            .contains("111 of 111 quaternions have a norm other than 1, the first 1.250")
    );
    bench.json(&["import", "ball.csv", "-o", "ball.mcap"]);
    let json = bench.json(&["inspect", "ball.mcap", "--scene", "scene.toml"]);
    assert_eq!(json["scene"], "a ball is thrown and bounces");
    assert!(json["complaint"].is_null(), "{json}");
    let poses = &json["poses"][0];
    assert_eq!(
        (&poses["topic"], &poses["poses"]),
        (&"/tracker/ball/pose".into(), &111.into())
    );
    assert_eq!(poses["frame_ids"], serde_json::json!(["world"]));
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let truth = truth();
    for axis in 0..3 {
        let along = || truth.iter().map(|of| of.position_m[axis]);
        let (least, greatest) = (
            along().fold(f64::MAX, f64::min),
            along().fold(f64::MIN, f64::max),
        );
        let extent = &poses["extent_m"][axis];
        assert!((number(&extent[0]) - least).abs() < 1e-12, "{poses}");
        assert!((number(&extent[1]) - greatest).abs() < 1e-12, "{poses}");
    }
    assert!((number(&poses["norms"][0]) - 1.0).abs() < 1e-9);
    let norm = bench.json(&["inspect", "norm.mcap"]);
    assert_eq!(number(&norm["poses"][0]["norms"][1]), 1.25);
    assert!(
        norm["complaint"]
            .as_str()
            .unwrap()
            .contains("expected one or --scene FILE")
    );
    let text = bench.enact(&["inspect", "norm.mcap"]).stdout;
    for piece in ["x [m]", "-0.200 to -0.200", "1.2500 to 1.2500", "world"] {
        assert!(text.contains(piece), "{text}");
    }
    let ran = bench.enact(&["inspect", "ball.mcap", "--scene", "absent.toml"]);
    assert_eq!(ran.code, Some(1));
    assert!(
        ran.stderr.contains("absent.toml: cannot read the scene"),
        "{}",
        ran.stderr
    );
}
