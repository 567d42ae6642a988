//! Times of events and parameters at their bounds, through the program: what a scene may say of
//! them, and what is said of them then.

use enact::math::Pose;
use enact::motion::{Mark, PoseSample, Stamp};
use enact::write::RecordingWriter;
use enact_tools::replay::Program;
use nalgebra::{Translation3, UnitQuaternion};
use serde_json::Value;
use tempfile::TempDir;

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));

/// A ball that is dropped, drifts along x and bounces. Its stamps are physical times.
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
"#;

/// Along x it is at 55 mm when it is caught.
const GOAL: &str = r#"
[[goal]]
event = "catch"
body = "ball"
position_within_mm = [[60, -inf, -inf], [inf, inf, inf]]
"#;

const GRAVITY_M_S2: f64 = 9.80665;
const HEIGHT_M: f64 = 0.5;
const END_S: f64 = 0.55;
const SAME_S: f64 = 1e-9;

fn at(time_s: f64) -> Stamp {
    Stamp(1_700_000_000_000_000_000 + (time_s * 1e9).round() as i64)
}

fn bounce_s() -> f64 {
    (2.0 * (HEIGHT_M - 0.02) / GRAVITY_M_S2).sqrt()
}

/// With noise of a millimetre, so that residuals are those of a tracker.
fn pose(index: u32) -> Pose {
    let time_s = f64::from(index) * 0.005;
    let after_s = time_s - bounce_s();
    let height_m = if after_s < 0.0 {
        HEIGHT_M - 0.5 * GRAVITY_M_S2 * time_s * time_s
    } else {
        let speed_m_s = 0.5 * GRAVITY_M_S2 * bounce_s();
        0.02 + speed_m_s * after_s - 0.5 * GRAVITY_M_S2 * after_s * after_s
    };
    let noise_m = |k: f64| 1e-3 * (f64::from(index * index) * k).sin();
    Pose::from_parts(
        Translation3::new(
            0.1 * time_s + noise_m(0.7),
            noise_m(1.3),
            height_m + noise_m(2.1),
        ),
        UnitQuaternion::identity(),
    )
}

/// What the program says of the ball in a scene, as text and as JSON.
struct Said {
    text: String,
    json: Value,
}

impl Said {
    fn event(&self, name: &str) -> &Value {
        let mut events = self.json["events"].as_array().unwrap().iter();
        events.find(|event| event["name"] == name).unwrap()
    }

    fn time_s(&self, name: &str) -> f64 {
        self.event(name)["time_s"].as_f64().unwrap()
    }

    fn sd_s(&self, name: &str) -> f64 {
        self.event(name)["time_sd_s"].as_f64().unwrap()
    }

    /// The line of the account that begins with those words.
    fn line(&self, words: &str) -> &str {
        let mut lines = self.text.lines();
        lines
            .find(|line| line.trim_start().starts_with(words))
            .unwrap()
    }
}

fn said(scene: &str) -> Said {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("take.mcap");
    let mut writer = RecordingWriter::create(&path).unwrap();
    writer
        .attach("scene.toml", "application/toml", scene.as_bytes())
        .unwrap();
    for index in 0..=110 {
        let stamp = at(f64::from(index) * 0.005);
        let sample = PoseSample::from_pose(stamp, &pose(index));
        writer
            .pose("/tracker/ball/pose", "world", stamp, &sample)
            .unwrap();
    }
    for time_s in [0.0, bounce_s(), END_S] {
        let mark = Mark {
            stamp: at(time_s),
            event: None,
        };
        writer.mark("/marks", at(0.6), &mark).unwrap();
    }
    writer.finish().unwrap();
    let (account, report) = (ENACT.account(&path, &[]), ENACT.report(&path, &[]));
    let is_estimate = matches!(report.code, Some(0 | 3));
    assert!(is_estimate, "{}", report.errors);
    assert_eq!(account.code, report.code);
    assert!(report.output.exists());
    Said {
        text: account.said,
        json: report.said,
    }
}

/// The scene with keys for one of its events.
fn with(event: &str, keys: &str) -> String {
    let name = format!("name = \"{event}\"\n");
    SCENE.replace(&name, &format!("{name}{keys}\n"))
}

#[test]
fn a_goal_does_not_set_a_physical_end_free() {
    let said = said(&format!("{SCENE}{GOAL}"));
    assert!(
        (said.time_s("catch") - END_S).abs() < SAME_S,
        "{}",
        said.text
    );
    let catch = said.event("catch");
    assert_eq!(
        (&catch["time_is"], &catch["time_sd_s"]),
        (&"fixed".into(), &Value::Null)
    );
    assert!(said.line("catch").ends_with("fixed"), "{}", said.text);
    assert!(said.event("bounce")["time_sd_s"].is_number());
    assert!(said.line("bounce").contains('±'));
}

#[test]
fn a_free_end_moves_as_far_as_its_mark_and_its_bounds_allow() {
    let free = said(&format!("{}{GOAL}", with("catch", "time = \"free\"")));
    let moved_s = free.time_s("catch") - END_S;
    assert!(moved_s > 0.001, "{}", free.text);
    assert_eq!(free.event("catch")["time_is"], "estimated");

    let tight = said(&format!("{}{GOAL}", with("catch", "time_sd_ms = 0.02")));
    assert!(
        tight.time_s("catch") - END_S < 0.5 * moved_s,
        "{}",
        tight.text
    );

    let latest_ms = 0.3e3 * moved_s;
    let bounded = said(&format!(
        "{}{GOAL}",
        with("catch", &format!("latest_ms = {latest_ms}"))
    ));
    let late_s = bounded.time_s("catch") - END_S;
    assert!(
        (late_s - latest_ms / 1e3).abs() < SAME_S,
        "{}",
        bounded.text
    );
    assert_eq!(bounded.event("catch")["time_at_bound"], "upper");
    assert!(
        bounded.line("catch").ends_with(", at its latest"),
        "{}",
        bounded.text
    );
    // What the goal asks for beyond the bound.
    assert!(
        bounded.sd_s("catch") > 0.5 * (moved_s - late_s),
        "{}",
        bounded.text
    );

    let earliest = said(&format!("{}{GOAL}", with("catch", "earliest_ms = 100")));
    assert!((earliest.time_s("catch") - END_S - 0.1).abs() < SAME_S);
    assert!(earliest.line("catch").ends_with(", at its earliest"));
}

#[test]
fn a_collision_is_where_its_mark_fixes_or_bounds_it() {
    let fixed = said(&with("bounce", "time = \"fixed\""));
    assert!((fixed.time_s("bounce") - bounce_s()).abs() < SAME_S);
    assert_eq!(fixed.event("bounce")["time_is"], "fixed");
    assert!(fixed.line("bounce").ends_with("fixed"), "{}", fixed.text);

    let late = said(&with("bounce", "earliest_ms = 2\nlatest_ms = 8"));
    assert!(
        (late.time_s("bounce") - bounce_s() - 0.002).abs() < SAME_S,
        "{}",
        late.text
    );
    let bounce = late.event("bounce");
    assert_eq!(bounce["time_at_bound"], "lower");
    // The true time is two milliseconds away.
    assert!(late.sd_s("bounce") > 0.001, "{}", late.text);
}

#[test]
fn a_parameter_at_its_bound_says_so_and_covers_what_is_beyond() {
    let free = "[[free]]\nquantity = \"bounce.restitution\"\n";
    let within = said(&format!("{SCENE}{free}"));
    let found = &within.json["parameters"]["bounce.restitution"];
    assert_eq!(found["at_bound"], Value::Null);
    let own = found["sd"].as_f64().unwrap();
    assert!(own < 0.01 && (found["value"].as_f64().unwrap() - 0.5).abs() < 4.0 * own);

    for (bound, value, side) in [("upper", 0.4, "upper"), ("lower", 0.6, "lower")] {
        let scene = SCENE.replace("restitution = 0.5", &format!("restitution = {value}"));
        let held = said(&format!("{scene}{free}{bound} = {value}\n"));
        let found = &held.json["parameters"]["bounce.restitution"];
        assert_eq!(found["at_bound"], side);
        assert!((found["value"].as_f64().unwrap() - value).abs() < 1e-12);
        // The truth is a tenth away, and what is left is more than noise.
        let sd = found["sd"].as_f64().unwrap();
        assert!((0.05..1.0).contains(&sd), "{}", held.text);
        let line = held.line("bounce.restitution");
        assert!(line.ends_with(&format!(", at its {side} bound")), "{line}");
    }
}

#[test]
fn what_cannot_be_meant_is_refused() {
    for (keys, message) in [
        ("time = \"late\"", "expected \"fixed\" or \"free\""),
        (
            "time = \"fixed\"\nlatest_ms = 3",
            "latest_ms does not apply to a fixed time",
        ),
        (
            "earliest_ms = 3\nlatest_ms = 3",
            "expected more than earliest_ms",
        ),
        ("time_sd_ms = 0", "expected a positive number"),
        ("latest_ms = inf", "expected a finite number"),
    ] {
        let error = enact::config::scene_from_toml(&with("catch", keys)).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
    }
    let edited = with("bounce", "latest_ms = 3").replace("\"physical\"", "\"edited\"");
    let error = enact::config::scene_from_toml(&edited).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("does not apply to edited stamps"),
        "{error}"
    );
}
