//! A body may be given in any frame: the motion that is found is the same, and its poses are those of the frame. And
//! scenes that `scene new` makes can be acted and estimated.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use enact::config::scene_from_toml;
use enact::math::Pose;
use enact::motion::{LinkIndex, Touching};
use enact::physics::State;
use enact_tools::perform::{Acting, perform, recording, simulate};
use nalgebra::{Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde_json::Value;

fn ran(folder: &Path, arguments: &[&str], code: i32) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_enact"));
    command.current_dir(folder).env_remove("RUST_LOG");
    let output = command.args(arguments).output().expect("it runs");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let out = String::from_utf8(output.stdout).expect("UTF-8");
    assert_eq!(
        output.status.code(),
        Some(code),
        "{arguments:?}: {said}{out}"
    );
    out
}

fn list(numbers: impl IntoIterator<Item = f64>) -> String {
    let numbers: Vec<String> = numbers.into_iter().map(|x| x.to_string()).collect();
    format!("[{}]", numbers.join(", "))
}

fn wxyz(turn: &UnitQuaternion<f64>) -> String {
    list([turn.w, turn.i, turn.j, turn.k])
}

/// The scene of the pencil with the pencil given in another frame.
fn pencil_in(given_from_own: &Pose) -> String {
    let plain = include_str!("../../config/pencil_tip.toml");
    let point = |mm: [f64; 3]| {
        let point_m = given_from_own * Point3::from(Vector3::from(mm) / 1e3);
        list((point_m.coords * 1e3).iter().copied())
    };
    let half = UnitQuaternion::new_normalize(Quaternion::new(0.5, 0.5, 0.5, 0.5));
    let goal = UnitQuaternion::new_normalize(Quaternion::new(0.944, 0.016, 0.032, 0.328));
    let turned = given_from_own.rotation;
    let changes = [
        (
            "radius_mm = 3.75 }".to_owned(),
            format!(
                "radius_mm = 3.75, position_mm = {}, orientation_wxyz = {} }}",
                point([0.0; 3]),
                wxyz(&turned)
            ),
        ),
        (
            "tracker = { position_mm = [12, -5, 40], orientation_wxyz = [0.5, 0.5, 0.5, 0.5] }"
                .into(),
            format!(
                "tracker = {{ position_mm = {}, orientation_wxyz = {} }}",
                point([12.0, -5.0, 40.0]),
                wxyz(&(turned * half))
            ),
        ),
        (
            "features_mm = { tip = [0, 0, -95], eraser = [0, 0, 95] }".into(),
            format!(
                "features_mm = {{ tip = {}, eraser = {} }}",
                point([0.0, 0.0, -95.0]),
                point([0.0, 0.0, 95.0])
            ),
        ),
        (
            "orientation_wxyz = [0.944, 0.016, 0.032, 0.328]".into(),
            format!("orientation_wxyz = {}", wxyz(&(goal * turned.inverse()))),
        ),
    ];
    let mut text = plain.to_owned();
    for (from, to) in changes {
        assert!(text.contains(&from), "{from}");
        text = text.replace(&from, &to);
    }
    text
}

/// Poses of the estimate and of the performance, by what they are and when.
fn poses(csv: &str) -> Vec<(String, Pose)> {
    let rows = csv.lines().filter(|line| !line.starts_with('#')).skip(1);
    let rows = rows.map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |at: usize| cells[at].parse::<f64>().expect("a number");
        let turn = Quaternion::new(number(8), number(9), number(10), number(11));
        let pose = Pose::from_parts(
            Translation3::new(number(5), number(6), number(7)),
            UnitQuaternion::new_normalize(turn),
        );
        (format!("{} {}", cells[3], cells[1]), pose)
    });
    rows.collect()
}

#[test]
fn the_motion_does_not_depend_on_the_frame_and_its_poses_are_of_that() {
    let folder = tempfile::tempdir().expect("a folder");
    let take = concat!(env!("CARGO_MANIFEST_DIR"), "/recordings/pencil_tip.mcap");
    // From the tip, with axes that are no principal ones.
    let turn = UnitQuaternion::from_euler_angles(0.4, -0.7, 1.1);
    let given_from_own = Pose::from_parts((turn * Vector3::new(0.0, 0.0, 0.095)).into(), turn);
    let estimate = |name: &str, scene: String| {
        let [scene_file, output, csv] = ["toml", "mcap", "csv"].map(|of| format!("{name}.{of}"));
        fs::write(folder.path().join(&scene_file), scene).expect("a file");
        let replay = [
            "replay",
            take,
            "--scene",
            &scene_file,
            "-o",
            &output,
            "--format",
            "ndjson",
        ];
        let report: Value = serde_json::from_str(&ran(folder.path(), &replay, 0)).expect("JSON");
        let export = [
            "export", &output, "--to", "csv", "-o", &csv, "--ghost", "--fps", "240",
        ];
        ran(folder.path(), &export, 0);
        let text = fs::read_to_string(folder.path().join(csv)).expect("a table");
        (report, poses(&text))
    };
    let (plain, plain_poses) =
        estimate("plain", include_str!("../../config/pencil_tip.toml").into());
    let (moved, moved_poses) = estimate("moved", pencil_in(&given_from_own));
    assert_eq!(plain["verdict"], "physical");
    assert_eq!(moved["verdict"], "physical");
    for (a, b) in plain["events"]
        .as_array()
        .unwrap()
        .iter()
        .zip(moved["events"].as_array().unwrap())
    {
        let [a, b] = [a, b].map(|of| of["time_s"].as_f64().expect("a time"));
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
    let [a, b] = [&plain, &moved].map(|of| of["objective"].as_f64().expect("a number"));
    assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
    assert!(plain_poses.len() > 300, "{}", plain_poses.len());
    let own_from_given = given_from_own.inverse();
    let mut compared = [0, 0];
    for (when, own) in &plain_poses {
        let Some((_, given)) = moved_poses.iter().find(|(other, _)| other == when) else {
            // An event's stamp may be rounded to the next nanosecond.
            continue;
        };
        if when.starts_with("simulated") {
            continue;
        }
        compared[usize::from(when.starts_with("acted"))] += 1;
        let expected = own * own_from_given;
        let apart_m = (expected.translation.vector - given.translation.vector).norm();
        assert!(apart_m < 1e-5, "{when}: {apart_m} m");
        let turn_rad = expected.rotation.angle_to(&given.rotation);
        assert!(turn_rad < 1e-4, "{when}: {turn_rad} rad");
    }
    assert!(compared.iter().all(|count| *count > 100), "{compared:?}");
}

/// The mug of nine obstacles as one that is turned: the pencil flies in, and is simulated to rest within.
#[test]
fn a_mug_is_one_obstacle_with_a_cavity() {
    let folder = tempfile::tempdir().expect("a folder");
    let take = concat!(env!("CARGO_MANIFEST_DIR"), "/recordings/pencil_tip.mcap");
    let plain = include_str!("../../config/pencil_tip.toml");
    let from = plain.find("[[obstacle]]").expect("obstacles");
    let to = plain.find("[[event]]").expect("events");
    let scene = |wall: &str| {
        format!(
            "{}[[obstacle]]\nname = \"mug\"\nposition_mm = [0, 0, 0]\nshape = {{ kind = \"revolution\", \
             profile_mm = [[0, 0], [44, 0], [44, 95]]{wall} }}\n{}",
            &plain[..from],
            &plain[to..]
        )
    };
    let estimate = |name: &str, scene: String, code: i32| -> Value {
        let [scene_file, output] = ["toml", "mcap"].map(|of| format!("{name}.{of}"));
        fs::write(folder.path().join(&scene_file), scene).expect("a file");
        let replay = [
            "replay",
            take,
            "--scene",
            &scene_file,
            "-o",
            &output,
            "--format",
            "ndjson",
        ];
        serde_json::from_str(&ran(folder.path(), &replay, code)).expect("JSON")
    };
    let nine = estimate("nine", plain.into(), 0);
    let one = estimate("one", scene(", wall_mm = 4"), 0);
    assert_eq!(one["verdict"], "physical");
    assert_eq!(one["objective"], nine["objective"]);
    assert_eq!(one["settled"]["at_rest"], true, "{one}");
    // A filled one is in the way.
    let filled = estimate("filled", scene(""), 3);
    assert_eq!(filled["doubts"][0]["quantity"], "overlap", "{filled}");
}

/// The scene of the chain with its rods given in other frames: the first and the last in one, the middle in another.
fn chain_in(ends: &Pose, middle: &Pose) -> String {
    let mut text = include_str!("../../config/chain.toml").to_owned();
    let mut change = |from: &str, to: String| {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, &to, 1);
    };
    let point = |frame: &Pose, z_mm: f64| {
        let point_m = frame * Point3::new(0.0, 0.0, z_mm / 1e3);
        list((point_m.coords * 1e3).iter().copied())
    };
    let rod = "length_mm = 200.0, radius_mm = 5 }";
    for frame in [ends, middle, ends] {
        let at = format!(
            "length_mm = 200, radius_mm = 5, position_mm = {}, orientation_wxyz = {} }}",
            point(frame, 0.0),
            wxyz(&frame.rotation)
        );
        change(rod, at);
    }
    change(
        "tracker = { position_mm = [0, 0, 0.0] }",
        format!("tracker = {{ position_mm = {} }}", point(ends, 0.0)),
    );
    for (parent, child) in [(ends, middle), (middle, ends)] {
        let axes =
            [Vector3::x(), Vector3::y()].map(|axis| list((parent.rotation * axis).iter().copied()));
        change(
            "axes = [[1, 0, 0], [0, 1, 0]]",
            format!("axes = [{}, {}]", axes[0], axes[1]),
        );
        change(
            "parent_at_mm = [0, 0, -100.0]",
            format!("parent_at_mm = {}", point(parent, -100.0)),
        );
        let turn = parent.rotation * child.rotation.inverse();
        let at = format!(
            "child_at_mm = {}\nchild_orientation_wxyz = {}",
            point(child, 100.0),
            wxyz(&turn)
        );
        change("child_at_mm = [0, 0, 100.0]", at);
    }
    let given =
        "[0.9707421999082694, -0.09680899047403699, -0.21601409352873766, -0.040317639782225044]";
    let start = Quaternion::new(
        0.9707421999082694,
        -0.09680899047403699,
        -0.21601409352873766,
        -0.040317639782225044,
    );
    let start = UnitQuaternion::new_normalize(start) * ends.rotation.inverse();
    change(given, wxyz(&start));
    change(
        "point_mm = [0, 0, -100.0]",
        format!("point_mm = {}", point(ends, -100.0)),
    );
    text
}

#[test]
fn joined_bodies_move_alike_in_whatever_frames_they_are_given() {
    let folder = tempfile::tempdir().expect("a folder");
    let take = concat!(env!("CARGO_MANIFEST_DIR"), "/recordings/chain.mcap");
    let ends = Pose::from_parts(
        Translation3::new(0.02, -0.01, 0.1),
        UnitQuaternion::from_euler_angles(0.3, 0.2, -0.9),
    );
    let middle = Pose::from_parts(
        Translation3::new(0.0, 0.05, -0.1),
        UnitQuaternion::from_euler_angles(-1.0, 0.5, 0.4),
    );
    let estimate = |name: &str, scene: String| {
        let [scene_file, output, csv] = ["toml", "mcap", "csv"].map(|of| format!("{name}.{of}"));
        fs::write(folder.path().join(&scene_file), scene).expect("a file");
        ran(
            folder.path(),
            &["replay", take, "--scene", &scene_file, "-o", &output],
            0,
        );
        ran(
            folder.path(),
            &["export", &output, "--to", "csv", "-o", &csv, "--fps", "60"],
            0,
        );
        let text = fs::read_to_string(folder.path().join(csv)).expect("a table");
        let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
        let bodies = rows.map(|line| line.split(',').nth(2).expect("a body").to_owned());
        let bodies: Vec<String> = bodies.collect();
        bodies.into_iter().zip(poses(&text)).collect::<Vec<_>>()
    };
    let plain = estimate("plain", include_str!("../../config/chain.toml").into());
    let moved = estimate("moved", chain_in(&ends, &middle));
    assert_eq!(plain.len(), moved.len());
    assert!(plain.len() > 60, "{}", plain.len());
    for ((body, (when, own)), (_, (_, given))) in plain.iter().zip(&moved) {
        let frame = if body.contains("rod 2") {
            &middle
        } else {
            &ends
        };
        let expected = own * frame.inverse();
        let apart_m = (expected.translation.vector - given.translation.vector).norm();
        assert!(apart_m < 1e-5, "{body} {when}: {apart_m} m");
        let turn_rad = expected.rotation.angle_to(&given.rotation);
        assert!(turn_rad < 1e-4, "{body} {when}: {turn_rad} rad");
    }
}

/// Acts a motion of a scene that was made, in which that feature of the body touches, and estimates it from the
/// recording.
fn acted(object: &str, touching: &str, state: State, after_s: f64) -> (Value, Vec<f64>) {
    let folder = tempfile::tempdir().expect("a folder");
    let new = [
        "scene",
        "new",
        object,
        "-o",
        "scene.toml",
        "--stamps",
        "physical",
    ];
    ran(folder.path(), &new, 0);
    let text = fs::read_to_string(folder.path().join("scene.toml")).expect("a scene");
    // The simulator of performances knows sharp corners without friction.
    let lines = text.lines().filter(|line| !line.starts_with("friction"));
    let text: String = lines.map(|line| format!("{line}\n")).collect();
    // And it acts by a hand.
    let text = text.replace("hand = \"none\"", "hand = \"acted\"");
    let mut scene = scene_from_toml(&text).expect("a scene");
    // It needs to know what touches; who estimates infers that where the scene does not say it.
    let features = &scene.links[LinkIndex(0)].features;
    let feature = features.iter().position(|of| of.name == touching);
    let touches = Touching {
        feature: Some(feature.expect("a feature of that name")),
        other: Some(0),
    };
    scene.set_contacts(0, &[touches]);
    let long = simulate(&scene, &[], &[state], 2.0).expect("a bounce");
    let bounce_s = long.event_times_s[0];
    let truth = simulate(&scene, &[], &[state], bounce_s + after_s).expect("a bounce");
    let performance = perform(&truth, &Acting::timing_known(), 3);
    let take = folder.path().join("take.mcap");
    recording::write(&performance, &text, &take).expect("a recording");
    let replay = ["replay", "take.mcap", "--format", "ndjson"];
    let report = ran(folder.path(), &replay, 0);
    let report = serde_json::from_str(&report).expect("JSON");
    (report, truth.event_times_s)
}

fn dropped(height_m: f64, turn: UnitQuaternion<f64>, spin_rad_s: [f64; 3]) -> State {
    State {
        position_m: Vector3::new(0.0, 0.0, height_m),
        orientation: turn,
        velocity_m_s: Vector3::new(0.3, 0.1, 0.4),
        angular_velocity_rad_s: spin_rad_s.into(),
    }
}

/// Shapes that are turned, hollow boxes in frames of their own: their scenes are estimated as others are, where a
/// feature is named and where it is inferred.
#[test]
fn objects_that_are_made_are_acted_and_estimated() {
    let upright = UnitQuaternion::from_euler_angles(0.04, 0.02, 0.0);
    let corner = Vector3::new(-100.0, -75.0, -50.0);
    let on_corner = UnitQuaternion::rotation_between(&corner, &-Vector3::z()).expect("a turn");
    let still = UnitQuaternion::from_euler_angles(0.03, 0.02, 0.0) * on_corner;
    for (object, touching, state, after_s) in [
        (
            "pencil",
            "tip",
            dropped(0.45, upright, [0.2, -0.3, 3.0]),
            0.15,
        ),
        ("pen", "tip", dropped(0.4, upright, [-0.2, 0.2, 2.0]), 0.15),
        (
            "box",
            "corner -x -y -z",
            dropped(0.5, still, [0.3, 0.2, 0.1]),
            0.12,
        ),
    ] {
        let (report, times_s) = acted(object, touching, state, after_s);
        assert_eq!(report["verdict"], "physical", "{object}: {report}");
        let contact = format!("{touching} on table");
        assert_eq!(
            report["events"][0]["contact"], contact,
            "{object}: {report}"
        );
        let time_s = |event: usize| report["events"][event]["time_s"].as_f64().expect("a time");
        let apart_s = (time_s(1) - time_s(0) - (times_s[1] - times_s[0])).abs();
        assert!(apart_s < 0.03, "{object}: {apart_s} s");
    }
}
