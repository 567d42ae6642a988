//! Every command that writes files, with every fault: what bears the name of an output is the old file or
//! the new one, whole.

use std::path::Path;

use super::desk::{Desk, Run};
use super::{every, random};

const OLD: &[u8] = b"what was there before";

/// A run of a command that writes files.
struct Writes<'a> {
    arguments: &'a [&'a str],
    inputs: &'a [(&'a str, &'a [u8])],
    outputs: &'a [&'a str],
    /// Whether it replaces files of these names; else it is refused where there are some.
    replaces: bool,
    /// How it ends without faults.
    code: i32,
}

impl Writes<'_> {
    fn desk(&self) -> Option<Desk> {
        let desk = Desk::new()?;
        for (name, bytes) in self.inputs {
            desk.put(name, bytes);
        }
        for name in self.outputs.iter().filter(|_| self.replaces) {
            desk.put(name, OLD);
        }
        Some(desk)
    }

    /// Makes every fault, and several at once; `least` of single ones there must be.
    fn check(&self, seed: u64, least: usize) {
        let Some(desk) = self.desk() else {
            return;
        };
        let run = desk.run(self.arguments, "");
        assert_eq!(run.code, Some(self.code), "{}", run.said);
        let expected = desk.files();
        for name in self.outputs {
            assert!(expected[*name] != OLD, "{name} is not written");
        }
        let fails = |faults: &str| {
            let desk = self.desk().expect("a desk");
            let Run { code, fired, said } = desk.run(self.arguments, faults);
            let mut left = desk.files();
            for name in self.outputs {
                let found = left.remove(*name);
                let is_new = found.as_ref() == Some(&expected[*name]);
                let is_old = match found {
                    Some(found) => self.replaces && found == OLD,
                    None => !self.replaces,
                };
                assert!(is_new || is_old, "{faults}: {name} is neither old nor new");
                assert!(
                    code != Some(self.code) || is_new,
                    "{faults}: {name} is not written: {said}"
                );
            }
            let is_end = |code| code == 1 || code == self.code;
            assert!(code.is_none_or(is_end), "{faults}: {code:?}: {said}");
            for (name, bytes) in self.inputs {
                let is_same = left.remove(*name).is_some_and(|left| left == *bytes);
                assert!(is_same, "{faults}: {name} was changed");
            }
            // Who is killed, or may not remove a file, leaves a temporary one.
            let may_leave = code.is_none() || faults.contains("unlink");
            assert!(left.is_empty() || may_leave, "{faults}: {:?}", left.keys());
            assert!(left.keys().all(|name| name.starts_with(".enact-")));
            fired
        };
        let fired = every(fails);
        assert!(fired > least, "{fired} faults");
        random(seed, 60, fails);
    }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn recording() -> Vec<u8> {
    std::fs::read(root().join("recordings/pencil_tip.mcap")).expect("a recording")
}

fn scene() -> Vec<u8> {
    std::fs::read(root().join("config/pencil_tip.toml")).expect("a scene")
}

/// What a command makes of files, where there are faults to be had.
fn made(arguments: &[&str], inputs: &[(&str, &[u8])], output: &str) -> Option<Vec<u8>> {
    let desk = Desk::new()?;
    for (name, bytes) in inputs {
        desk.put(name, bytes);
    }
    let run = desk.run(arguments, "");
    assert!(matches!(run.code, Some(0 | 3)), "{}", run.said);
    desk.files().remove(output)
}

fn estimate() -> Option<Vec<u8>> {
    let inputs: [(&str, &[u8]); 1] = [("in.mcap", &recording())];
    made(
        &["replay", "in.mcap", "-o", "out.mcap"],
        &inputs,
        "out.mcap",
    )
}

#[test]
fn a_sketch_that_fails_at_any_call_is_the_old_or_the_new_one() {
    Writes {
        arguments: &["sketch", "in.mcap", "-o", "out.csv", "--per-flight", "4"],
        inputs: &[("in.mcap", &recording())],
        outputs: &["out.csv"],
        replaces: true,
        code: 0,
    }
    .check(4, 20);
}

#[test]
fn an_export_that_fails_at_any_call_is_the_old_or_the_new_one() {
    let Some(estimate) = estimate() else {
        return;
    };
    Writes {
        arguments: &["export", "in.mcap", "--to", "glb", "-o", "out.glb"],
        inputs: &[("in.mcap", &estimate)],
        outputs: &["out.glb"],
        replaces: true,
        code: 0,
    }
    .check(5, 20);
}

#[test]
fn a_page_and_a_picture_that_fail_at_any_call_are_the_old_or_the_new_ones() {
    let Some(estimate) = estimate() else {
        return;
    };
    Writes {
        arguments: &["report", "in.mcap", "-o", "out.html", "--svg", "out.svg"],
        inputs: &[("in.mcap", &estimate)],
        outputs: &["out.html", "out.svg"],
        replaces: true,
        code: 0,
    }
    .check(7, 30);
}

#[test]
fn an_estimate_that_fails_at_any_call_is_the_old_or_the_new_one() {
    Writes {
        arguments: &["replay", "in.mcap", "-o", "out.mcap"],
        inputs: &[("in.mcap", &recording())],
        outputs: &["out.mcap"],
        replaces: true,
        code: 0,
    }
    .check(6, 20);
}

#[test]
fn a_prediction_that_fails_at_any_call_is_the_old_or_the_new_one() {
    Writes {
        arguments: &["predict", "in.mcap", "--limit", "0.2", "-o", "out.mcap"],
        inputs: &[("in.mcap", &recording())],
        outputs: &["out.mcap"],
        replaces: true,
        code: 0,
    }
    .check(8, 20);
}

#[test]
fn marks_that_fail_at_any_call_are_in_the_old_or_the_new_copy() {
    Writes {
        arguments: &["mark", "in.mcap", "--add", "0.5", "-o", "out.mcap"],
        inputs: &[("in.mcap", &recording())],
        outputs: &["out.mcap"],
        replaces: true,
        code: 0,
    }
    .check(9, 20);
}

/// A table of poses that turn about a point a tenth of a metre below the tracker.
fn swing() -> String {
    let mut table = "t,x,y,z,qx,qy,qz,qw\n".to_owned();
    for k in 0..400 {
        let t = f64::from(k) * 0.01;
        // A cone that narrows and widens, about the upright.
        let (half, turn) = (0.25 * (1.0 + (1.3 * t).sin()), 2.0 * t);
        let (x, y, w) = (half.sin() * turn.cos(), half.sin() * turn.sin(), half.cos());
        // The third column of the rotation matrix: the tracker's z axis.
        let axis = [2.0 * y * w, -2.0 * x * w, 1.0 - 2.0 * (x * x + y * y)];
        let [px, py, pz] = axis.map(|c| 0.1 * c);
        table += &format!("{t:.2},{px:.9},{py:.9},{pz:.9},{x:.9},{y:.9},0,{w:.9}\n");
    }
    table
}

const IMPORT: &[&str] = &[
    "import",
    "in.csv",
    "--topic",
    "/pen",
    "-o",
    "out.mcap",
    "--length-unit",
    "m",
];

#[test]
fn an_import_that_fails_at_any_call_is_the_old_or_the_new_one() {
    Writes {
        arguments: IMPORT,
        inputs: &[("in.csv", swing().as_bytes())],
        outputs: &["out.mcap"],
        replaces: true,
        code: 0,
    }
    .check(10, 20);
}

/// What people work on by hand is never replaced: it is there whole or not at all.
#[test]
fn a_calibration_that_fails_at_any_call_is_whole_or_not_there() {
    let table = swing();
    let inputs: [(&str, &[u8]); 1] = [("in.csv", table.as_bytes())];
    let Some(recording) = made(IMPORT, &inputs, "out.mcap") else {
        return;
    };
    Writes {
        arguments: &["calibrate", "pivot", "in.mcap", "-o", "tip.toml"],
        inputs: &[("in.mcap", &recording)],
        outputs: &["tip.toml"],
        replaces: false,
        code: 0,
    }
    .check(11, 20);
}

const ROBOT: &[u8] = br#"<robot name="r"><link name="a">
<inertial><mass value="1"/>
<inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><sphere radius="0.05"/></geometry></collision>
</link></robot>"#;

#[test]
fn a_scene_that_fails_at_any_call_is_whole_or_not_there() {
    Writes {
        arguments: &["scene", "new", "pencil", "-o", "new.toml"],
        inputs: &[("in.toml", &scene())],
        outputs: &["new.toml"],
        replaces: false,
        code: 0,
    }
    .check(12, 15);
    Writes {
        arguments: &["scene", "from-urdf", "in.urdf", "-o", "new.toml"],
        inputs: &[("in.urdf", ROBOT)],
        outputs: &["new.toml"],
        replaces: false,
        code: 0,
    }
    .check(13, 20);
}

/// Of those who write a scene of one name at once one does, and nothing of another is in it.
#[test]
fn of_scenes_that_are_made_at_once_one_is_there() {
    let folder = tempfile::tempdir().expect("folder");
    for round in 0..6 {
        let name = format!("new{round}.toml");
        let objects = ["pencil", "die", "mug", "box", "book", "ball"];
        let make = |object: &&str| {
            std::process::Command::new(env!("CARGO_BIN_EXE_enact"))
                .args(["scene", "new", object, "-o", &name])
                .current_dir(folder.path())
                .stdout(std::process::Stdio::null())
                .stderr(std::process::Stdio::null())
                .spawn()
                .expect("run")
        };
        let running: Vec<_> = objects.iter().map(make).collect();
        let mut done = Vec::new();
        for (object, mut child) in objects.iter().zip(running) {
            if child.wait().expect("an end").success() {
                done.push(*object);
            }
        }
        let [object] = done[..] else {
            panic!("{done:?} were written as {name}");
        };
        let alone = folder.path().join(format!("{object}{round}.toml"));
        let made = std::process::Command::new(env!("CARGO_BIN_EXE_enact"))
            .args(["scene", "new", object, "-o"])
            .arg(&alone)
            .output()
            .expect("run");
        assert!(made.status.success());
        // All but the first line, which has the command.
        let [left, alone] = [&folder.path().join(&name), &alone].map(|path| {
            let text = std::fs::read_to_string(path).expect("written");
            let (made, scene) = text.split_once('\n').expect("lines");
            assert!(made.contains("enact scene new"), "{made}");
            scene.to_owned()
        });
        assert_eq!(left, alone);
    }
}
