//! `enact predict` from outside: what follows the last sample used is a simulation with the scene's materials, and
//! nothing that was seen later changes it.

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use enact::math::Pose;
use enact::math::so3::exp;
use enact::motion::{Mark, PoseSample, Stamp};
use enact::write::RecordingWriter;
use nalgebra::Vector3;
use serde_json::Value;
use tempfile::TempDir;

const SCENE: &str = r#"name = "slide"
[timing]
stamps = "physical"
[weights]
position_mm = 0.1
orientation_deg = 0.1
[[body]]
name = "brick"
topic = "/brick"
shape = { kind = "cuboid", size_mm = [80, 60, 40] }
mass_g = 200
MATERIAL
[[surface]]
name = "table"
point_mm = [0, 0, 0]
normal = [0, 0, 1]
[[event]]
name = "release"
kind = "start"
[[event]]
name = "landing"
kind = "collision"
body = "brick"
feature = "corner -x -y -z"
surface = "table"
[[event]]
name = "end"
kind = "end"
"#;

/// The brick is thrown level, just above the table: it lands flat and slides.
const SPEED_M_S: f64 = 1.0;
const HEIGHT_M: f64 = 0.0205;

fn stamp(time_s: f64) -> Stamp {
    Stamp(1_000_000_000 + (time_s * 1e9).round() as i64)
}

/// The recording, with samples after the landing that are nonsense in one of two ways.
fn record(folder: &Path, friction: f64, restitution: f64, later_m: f64) -> PathBuf {
    let name = format!("{friction} {restitution} {later_m}");
    let material = format!("restitution = {restitution}\nfriction = {friction}");
    record_of(&folder.join(format!("{name}.mcap")), &material, later_m)
}

fn record_of(path: &Path, material: &str, later_m: f64) -> PathBuf {
    let mut writer = RecordingWriter::create(path).unwrap();
    let mut scene = SCENE.replace("MATERIAL", material);
    if material.is_empty() {
        // The collision needs a law, and then has its own.
        let at = "surface = \"table\"\n";
        scene = scene.replace(at, &format!("{at}restitution = 0.3\n"));
    }
    writer
        .attach("scene.toml", "application/toml", scene.as_bytes())
        .unwrap();
    let lands_s = (2.0 * (HEIGHT_M - 0.02) / 9.80665_f64).sqrt();
    let begins_s = lands_s - 0.2;
    for at in 0..80 {
        let time_s = begins_s + f64::from(at) * 0.005;
        let position_m = if time_s <= lands_s {
            Vector3::new(
                SPEED_M_S * time_s,
                0.0,
                HEIGHT_M - 0.5 * 9.80665 * time_s * time_s,
            )
        } else {
            Vector3::new(later_m, 0.3, 0.02)
        };
        let pose = Pose::from_parts(position_m.into(), exp(&Vector3::zeros()));
        let sample = PoseSample::from_pose(stamp(time_s), &pose);
        writer
            .pose("/brick", "world", sample.stamp, &sample)
            .unwrap();
    }
    for (event, time_s) in [
        ("release", begins_s),
        ("landing", lands_s),
        ("end", begins_s + 0.39),
    ] {
        let mark = Mark {
            stamp: stamp(time_s),
            event: Some(event.to_owned()),
        };
        writer.mark("/marks", mark.stamp, &mark).unwrap();
    }
    writer.finish().unwrap();
    path.to_owned()
}

fn predicted(input: &Path, more: &[&str]) -> (Option<i32>, Value, String) {
    let mut command = Command::cargo_bin("enact").unwrap();
    command
        .arg("predict")
        .arg(input)
        .args(["--format", "ndjson"])
        .args(more);
    let output = command.output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    let line = serde_json::from_slice(&output.stdout).unwrap_or_default();
    (output.status.code(), line, stderr)
}

/// Where the brick is at the end of a prediction \[m\].
fn rests_at(output: &Path) -> Vector3<f64> {
    let csv = output.with_extension("csv");
    let made = Command::cargo_bin("enact")
        .unwrap()
        .args(["export", "--to", "csv", "-o"])
        .arg(&csv)
        .arg(output)
        .output()
        .unwrap();
    assert!(
        matches!(made.status.code(), Some(0 | 3)),
        "{}",
        String::from_utf8_lossy(&made.stderr)
    );
    let text = std::fs::read_to_string(&csv).unwrap();
    let rows: Vec<Vec<&str>> = text
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.split(',').collect())
        .collect();
    let column = |name: &str| {
        let found = rows[0].iter().position(|cell| *cell == name);
        found.unwrap_or_else(|| panic!("{name} in {:?}", rows[0]))
    };
    let last = rows.last().unwrap();
    Vector3::from_iterator(["x_m", "y_m", "z_m"].map(|name| last[column(name)].parse().unwrap()))
}

#[test]
fn a_brick_slides_as_far_as_its_friction_lets_it() {
    let folder = TempDir::new().unwrap();
    for friction in [0.1, 0.2, 0.4] {
        let input = record(folder.path(), friction, 0.0, 9.0);
        let (code, report, stderr) = predicted(&input, &[]);
        assert!(matches!(code, Some(0 | 3)), "{stderr}");
        assert_eq!(report["settled"]["is_predicted"], true, "{report}");
        assert_eq!(report["settled"]["at_rest"], true, "{report}");
        // The impulse of the landing slows it by μ times its speed of fall; from there v²/(2 μ g).
        let lands_m = SPEED_M_S * (2.0 * (HEIGHT_M - 0.02) / 9.80665_f64).sqrt();
        let falls_m_s = (2.0 * 9.80665 * (HEIGHT_M - 0.02)).sqrt();
        let speed_m_s = SPEED_M_S - friction * falls_m_s;
        let slides_m = speed_m_s * speed_m_s / (2.0 * friction * 9.80665);
        let rest_m = rests_at(&input.with_extension("predicted.mcap"));
        let off_m = (rest_m - Vector3::new(lands_m + slides_m, 0.0, 0.02)).norm();
        assert!(
            off_m < 0.03 * slides_m,
            "friction {friction}: {rest_m}, {off_m} of {slides_m} m"
        );
    }
}

/// Where a prediction says that the brick may be, and how far from there.
fn spread(folder: &Path, name: &str, material: &str) -> (Vector3<f64>, f64, Value) {
    let input = record_of(&folder.join(name), material, 9.0);
    let (code, report, stderr) = predicted(&input, &[]);
    assert!(matches!(code, Some(0 | 3)), "{stderr}");
    let spread = report["settled"]["spread"].clone();
    let body = &spread["bodies"][0];
    let median_m = [0, 1, 2].map(|axis| body["median_m"][axis].as_f64().unwrap());
    (median_m.into(), body["radius_m"].as_f64().unwrap(), spread)
}

#[test]
fn a_prediction_is_as_uncertain_as_the_material() {
    let folder = TempDir::new().unwrap();
    let own = "restitution = 0.0\nfriction = 0.2";
    let (middle_m, exact_m, said) = spread(folder.path(), "exact.mcap", own);
    assert_eq!(
        (&said["draws"], &said["at_rest"]),
        (&32.into(), &32.into()),
        "{said}"
    );
    assert_eq!(said["bodies"][0]["up"][0]["up"], "face +z", "{said}");
    assert_eq!(said["bodies"][0]["up"][0]["share"], 1.0, "{said}");
    assert_eq!(said["exact"], serde_json::json!(["brick"]), "{said}");
    let slides_m = rests_at(&folder.path().join("exact.predicted.mcap"));
    assert!((middle_m - slides_m).norm() < 0.01, "{middle_m} {slides_m}");
    // The way is v²/(2 μ g): a tenth of the friction is a tenth of it, and 1.64 of that cover nine in ten.
    let scattered = format!("{own}\nfriction_sd = 0.02");
    let (_, radius_m, said) = spread(folder.path(), "scattered.mcap", &scattered);
    assert_eq!(said["exact"], serde_json::json!([]), "{said}");
    let expected_m = 1.64 * 0.1 * slides_m.x;
    assert!(
        (0.6 * expected_m..1.6 * expected_m).contains(&radius_m),
        "{radius_m}, expected {expected_m}"
    );
    assert!(exact_m < 0.2 * radius_m, "{exact_m} of {radius_m} m");
    // What nobody knows of the material is not left out.
    let (_, unknown_m, _) = spread(folder.path(), "unknown.mcap", "");
    assert!(unknown_m > 0.05, "{unknown_m}");
}

#[test]
fn a_prediction_says_how_far_it_may_be_off() {
    let folder = TempDir::new().unwrap();
    let input = record(folder.path(), 0.2, 0.0, 9.0);
    let output = Command::cargo_bin("enact")
        .unwrap()
        .arg("predict")
        .arg(&input)
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("spread    brick: 90 % within ") && text.contains("up: face +z 100 %"),
        "{text}"
    );
    // Nothing is stated of how well the material is known.
    assert!(text.contains("material of brick taken as exact"), "{text}");
}

#[test]
fn what_was_seen_later_changes_nothing() {
    let folder = TempDir::new().unwrap();
    let [one, other] = [9.0, -3.0].map(|later_m| record(folder.path(), 0.3, 0.1, later_m));
    let [one, other] = [one, other].map(|input| {
        assert!(matches!(predicted(&input, &[]).0, Some(0 | 3)));
        rests_at(&input.with_extension("predicted.mcap"))
    });
    assert_eq!(one, other);
}

#[test]
fn events_that_are_not_there_are_refused() {
    let folder = TempDir::new().unwrap();
    let input = record(folder.path(), 0.3, 0.1, 9.0);
    let (code, _, stderr) = predicted(&input, &["--until", "splash"]);
    assert_eq!(code, Some(1));
    assert!(
        stderr.contains("\"splash\"") && stderr.contains("landing"),
        "{stderr}"
    );
    let (code, _, stderr) = predicted(&input, &["--until", "release"]);
    assert!(
        code == Some(1) && stderr.contains("nothing was seen before"),
        "{stderr}"
    );
    assert_eq!(predicted(&input, &["--limit", "0"]).0, Some(2));
}
