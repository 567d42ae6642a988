//! `enact calibrate` and `enact scene calibrated` from outside: from recordings to a scene that is right.

use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use enact::config::{Calibration, scene_from_toml};
use enact::math::so3::exp;
use enact::motion::{LinkIndex, Mark, PoseSample, TrackIndex};
use enact::write::RecordingWriter;
use nalgebra::{UnitQuaternion, Vector3};
use tempfile::TempDir;

use crate::performed::*;

const SCENE: &str = r#"# A pen above a table.
name = "pen"
[timing]
stamps = "physical"
[[body]]
name = "pen"
topic = "/pen"
shape = { kind = "cylinder", length_mm = 190, radius_mm = 4 }
mass_g = 6 # weighed
tracker = { position_mm = [0, 0, 0], orientation_wxyz = [0.5, 0.5, 0.5, 0.5] } # guessed
features_mm = { tip = [0, 0, -95] }
[[surface]]
name = "table"
point_mm = [0, 0, 0]
normal = [0, 0, 1]
"#;

fn enact(arguments: &[&str]) -> Output {
    let mut command = Command::cargo_bin("enact").unwrap();
    command.args(arguments).output().unwrap()
}

fn ok(arguments: &[&str], code: i32) -> String {
    let output = enact(arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {stderr}");
    String::from_utf8(output.stdout).unwrap()
}

fn failed(arguments: &[&str]) -> String {
    let output = enact(arguments);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn name(&self, name: &str) -> String {
        self.path(name).display().to_string()
    }

    /// A recording of streams, with marks at times and perhaps a scene.
    fn record(
        &self,
        name: &str,
        streams: &[(&str, &[PoseSample])],
        marks_s: &[f64],
        scene: Option<&str>,
    ) -> String {
        let mut writer = RecordingWriter::create(&self.path(name)).unwrap();
        if let Some(scene) = scene {
            writer
                .attach("scene.toml", "application/toml", scene.as_bytes())
                .unwrap();
        }
        for (topic, samples) in streams {
            for sample in *samples {
                writer.pose(topic, "world", sample.stamp, sample).unwrap();
            }
        }
        for mark_s in marks_s {
            let mark = Mark {
                stamp: stamp(*mark_s),
                event: None,
            };
            writer.mark("/marks", mark.stamp, &mark).unwrap();
        }
        writer.finish().unwrap();
        self.name(name)
    }

    fn calibration(&self, name: &str) -> Calibration {
        let text = std::fs::read_to_string(self.path(name)).unwrap();
        Calibration::from_toml(&text).unwrap()
    }
}

/// The quantity whose name begins so, with its interval.
fn quantity(of: &Calibration, name: &str) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let found = of.quantity.iter().find(|of| of.name.starts_with(name));
    let found = found.unwrap_or_else(|| panic!("{name} of {of:?}"));
    (
        found.value.clone(),
        found.lower.clone(),
        found.upper.clone(),
    )
}

#[test]
fn a_pivot_puts_the_tip_where_the_scene_has_it() {
    let folder = Folder::new();
    let samples = swing(21, Hand::Wanders(0.1), 3e-4, 20.0);
    let swing = folder.record("swing.mcap", &[("/pen", &samples)], &[], Some(SCENE));
    let (tip, scene, new) = (
        folder.name("tip.toml"),
        folder.name("pen.toml"),
        folder.name("new.toml"),
    );
    let account = ok(
        &["calibrate", "pivot", &swing, "--feature", "tip", "-o", &tip],
        0,
    );
    assert!(
        account.contains("tip in the tracker's axes") && account.contains(&tip),
        "{account}"
    );
    let found = folder.calibration("tip.toml");
    let (value, lower, upper) = quantity(&found, "tip in");
    for axis in 0..3 {
        let truth = TIP_M[axis] * 1e3;
        assert!((value[axis] - truth).abs() < 0.5, "{value:?}");
        // Three intervals of 95 %: twice as wide contains it all but surely.
        let half = 0.5 * (upper[axis] - lower[axis]);
        assert!(
            (value[axis] - truth).abs() < 2.0 * half && half < 0.5,
            "{value:?} ± {half}"
        );
    }
    assert_eq!(found.recording[0].poses, 2000);
    assert!(found.against.is_empty(), "{:?}", found.against);

    std::fs::write(&scene, SCENE).unwrap();
    let said = ok(&["scene", "calibrated", &scene, &tip, "-o", &new], 0);
    assert!(said.contains("tracker.position_mm"), "{said}");
    let text = std::fs::read_to_string(&new).unwrap();
    // What was written by hand stays.
    for kept in [
        "# A pen above a table.",
        "mass_g = 6 # weighed",
        "# guessed",
    ] {
        assert!(text.contains(kept), "{text}");
    }
    let made = scene_from_toml(&text).unwrap();
    let mount = made.tracks[TrackIndex(0)].link_from_tracker;
    let tip_m = (mount * nalgebra::Point3::from(TIP_M)).coords;
    assert!(
        (tip_m - Vector3::new(0.0, 0.0, -0.095)).norm() < 5e-4,
        "{tip_m}"
    );
    // Neither is ever replaced.
    for again in [
        vec!["scene", "calibrated", &scene, &tip, "-o", &new],
        vec!["calibrate", "pivot", &swing, "-o", &tip],
    ] {
        assert!(failed(&again).contains("is there already"));
    }
}

#[test]
fn a_plane_is_that_of_the_touches_at_marks() {
    let folder = Folder::new();
    let mut noise = Noise::new(22, Hand::None);
    let lean = exp(&Vector3::new(0.03, -0.02, 0.0));
    let places = [
        [-0.2, -0.1],
        [0.2, -0.1],
        [0.2, 0.15],
        [-0.2, 0.15],
        [0.0, 0.0],
        [0.1, 0.1],
    ];
    let (mut samples, mut marks_s) = (Vec::new(), Vec::new());
    for (at, [x, y]) in places.into_iter().enumerate() {
        let place = PLACE_M + lean * Vector3::new(x, y, 0.0);
        let turn = exp(&(noise.white() * 0.2));
        let begin_s = at as f64;
        marks_s.push(begin_s + 0.5);
        for step in 0..100 {
            let time_s = begin_s + f64::from(step) * 0.01;
            // On the table for 0.2 s, above it otherwise.
            let above_m = ((time_s - begin_s - 0.5).abs() - 0.1).max(0.0) * 0.2;
            let tip_m = place + lean * Vector3::new(0.0, 0.0, above_m);
            samples.push(sample(
                time_s,
                tip_m - turn * TIP_M + noise.white() * 1e-4,
                &turn,
            ));
        }
    }
    let touched = folder.record("touches.mcap", &[("/pen", &samples)], &marks_s, None);
    let plane = folder.name("table.toml");
    ok(
        &[
            "calibrate",
            "plane",
            &touched,
            "--point",
            "12,-5,-95",
            "-o",
            &plane,
        ],
        0,
    );
    let found = folder.calibration("table.toml");
    let surface = &found.scene.surface[0];
    let normal = Vector3::from(surface.normal);
    let truth = lean * Vector3::z();
    assert!(normal.angle(&truth) < 1e-3, "{normal}");
    let off_mm = truth.dot(&(Vector3::from(surface.point_mm) - PLACE_M * 1e3));
    assert!(off_mm.abs() < 0.2, "{off_mm}");
    let scene = folder.name("pen.toml");
    std::fs::write(&scene, SCENE).unwrap();
    let text = ok(&["scene", "calibrated", &scene, &plane], 0);
    let (point_m, made) = scene_from_toml(&text).unwrap().surfaces[0].plane().unwrap();
    assert!(
        made.angle(&truth) < 1e-3
            && (point_m * 1e3 - Vector3::from(surface.point_mm)).norm() < 1e-6
    );
    // The same by times, and by the tip of a pivot.
    let swung = swing(23, Hand::None, 0.0, 15.0);
    let swung = folder.record("swing.mcap", &[("/pen", &swung)], &[], None);
    let tip = folder.name("tip.toml");
    ok(&["calibrate", "pivot", &swung, "-o", &tip], 0);
    let toml = ok(
        &[
            "calibrate",
            "plane",
            &touched,
            "--tip",
            &tip,
            "--at",
            "0.5,1.5,2.5,3.5",
        ],
        0,
    );
    let by_tip = Calibration::from_toml(&toml).unwrap();
    assert!(Vector3::from(by_tip.scene.surface[0].normal).angle(&truth) < 2e-3);
    // In a line.
    let line = failed(&[
        "calibrate",
        "plane",
        &touched,
        "--point",
        "12,-5,-95",
        "--at",
        "0.48,0.5,0.52",
    ]);
    assert!(line.contains("lie in a line"), "{line}");
    let none = failed(&["calibrate", "plane", &swung, "--point", "0,0,0"]);
    assert!(none.contains("--at"), "{none}");
    // What touches must be said.
    assert_eq!(
        enact(&["calibrate", "plane", &touched]).status.code(),
        Some(2)
    );
}

#[test]
fn rest_says_the_noise_and_two_sides_how_the_tracker_is_turned() {
    let folder = Folder::new();
    let truth = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(0.5, 0.5, 0.5, 0.5))
        * exp(&Vector3::new(0.05, -0.03, 0.04));
    let mut names = Vec::new();
    for (at, up) in [Vector3::z(), Vector3::x()].into_iter().enumerate() {
        let mut noise = Noise::new(30 + at as u64, Hand::None);
        let body =
            exp(&Vector3::new(0.0, 0.0, 0.7)) * enact::math::so3::between(&up, &Vector3::z());
        let samples: Vec<PoseSample> = (0..1000)
            .map(|step| {
                let turn = body * truth * exp(&(noise.white() * 2e-4));
                sample(
                    f64::from(step) * 0.01,
                    PLACE_M + noise.white() * 1e-4,
                    &turn,
                )
            })
            .collect();
        names.push(folder.record(
            &format!("{at}.mcap"),
            &[("/pen", &samples)],
            &[],
            Some(SCENE),
        ));
    }
    let rest = folder.name("rest.toml");
    let stands = [
        "calibrate",
        "rest",
        &names[0],
        &names[1],
        "--stands",
        "+z",
        "--stands",
        "+x",
    ];
    ok(&[&stands[..], &["-o", &rest]].concat(), 0);
    let found = folder.calibration("rest.toml");
    let (sd, lower, upper) = quantity(&found, "noise of positions");
    for axis in 0..3 {
        assert!((sd[axis] - 0.1).abs() < 0.01 && lower[axis] < sd[axis] && sd[axis] < upper[axis]);
    }
    let scene = folder.name("pen.toml");
    std::fs::write(&scene, SCENE).unwrap();
    let text = ok(&["scene", "calibrated", &scene, &rest], 0);
    let made = scene_from_toml(&text).unwrap();
    let mount = made.tracks[TrackIndex(0)].link_from_tracker.rotation;
    assert!(mount.angle_to(&truth) < 1e-3, "{}", mount.angle_to(&truth));
    // One side leaves the turn about it, and says so.
    let one = ok(&["calibrate", "rest", &names[0], "--stands", "+z"], 0);
    assert!(
        one.contains("another recording in which it stands on another side"),
        "{one}"
    );
    let wrong = failed(&["calibrate", "rest", &names[0], "--stands", "up"]);
    assert!(wrong.contains("expected an axis or a face"), "{wrong}");
    // A body in the hand has keys for its tracker's noise.
    let held = SCENE.replace("mass_g = 6 # weighed\n", "held = true\n")
        + "[[body]]\nname = \"ball\"\nshape = { kind = \"sphere\", radius_mm = 20 }\nmass_g = 3\n";
    let held_file = folder.name("held.toml");
    std::fs::write(&held_file, &held).unwrap();
    let of_held = ok(
        &[
            "calibrate",
            "rest",
            &names[0],
            "--scene",
            &held_file,
            "--body",
            "pen",
        ],
        0,
    );
    let of_held_file = folder.name("noise.toml");
    std::fs::write(&of_held_file, of_held).unwrap();
    let text = ok(&["scene", "calibrated", &held_file, &of_held_file], 0);
    let held = scene_from_toml(&text).unwrap().links[LinkIndex(0)]
        .held
        .unwrap();
    assert!(
        (held.position_sd_m.unwrap() - 1e-4).abs() < 1e-5,
        "{held:?}"
    );
    // What moves is not at rest.
    let moving = swing(3, Hand::None, 0.0, 10.0);
    let moving = folder.record("moving.mcap", &[("/pen", &moving)], &[], None);
    assert!(ok(&["calibrate", "rest", &moving], 3).contains("was not at rest"));
}

/// Bodies whose origin is not their centre of mass and whose axes are not their principal ones, each with a feature
/// `tip` that is there in the frame in which the body is given.
const GIVEN: &[(&str, [f64; 3])] = &[
    (
        "shape = { kind = \"revolution\", profile_mm = [[0, 0], [3.5, 20], [3.5, 190]] }\nmass_g = 6\n\
         features_mm = { tip = [0, 0, 0] }\n",
        [0.0, 0.0, 0.0],
    ),
    (
        "shape = { kind = \"revolution\", profile_mm = [[0, 0], [3.5, 20], [3.5, 190]] }\nmass_g = 6\n\
         features_mm = { tip = [0, 0, 190] }\n",
        [0.0, 0.0, 190.0],
    ),
    (
        "shape = { kind = \"cuboid\", size_mm = [120, 60, 20], position_mm = [40, 10, -5], \
         rpy_deg = [20, -35, 50] }\nmass_g = 200\nfeatures_mm = { tip = [5, -10, 30] }\n",
        [5.0, -10.0, 30.0],
    ),
    (
        "shape = { kind = \"cuboid\", size_mm = [100, 100, 100] }\nmass_g = 300\ncentre_mm = [8, -6, 12]\n\
         inertia_kg_m2 = [4e-4, 5e-4, 6e-4, 0.7e-4, -0.4e-4, 0.9e-4]\nfeatures_mm = { tip = [50, 50, -50] }\n",
        [50.0, 50.0, -50.0],
    ),
    (
        "density_kg_m3 = 2300\nfeatures_mm = { tip = [66, 0, 10] }\n[[body.part]]\nname = \"cup\"\n\
         shape = { kind = \"revolution\", profile_mm = [[0, 0], [41, 0], [41, 95]], wall_mm = 4.5 }\n\
         [[body.part]]\nname = \"handle\"\n\
         shape = { kind = \"cuboid\", size_mm = [8, 14, 60], position_mm = [66, 0, 60] }\n",
        [66.0, 0.0, 10.0],
    ),
];

fn given_scene(body: &str, tracker: &str) -> String {
    format!(
        "name = \"given\"\n[timing]\nstamps = \"physical\"\n[[body]]\nname = \"pen\"\ntopic = \"/pen\"\n\
         tracker = {{ {tracker} }}\n{body}"
    )
}

/// The tracker's mount in the frame in which the scene gives its body.
fn mount_given(toml: &str) -> enact::math::Pose {
    let scene = scene_from_toml(toml).unwrap_or_else(|error| panic!("{error}\n{toml}"));
    let track = &scene.tracks[TrackIndex(0)];
    scene.links[track.link].given_from(&track.link_from_tracker)
}

#[test]
fn mounts_are_written_in_the_frame_in_which_the_body_is_given() {
    let turn = UnitQuaternion::from_euler_angles(0.3, -0.5, 1.1);
    let typed = "rpy_deg = [17.188733854, -28.647889757, 63.025357464]";
    let swung = swing(27, Hand::None, 0.0, 15.0);
    for (at, (body, tip_mm)) in GIVEN.iter().enumerate() {
        let folder = Folder::new();
        let scene = given_scene(body, typed);
        assert!(mount_given(&scene).rotation.angle_to(&turn) < 1e-8);
        let swing = folder.record("swing.mcap", &[("/pen", &swung)], &[], Some(&scene));
        let truth_m = Vector3::from(*tip_mm) * 1e-3 - turn * TIP_M;
        // Of its own result it finds the same again.
        let mut text = scene;
        for round in 0..2 {
            let file = folder.name("scene.toml");
            std::fs::write(&file, &text).unwrap();
            let tip = folder.name(&format!("{round}.toml"));
            let pivot = [
                "calibrate",
                "pivot",
                &swing,
                "--feature",
                "tip",
                "--scene",
                &file,
            ];
            ok(&[&pivot[..], &["-o", &tip]].concat(), 0);
            text = ok(&["scene", "calibrated", &file, &tip], 0);
            let off_m = (mount_given(&text).translation.vector - truth_m).norm();
            assert!(
                off_m < 2e-4,
                "body {at}, round {round}: off by {off_m} m\n{text}"
            );
        }
        // Standing on two sides of the frame in which it is given, with the tracker turned otherwise than typed.
        let truth = turn * exp(&Vector3::new(0.3, -0.2, 0.25));
        let mut arguments = vec!["calibrate".to_owned(), "rest".to_owned()];
        for up in [Vector3::z(), Vector3::x()] {
            let mut noise = Noise::new(40 + at as u64, Hand::None);
            let given =
                exp(&Vector3::new(0.0, 0.0, 0.7)) * enact::math::so3::between(&up, &Vector3::z());
            let samples = (0..400).map(|step| {
                let turn = given * truth * exp(&(noise.white() * 2e-4));
                sample(
                    f64::from(step) * 0.01,
                    PLACE_M + noise.white() * 1e-4,
                    &turn,
                )
            });
            let samples: Vec<PoseSample> = samples.collect();
            let name = format!("{}.mcap", arguments.len());
            arguments.push(folder.record(&name, &[("/pen", &samples)], &[], Some(&text)));
        }
        let rest = folder.name("rest.toml");
        arguments.extend(["--stands", "+z", "--stands", "+x", "-o", &rest].map(str::to_owned));
        ok(&arguments.iter().map(String::as_str).collect::<Vec<_>>(), 0);
        let file = folder.name("scene.toml");
        std::fs::write(&file, &text).unwrap();
        let text = ok(&["scene", "calibrated", &file, &rest], 0);
        let off_rad = mount_given(&text).rotation.angle_to(&truth);
        assert!(off_rad < 1e-3, "body {at}: off by {off_rad} rad\n{text}");
        assert!(!text.contains("rpy_deg = [17"), "{text}");
    }
}

#[test]
fn a_board_that_was_touched_stays_where_it_ends() {
    let folder = Folder::new();
    let board = SCENE.replace(
        "normal = [0, 0, 1]",
        "normal = [0, 0, 1]\nsize_mm = [800, 600]",
    );
    let plane = "kind = \"plane\"\nprogram = \"enact\"\nconfidence = 0.95\nagainst = []\nnotes = []\n\
                 recording = []\nquantity = []\n[[scene.surface]]\nname = \"table\"\n\
                 point_mm = [120.0, -80.0, 7.0]\nnormal = [0.0, 0.0, 1.0]\n";
    let [scene, touched] = ["board.toml", "table.toml"].map(|name| folder.name(name));
    std::fs::write(&scene, board).unwrap();
    std::fs::write(&touched, plane).unwrap();
    let text = ok(&["scene", "calibrated", &scene, &touched], 0);
    // Half of its thickness below.
    let board = &scene_from_toml(&text).unwrap().obstacles[0];
    let middle_m = board.world_from_shape.translation.vector;
    assert!(
        (middle_m - Vector3::new(0.0, 0.0, 0.002)).norm() < 1e-9,
        "{middle_m}"
    );
}

#[test]
fn gravity_says_direction_size_and_units() {
    let folder = Folder::new();
    let mut noise = Noise::new(40, Hand::None);
    let tosses: Vec<Vec<PoseSample>> = (0..6)
        .map(|_| flight(&mut noise, 0.0, 30, (3e-5, 1.0), &Vector3::zeros()))
        .collect();
    let at_centre = SCENE.replace("tracker = {", "# tracker = {");
    let names: Vec<String> = tosses
        .iter()
        .enumerate()
        .map(|(at, samples)| {
            folder.record(
                &format!("toss {at}.mcap"),
                &[("/pen", samples)],
                &[],
                Some(&at_centre),
            )
        })
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let file = folder.name("gravity.toml");
    ok(
        &[&["calibrate", "gravity"], &names[..], &["-o", &file]].concat(),
        0,
    );
    let found = folder.calibration("gravity.toml");
    let gravity = Vector3::from(found.scene.gravity_m_s2.unwrap());
    assert!((gravity - GRAVITY_M_S2).norm() < 0.05, "{gravity}");
    assert!(
        found
            .notes
            .iter()
            .any(|note| note.contains("up is near +z")),
        "{:?}",
        found.notes
    );
    let scene = folder.name("pen.toml");
    std::fs::write(&scene, SCENE).unwrap();
    let text = ok(&["scene", "calibrated", &scene, &file], 0);
    assert!((scene_from_toml(&text).unwrap().gravity_m_s2 - gravity).norm() < 1e-9);
    // In millimetres it is said, and no scene is made of it.
    let mut in_mm = tosses[0].clone();
    for sample in &mut in_mm {
        sample.position_m *= 1e3;
    }
    let in_mm = folder.record("mm.mcap", &[("/pen", &in_mm)], &[], Some(&at_centre));
    let said = ok(&["calibrate", "gravity", &in_mm], 3);
    assert!(said.contains("lengths come in mm"), "{said}");
    assert_eq!(
        Calibration::from_toml(&said).unwrap().scene.gravity_m_s2,
        None
    );
    let mm_file = folder.name("mm.toml");
    std::fs::write(&mm_file, said).unwrap();
    assert!(failed(&["scene", "calibrated", &scene, &mm_file]).contains("has no keys of a scene"));
    // Nothing falls at rest.
    let still = folder.record(
        "still.mcap",
        &[("/pen", &still(1, Hand::None, (0.0, 0.0), 5.0))],
        &[],
        None,
    );
    assert!(failed(&["calibrate", "gravity", &still]).contains("no free flight found"));
}

#[test]
fn clocks_become_free_quantities_with_their_interval_as_prior() {
    let folder = Folder::new();
    let [first, second] = turned(50, Hand::None, 0.0, 15.0);
    let scene = SCENE.replace("topic = \"/pen\"\n", "").replace(
        "tracker = { position_mm = [0, 0, 0], orientation_wxyz = [0.5, 0.5, 0.5, 0.5] } # guessed\n",
        "",
    ) + "[[body.track]]\nname = \"a\"\ntopic = \"/a\"\n[[body.track]]\nname = \"b\"\ntopic = \"/b\"\n";
    // Tables of the body come before the surface.
    let (head, surface) = scene.split_once("[[surface]]").unwrap();
    let (surface, tracks) = surface.split_once("[[body.track]]").unwrap();
    let scene = format!("{head}[[body.track]]{tracks}[[surface]]{surface}");
    let both = [("/a", first.as_slice()), ("/b", second.as_slice())];
    let recording = folder.record("turned.mcap", &both, &[], Some(&scene));
    let file = folder.name("clock.toml");
    ok(&["calibrate", "clock", &recording, "-o", &file], 0);
    let found = folder.calibration("clock.toml");
    let (offset_ms, lower, upper) = quantity(&found, "offset at the second");
    let half = 0.5 * (upper[0] - lower[0]);
    assert!(
        (offset_ms[0] - OFFSET_S * 1e3).abs() < 2.0 * half && half < 2.0,
        "{offset_ms:?} ± {half}"
    );
    let free = &found.scene.free[0];
    assert_eq!(free.quantity, "pen.b.clock.offset");
    assert!(free.prior_sd < half);
    let scene_file = folder.name("scene.toml");
    std::fs::write(&scene_file, &scene).unwrap();
    let text = ok(&["scene", "calibrated", &scene_file, &file], 0);
    let made = scene_from_toml(&text).unwrap();
    let offset = made
        .parameters
        .iter()
        .find(|of| of.name == "pen.b.clock.offset")
        .unwrap();
    assert!((offset.initial - OFFSET_S).abs() < 5e-3, "{offset:?}");
    // The other way round, the other is behind.
    let back = ok(
        &["calibrate", "clock", &recording, "--topics", "/b", "/a"],
        0,
    );
    let back = quantity(
        &Calibration::from_toml(&back).unwrap(),
        "offset at the middle",
    )
    .0[0];
    let there = quantity(&found, "offset at the middle").0[0];
    assert!((back + there).abs() < 1.0, "{back} {there}");
    let one = folder.record("one.mcap", &[("/a", &first)], &[], None);
    assert!(failed(&["calibrate", "clock", &one]).contains("which two streams"));
}

#[test]
fn what_is_not_for_the_scene_is_said_with_its_place() {
    let folder = Folder::new();
    let file = |name: &str, text: &str| {
        std::fs::write(folder.path(name), text).unwrap();
        folder.name(name)
    };
    let scene = file("pen.toml", SCENE);
    let head = "kind = \"rest\"\nprogram = \"x\"\nconfidence = 0.95\nagainst = []\nnotes = []\nrecording = []\nquantity = []\n";
    let other = file(
        "other.toml",
        &format!("{head}[[scene.body]]\nname = \"cup\"\ntracker = {{ position_mm = [1, 2, 3] }}\n"),
    );
    let said = failed(&["scene", "calibrated", &scene, &other]);
    assert!(
        said.contains("\"cup\"") && said.contains("expected one of pen"),
        "{said}"
    );
    let unit = file(
        "unit.toml",
        &format!("{head}[[scene.body]]\nname = \"pen\"\ntracker = {{ position_m = [1, 2, 3] }}\n"),
    );
    let said = failed(&["scene", "calibrated", &scene, &unit]);
    assert!(
        said.contains("unit.toml:10") && said.contains("position_mm"),
        "{said}"
    );
    let huge = file(
        "huge.toml",
        &format!("{head}[scene]\ngravity_m_s2 = [0, 0, -9806]\n"),
    );
    let said = failed(&["scene", "calibrated", &scene, &huge]);
    assert!(
        said.contains("it is in metres, not in millimetres"),
        "{said}"
    );
    let against = head.replace("against = []", "against = [\"it slipped\"]");
    let bad = file(
        "bad.toml",
        &format!("{against}[scene]\ngravity_m_s2 = [0, 0, -9.7]\n"),
    );
    let output = enact(&["scene", "calibrated", &scene, &bad]);
    assert_eq!(output.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&output.stderr).contains("it slipped"));
    assert!(!Path::new(&folder.path("pen.calibrated.toml")).exists());
}

#[test]
fn a_recording_that_is_cut_off_is_said_to_be() {
    let folder = Folder::new();
    let samples = swing(21, Hand::None, 0.0, 20.0);
    let swing = folder.record("swing.mcap", &[("/pen", &samples)], &[], None);
    let bytes = std::fs::read(&swing).unwrap();
    let cut = folder.name("cut.mcap");
    std::fs::write(&cut, &bytes[..bytes.len() - 30]).unwrap();
    let output = enact(&["calibrate", "pivot", &cut, "--format", "ndjson"]);
    assert_eq!(
        output.status.code(),
        Some(3),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let line: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(!line["lost"].as_array().unwrap().is_empty(), "{line}");
    assert_eq!(line["calibration"]["kind"], "pivot");
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(400))]
    /// No text makes the reader of calibrations or the merger panic, and what it makes is a scene.
    #[test]
    fn no_text_is_taken_for_a_calibration_that_is_none(
        cuts in proptest::collection::vec((0_usize..600, proptest::char::any()), 0..6),
    ) {
        let mut text: Vec<char> = concat!(
            "kind = \"rest\"\nprogram = \"x\"\nconfidence = 0.95\nagainst = []\nnotes = []\nrecording = []\n",
            "quantity = []\n[scene]\ngravity_m_s2 = [0, 0, -9.7]\n[[scene.body]]\nname = \"pen\"\n",
            "tracker = { position_mm = [1, 2, 3] }\n[[scene.surface]]\nname = \"table\"\n",
            "point_mm = [0, 0, 1]\nnormal = [0, 0, 1]\n"
        ).chars().collect();
        for (at, character) in cuts {
            let at = at % text.len();
            text[at] = character;
        }
        let text: String = text.into_iter().collect();
        if let Ok(calibration) = Calibration::from_toml(&text) {
            let made = enact::config::scene_calibrated(SCENE, &[("x".to_owned(), calibration)]);
            if let Ok(made) = made {
                proptest::prop_assert!(scene_from_toml(&made.toml).is_ok());
            }
        }
    }
}
