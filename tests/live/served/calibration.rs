//! Calibrations that the acting page asks for, step by step: a made-up tracker whose mount and whose table are known.

use std::time::{Duration, Instant};

use enact::config::scene_from_toml;
use nalgebra::{Isometry3, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use serde_json::{Value, json};

use super::acting::{ActingPage, begin_with, code};
use crate::harness::{Daemon, House, Patience};

const SCENE: &str = r#"# A pen above a table.
name = "pen"
[timing]
stamps = "physical"
[[body]]
name = "pen"
shape = { kind = "cylinder", length_mm = 190, radius_mm = 4 }
mass_g = 6 # weighed
tracker = { position_mm = [0, 0, 0], orientation_wxyz = [1, 0, 0, 0] } # guessed
features_mm = { tip = [0, 0, -95] }
[[surface]]
name = "table"
point_mm = [0, 0, 0]
normal = [0, 0, 1]
[[event]]
name = "release"
kind = "start"
[[event]]
name = "catch"
kind = "end"
"#;

const RATE_HZ: f64 = 100.0;
const NOISE_M: f64 = 1e-4;
const NOISE_RAD: f64 = 1e-3;
const TIP_M: Vector3<f64> = Vector3::new(0.0, 0.0, -0.095);

/// How the tracker is on the pen.
fn pen_from_tracker() -> Isometry3<f64> {
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -0.5, 0.9));
    Isometry3::from_parts(Translation3::new(0.02, -0.015, 0.11), turn)
}

/// Normal of the table, and its height at the origin \[m\].
fn table() -> (Unit<Vector3<f64>>, f64) {
    (Unit::new_normalize(Vector3::new(0.03, -0.05, 1.0)), 0.031)
}

/// Where the table is at a place.
fn on_table(x: f64, y: f64) -> Vector3<f64> {
    let (normal, height_m) = table();
    Vector3::new(x, y, height_m - (normal.x * x + normal.y * y) / normal.z)
}

/// A pen turned so, with its tip there.
fn with_tip(turn: UnitQuaternion<f64>, tip_m: Vector3<f64>) -> Isometry3<f64> {
    Isometry3::from_parts((tip_m - turn * TIP_M).into(), turn)
}

fn about(axis: Vector3<f64>, angle_rad: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(axis * angle_rad)
}

/// A page that is the tracker of the pen, with what it has sent.
struct CalibratingPage {
    page: ActingPage,
    sequence: u64,
    take: u64,
    random: ChaCha8Rng,
}

impl CalibratingPage {
    fn new(url: &str, code: &str) -> Self {
        Self {
            page: ActingPage::paired(url, code),
            sequence: 0,
            take: 0,
            random: ChaCha8Rng::seed_from_u64(5151),
        }
    }

    /// Records a take of a motion, with marks then, and puts it aside; its number.
    fn take(
        &mut self,
        daemon: &mut Daemon,
        seconds: f64,
        marks_s: &[f64],
        pose: impl Fn(f64) -> Isometry3<f64>,
    ) -> u64 {
        self.page.say(&json!({"say": "start"}));
        daemon.wait_for("started");
        self.take += 1;
        let noise = Normal::new(0.0, 1.0).expect("a spread");
        let begun = Instant::now();
        // A clock of its own, which goes on from take to take.
        let zero_ns = self.take as i64 * 1_000_000_000_000;
        for index in 0..(seconds * RATE_HZ) as u64 {
            let time_s = index as f64 / RATE_HZ;
            std::thread::sleep(Duration::from_secs_f64(time_s).saturating_sub(begun.elapsed()));
            let mut draw = |sd: f64| Vector3::from_fn(|_, _| sd * noise.sample(&mut self.random));
            let (shift, turn) = (draw(NOISE_M), draw(NOISE_RAD));
            let tracker = pose(time_s) * pen_from_tracker();
            let place = tracker.translation.vector + shift;
            let q = tracker.rotation * UnitQuaternion::from_scaled_axis(turn);
            let numbers = [place.x, place.y, place.z, q.i, q.j, q.k, q.w];
            let at_ns = zero_ns + (1e9 * time_s) as i64;
            assert!(self.page.reading(self.sequence, at_ns, numbers));
            self.sequence += 1;
        }
        for mark_s in marks_s {
            let at_ns = zero_ns + (1e9 * mark_s) as i64;
            self.page.say(&json!({"say": "mark", "device_ns": at_ns}));
        }
        self.page.say(&json!({"say": "discard"}));
        let patience = Patience::new();
        loop {
            patience.check("it is put aside");
            let state = self.page.hear("state");
            // Another may begin where none runs any more, which is said after what became of this one.
            let last = &state["takes"][0];
            let is_over = state["take"].is_null() && last["take"] == self.take;
            if is_over && last["state"] == "discarded" {
                return self.take;
            }
        }
    }

    /// Asks for a calibration.
    fn ask(&mut self, wish: Value) {
        let mut said = json!({"say": "calibrate", "stream": 0});
        for (key, value) in wish.as_object().expect("keys") {
            said[key] = value.clone();
        }
        self.page.say(&said);
    }

    fn found(&mut self, wish: Value) -> Value {
        self.ask(wish);
        let found = self.page.hear("calibrated");
        assert_eq!(found["is_good"], true, "{found}");
        found
    }

    fn refused(&mut self, wish: Value) -> String {
        self.ask(wish);
        let refused = self.page.hear("refused");
        refused["why"].as_str().expect("why").to_owned()
    }
}

/// The pen on the table, with that axis of its own up.
fn standing(axis: Vector3<f64>) -> Isometry3<f64> {
    let turn = UnitQuaternion::rotation_between(&axis, &Vector3::z()).expect("a turn");
    Isometry3::from_parts(
        Translation3::new(0.1, 0.2, 0.3),
        about(Vector3::z(), 0.4) * turn,
    )
}

/// It swings about its tip.
fn swinging(time_s: f64) -> Isometry3<f64> {
    let lean = 0.6 * (3.1 * time_s).sin();
    let nod = 0.6 * (2.3 * time_s).cos();
    let turn = about(Vector3::x(), lean) * about(Vector3::y(), nod);
    with_tip(turn, Vector3::new(0.2, -0.1, 0.04))
}

const TOUCHES: [[f64; 2]; 4] = [[-0.2, -0.15], [0.25, -0.1], [0.05, 0.3], [-0.15, 0.2]];

/// It touches the table for half a second at each place, and is lifted over to the next.
fn touching(time_s: f64) -> Isometry3<f64> {
    let at = (time_s.floor() as usize).min(TOUCHES.len() - 1);
    let [x, y] = TOUCHES[at];
    let lift_m = 0.05
        * (std::f64::consts::TAU * (time_s.fract() - 0.5).max(0.0))
            .sin()
            .max(0.0);
    let turn = about(Vector3::x(), 0.2 + 0.1 * time_s);
    with_tip(turn, on_table(x, y) + lift_m * Vector3::z())
}

fn marks_s(count: usize) -> Vec<f64> {
    (0..count).map(|at| at as f64 + 0.25).collect()
}

#[test]
fn a_page_calibrates_mount_and_table_step_by_step() {
    let house = House::new();
    let scene = house.folder().join("pen.toml");
    std::fs::write(&scene, SCENE).expect("write");
    let (mut daemon, url) = begin_with(&house, house.text(&scene), &[]);
    let mut page = CalibratingPage::new(&url, &code(&daemon));

    let up = page.take(&mut daemon, 3.0, &[], |_| standing(Vector3::z()));
    // As the page does: of one side, then of both.
    page.found(json!({"step": "rest", "takes": [up], "stands": ["+z"]}));
    let side = page.take(&mut daemon, 3.0, &[], |_| standing(Vector3::x()));
    page.found(json!({"step": "rest", "takes": [up, side], "stands": ["+z", "+x"]}));
    let swung = page.take(&mut daemon, 8.0, &[], swinging);
    let tip = page.found(json!({"step": "pivot", "takes": [swung], "feature": "tip"}));
    assert!(tip["keys"].as_str().expect("keys").contains("position_mm"));
    let touched = page.take(&mut daemon, 4.0, &marks_s(4), touching);
    let wish = json!({"step": "plane", "takes": [touched], "feature": "tip", "surface": "table"});
    let found = page.found(wish);
    let keys = found["keys"].as_str().expect("keys");
    assert!(
        keys.contains("[[surface]]") && keys.contains("normal"),
        "{keys}"
    );

    // The scene with all of it, beside the recording, and the user's own as it was.
    let toml = std::fs::read_to_string(found["scene"].as_str().expect("a scene")).expect("read");
    let made = scene_from_toml(&toml).expect("a scene");
    let track = &made.tracks[enact::motion::TrackIndex::from(0)];
    let off = pen_from_tracker().inverse() * track.link_from_tracker;
    assert!(off.rotation.angle().to_degrees() < 0.2, "{off}");
    assert!(off.translation.vector.norm() < 5e-4, "{off}");
    let (normal, _) = table();
    let (point_m, found) = made.surfaces[0].plane().expect("a plane");
    let lean = found.dot(&normal).clamp(-1.0, 1.0).acos();
    assert!(lean.to_degrees() < 0.1, "{found:?}");
    let off_m = (point_m - on_table(0.0, 0.0)).dot(&normal);
    assert!(off_m.abs() < 3e-4, "{off_m}");
    assert_eq!(std::fs::read_to_string(&scene).expect("read"), SCENE);
    // Nothing of it is a performance.
    assert!(house.recordings().is_empty(), "{:?}", house.recordings());
    daemon.end();
}

#[test]
fn a_calibration_of_too_little_is_refused_in_words() {
    let house = House::new();
    let scene = house.folder().join("pen.toml");
    std::fs::write(&scene, SCENE).expect("write");
    let (mut daemon, url) = begin_with(&house, house.text(&scene), &[]);
    let code = code(&daemon);
    let mut page = CalibratingPage::new(&url, &code);
    let still = page.take(&mut daemon, 2.0, &[], |_| standing(Vector3::z()));
    let touched = page.take(&mut daemon, 2.0, &marks_s(2), touching);
    let tip = |takes: &[u64]| json!({"step": "plane", "takes": takes, "feature": "tip"});
    for (wish, part) in [
        (tip(&[touched]), "2 touches, expected at least 3"),
        (tip(&[still]), "no touches, expected marks"),
        (
            json!({"step": "plane", "takes": [touched]}),
            "where the tip is",
        ),
        (
            json!({"step": "pivot", "takes": [still], "feature": "tip"}),
            "swing it about two axes",
        ),
        (
            json!({"step": "plane", "takes": [touched], "feature": "nose"}),
            "no feature \"nose\"",
        ),
        (
            json!({"step": "rest", "takes": [still], "stands": ["up"]}),
            "up",
        ),
        (tip(&[99]), "take 99 is none of the last ones"),
        (tip(&[]), "0 takes, expected 1 to 6"),
        (tip(&[still; 7]), "7 takes, expected 1 to 6"),
        (
            json!({"step": "plane", "takes": [touched], "stream": 4}),
            "no stream 4",
        ),
        (json!({"step": "clock", "takes": [touched]}), "no message"),
    ] {
        let why = page.refused(wish.clone());
        assert!(why.contains(part), "{wish}: {why}");
    }
    // What moved is shown, and is in no scene.
    page.ask(json!({"step": "rest", "takes": [touched]}));
    let found = page.page.hear("calibrated");
    assert_eq!(
        (&found["is_good"], &found["scene"]),
        (&json!(false), &Value::Null)
    );
    let against = found["against"][0].as_str().expect("against");
    assert!(against.contains("it was not at rest"), "{against}");
    // A take that runs is no recording, and goes on.
    page.page.say(&json!({"say": "start"}));
    daemon.wait_for("started");
    let why = page.refused(json!({"step": "rest", "takes": [page.take + 1]}));
    assert!(why.contains("none of the last ones"), "{why}");
    page.page.say(&json!({"say": "discard"}));
    // Who has not said the code asks for nothing.
    let mut stranger = ActingPage::open(&url);
    stranger.say(&json!({"say": "calibrate", "step": "rest", "stream": 0, "takes": [still]}));
    stranger.hear("refused");
    assert_eq!(stranger.heard("calibrated"), None);
    daemon.end();
}

#[test]
fn the_tip_of_the_first_test_is_on_the_table() {
    for at in 0..TOUCHES.len() {
        let tip = touching(at as f64 + 0.25) * Point3::from(TIP_M);
        let [x, y] = TOUCHES[at];
        assert!((tip.coords - on_table(x, y)).norm() < 1e-12);
    }
}
