//! Phases through the program: their truth is made by forces in small steps.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write;
use std::path::Path;

use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use serde_json::Value;

use crate::impacts::{assert_change, assert_force};
use crate::program::enact;

pub(crate) const GRAVITY_M_S2: f64 = 9.80665;
pub(crate) const STEP_S: f64 = 1e-5;

/// What a tracker sees, as a table.
pub(crate) struct Samples {
    pub(crate) csv: String,
}

impl Default for Samples {
    fn default() -> Self {
        let csv = "t,x,y,z,qw,qx,qy,qz\n".to_owned();
        Self { csv }
    }
}

impl Samples {
    /// A pose with the tracker's noise.
    pub(crate) fn add(
        &mut self,
        now_s: f64,
        position_m: &Vector3<f64>,
        orientation: &UnitQuaternion<f64>,
        random: &mut ChaCha8Rng,
    ) {
        let noise = Normal::new(0.0, 1.0).expect("a deviation");
        let mut noisy = |sd: f64| Vector3::from_fn(|_, _| sd * noise.sample(random));
        let seen = position_m + noisy(0.0003);
        let turned = orientation * UnitQuaternion::from_scaled_axis(noisy(0.005));
        let [i, j, k, one]: [f64; 4] = turned.coords.into();
        let _ = writeln!(
            self.csv,
            "{now_s:.6},{},{},{},{one},{i},{j},{k}",
            seen.x, seen.y, seen.z
        );
    }
}

/// What moves on a level table: a ball of that radius, or a box of that gyration radius about the normal \[m\].
#[derive(Clone, Copy)]
pub(crate) enum Moving {
    Ball(f64),
    Box(f64),
}

/// A motion on the table, its samples, and when slip and motion ended.
pub(crate) struct Made {
    pub(crate) csv: String,
    pub(crate) no_slip_s: Option<f64>,
    still_s: Option<f64>,
}

/// Steps by forces at the lowest point. `bounces` keeps it in the air in place of the table.
pub(crate) fn made(
    moving: Moving,
    [sliding, rolling]: [f64; 2],
    (velocity_m_s, spin_rad_s): (Vector3<f64>, Vector3<f64>),
    duration_s: f64,
    random: &mut ChaCha8Rng,
) -> Made {
    let height_m = match moving {
        Moving::Ball(radius_m) => radius_m,
        Moving::Box(_) => 0.02,
    };
    let (mut x, mut v) = (Vector3::new(0.1, -0.2, height_m), velocity_m_s);
    let (mut q, mut w) = (UnitQuaternion::identity(), spin_rad_s);
    let mut samples = Samples::default();
    let (mut no_slip_s, mut still_s) = (None, None);
    let steps = (duration_s / STEP_S).round() as usize;
    for step in 0..=steps {
        let now_s = step as f64 * STEP_S;
        if step % 500 == 0 {
            samples.add(now_s, &x, &q, random);
        }
        let arm = Vector3::z() * -height_m;
        match moving {
            Moving::Ball(radius_m) => {
                let slip = v + w.cross(&arm);
                let most = 3.5 * sliding * GRAVITY_M_S2 * STEP_S;
                if no_slip_s.is_none() && slip.norm() > most {
                    let force = slip.normalize() * (-sliding * GRAVITY_M_S2);
                    v += force * STEP_S;
                    w += arm.cross(&force) * (STEP_S / (0.4 * radius_m * radius_m));
                } else {
                    no_slip_s.get_or_insert(now_s);
                    v -= v.normalize() * (rolling * GRAVITY_M_S2 * STEP_S);
                    let about = Vector3::z() * w.z;
                    w = Vector3::z().cross(&v) / radius_m + about;
                }
            }
            Moving::Box(gyration_m) => {
                let both = v + Vector3::z() * (gyration_m * w.z);
                let slowed = sliding * GRAVITY_M_S2 * STEP_S;
                if still_s.is_none() && both.norm() > slowed {
                    let less = both - both.normalize() * slowed;
                    v = Vector3::new(less.x, less.y, 0.0);
                    w = Vector3::z() * (less.z / gyration_m);
                } else {
                    still_s.get_or_insert(now_s);
                    (v, w) = (Vector3::zeros(), Vector3::zeros());
                }
            }
        }
        x += v * STEP_S;
        q = UnitQuaternion::from_scaled_axis(w * STEP_S) * q;
    }
    Made {
        csv: samples.csv,
        no_slip_s,
        still_s,
    }
}

pub(crate) fn phase(name: &str, motion: &str, more: &str, ends: [&str; 2]) -> String {
    format!(
        "[[phase]]\nname = \"{name}\"\nmotion = \"{motion}\"\nbody = \"thing\"\nsurface = \"table\"\n{more}from = \"{}\"\nuntil = \"{}\"\n",
        ends[0], ends[1]
    )
}

fn scene(shape: &str, phases: &str) -> String {
    format!(
        "name = \"on a table\"\nhand = \"none\"\n[timing]\nstamps = \"physical\"\n\
         [[body]]\nname = \"thing\"\nshape = {shape}\nmass_g = 170\n\
         [[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
         [[event]]\nname = \"go\"\nkind = \"start\"\n\
         [[event]]\nname = \"change\"\nkind = \"change\"\nbody = \"thing\"\n\
         [[event]]\nname = \"end\"\nkind = \"end\"\n{phases}"
    )
}

/// The answer about a take, with its one change marked at a time.
fn answer(folder: &Path, scene: &str, made: &Made, mark_s: f64, end_s: f64) -> Value {
    let marks = [(0.0, "go"), (mark_s, "change"), (end_s, "end")];
    replayed(folder, scene, &made.csv, &marks)
}

/// The answer about a table with a scene and marks.
pub(crate) fn replayed(folder: &Path, scene: &str, csv: &str, marks: &[(f64, &str)]) -> Value {
    std::fs::write(folder.join("scene.toml"), scene).expect("a scene");
    std::fs::write(folder.join("poses.csv"), csv).expect("a table");
    let marks = marks
        .iter()
        .map(|(time_s, event)| format!("{time_s}:{event}"));
    let marks: Vec<String> = marks.collect();
    let mut import = "import poses.csv --scene scene.toml -o take.mcap"
        .split(' ')
        .collect::<Vec<_>>();
    import.extend(marks.iter().flat_map(|mark| ["--mark", mark.as_str()]));
    let ran = enact(folder, &import);
    let said = String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success(), "{said}");
    let ran = enact(folder, &["replay", "take.mcap", "--format", "ndjson"]);
    std::fs::remove_file(folder.join("take.mcap")).expect("a take");
    let said = String::from_utf8_lossy(&ran.stderr);
    serde_json::from_slice(&ran.stdout).unwrap_or_else(|_| panic!("one line of JSON: {said}"))
}

/// Asserts that a value is within four deviations of the truth, and that these are small.
pub(crate) fn assert_within(of: &Value, value: &str, sd: &str, truth: f64, most: f64, what: &str) {
    let (value, sd) = (of[value].as_f64(), of[sd].as_f64());
    let (Some(value), Some(sd)) = (value, sd) else {
        panic!("{what} is not told: {of}");
    };
    assert!(sd < most, "{what}: deviation {sd}");
    assert!(
        (value - truth).abs() < 4.0 * sd + 2e-5,
        "{what}: {value} ± {sd} for {truth}"
    );
}

pub(crate) const BALL: &str = "{ kind = \"sphere\", radius_mm = 30 }";
pub(crate) const BOX: &str = "{ kind = \"cuboid\", size_mm = [120, 80, 40] }";

#[test]
fn a_ball_slides_then_rolls_and_both_frictions_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    for seed in 0..6 {
        let mut random = ChaCha8Rng::seed_from_u64(9100 + seed);
        let frictions = [
            random.random_range(0.1..0.4),
            random.random_range(0.005..0.03),
        ];
        let velocity = Vector3::new(
            random.random_range(1.0..2.0),
            random.random_range(-0.5..0.5),
            0.0,
        );
        let spin = Vector3::from_fn(|_, _| random.random_range(-15.0..15.0));
        let made = made(
            Moving::Ball(0.03),
            frictions,
            (velocity, spin),
            1.2,
            &mut random,
        );
        let no_slip_s = made.no_slip_s.expect("it rolls in the end");
        let slide = phase("sliding", "slide", "friction = 0.2\n", ["go", "change"]);
        let roll = phase("rolling", "roll", "friction = 0.01\n", ["change", "end"]);
        let free = "[[free]]\nquantity = \"sliding.friction\"\n[[free]]\nquantity = \"rolling.friction\"\n";
        let scene = scene(BALL, &format!("{slide}{roll}{free}"));
        let mark_s = no_slip_s + random.random_range(-0.02..0.02);
        let said = answer(folder.path(), &scene, &made, mark_s, 1.2);
        assert_eq!(
            (&said["verdict"], &said["fits"]),
            (&"physical".into(), &"yes".into()),
            "{seed}: {said}"
        );
        assert_within(
            &said["events"][1],
            "time_s",
            "time_sd_s",
            no_slip_s,
            0.03,
            "no slip",
        );
        let of = &said["parameters"];
        assert_within(
            &of["sliding.friction"],
            "value",
            "sd",
            frictions[0],
            0.06,
            "sliding",
        );
        assert_within(
            &of["rolling.friction"],
            "value",
            "sd",
            frictions[1],
            0.002,
            "rolling",
        );
        let weight_n = 0.17 * GRAVITY_M_S2;
        for (segment, friction, most) in [(0, frictions[0], 0.06), (1, frictions[1], 0.002)] {
            let of = &said["segments"][segment];
            assert_force(&of["normal_n"], [weight_n; 2], 1e-3);
            assert_force(
                &of["friction_n"],
                [friction * weight_n; 2],
                3.0 * most * weight_n,
            );
            assert_eq!(of["pivot_n"], Value::Null);
        }
        assert_change(folder.path(), &said, "change", ["sliding", "rolling"]);
    }
}

#[test]
fn a_box_slides_and_turns_until_it_rests() {
    let folder = tempfile::tempdir().expect("a folder");
    let gyration_m = ((0.12_f64.powi(2) + 0.08_f64.powi(2)) / 12.0).sqrt();
    for seed in 0..4 {
        let mut random = ChaCha8Rng::seed_from_u64(9200 + seed);
        let friction = random.random_range(0.15..0.5);
        let velocity = Vector3::new(
            random.random_range(0.8..1.5),
            random.random_range(-0.5..0.5),
            0.0,
        );
        let spin = Vector3::z() * random.random_range(-8.0..8.0);
        let made = made(
            Moving::Box(gyration_m),
            [friction, 0.0],
            (velocity, spin),
            1.5,
            &mut random,
        );
        let still_s = made.still_s.expect("it rests in the end");
        let face = "feature = \"face -z\"\n";
        let slide = phase(
            "sliding",
            "slide",
            &format!("friction = 0.3\n{face}"),
            ["go", "change"],
        );
        let rest = phase("lying", "rest", face, ["change", "end"]);
        let free = "[[free]]\nquantity = \"sliding.friction\"\n";
        let scene = scene(BOX, &format!("{slide}{rest}{free}"));
        let said = answer(folder.path(), &scene, &made, still_s + 0.015, 1.5);
        assert_eq!(
            (&said["verdict"], &said["fits"]),
            (&"physical".into(), &"yes".into()),
            "{seed}: {said}"
        );
        assert_within(
            &said["events"][1],
            "time_s",
            "time_sd_s",
            still_s,
            0.02,
            "at rest",
        );
        let of = &said["parameters"]["sliding.friction"];
        assert_within(of, "value", "sd", friction, 0.02, "sliding");
    }
}

/// A cylinder of 15 mm that rolls until it rests: its samples, when it stops, and when they end.
fn rolled(speed_m_s: f64, friction: f64, seed: u64) -> (String, [f64; 2]) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut samples = Samples::default();
    let (radius_m, yaw) = (0.015, random.random_range(0.0..6.0));
    let about_z = UnitQuaternion::from_scaled_axis(Vector3::z() * yaw);
    let (axis, way) = (about_z * Vector3::x(), about_z * Vector3::y());
    let laid = UnitQuaternion::from_scaled_axis(Vector3::y() * FRAC_PI_2);
    let stops_s = speed_m_s / (friction * GRAVITY_M_S2);
    let end_s = stops_s + 0.3;
    for step in 0..=(end_s / STEP_S) as usize {
        let now_s = step as f64 * STEP_S;
        if step % 800 == 0 {
            let rolling_s = now_s.min(stops_s);
            let slowed_m_s = 0.5 * friction * GRAVITY_M_S2 * rolling_s;
            let way_m = (speed_m_s - slowed_m_s) * rolling_s;
            let position_m = Vector3::z() * radius_m + way * way_m;
            let rolled = UnitQuaternion::from_scaled_axis(axis * (-way_m / radius_m));
            let orientation = rolled * about_z * laid;
            samples.add(now_s, &position_m, &orientation, &mut random);
        }
    }
    (samples.csv, [stops_s, end_s - 0.01])
}

#[test]
fn a_cylinder_rolls_until_it_rests_and_its_friction_is_told() {
    let mut random = ChaCha8Rng::seed_from_u64(9600);
    let cylinder = "{ kind = \"cylinder\", length_mm = 90, radius_mm = 15 }";
    for seed in 0..4 {
        let folder = tempfile::tempdir().expect("a folder");
        let speed_m_s = random.random_range(0.3..0.8);
        let friction = random.random_range(0.012..0.06);
        let (csv, [stops_s, end_s]) = rolled(speed_m_s, friction, 9601 + seed);
        let side = "feature = \"side\"\n";
        let roll = phase(
            "rolling",
            "roll",
            &format!("{side}friction = 0.03\n"),
            ["go", "change"],
        );
        let rest = phase("lying", "rest", side, ["change", "end"]);
        let free = "[[free]]\nquantity = \"rolling.friction\"\n";
        let scene = scene(cylinder, &format!("{roll}{rest}{free}"));
        let mark_s = stops_s + random.random_range(-0.03..0.03);
        let marks = [(0.0, "go"), (mark_s, "change"), (end_s, "end")];
        let said = replayed(folder.path(), &scene, &csv, &marks);
        assert_eq!(said["verdict"], "physical", "{said}");
        assert_eq!(said["fits"], "yes", "{said}");
        let found = &said["parameters"]["rolling.friction"];
        assert_within(found, "value", "sd", friction, 1e-3, "friction");
        // It does not roll to the end.
        let change = "[[event]]\nname = \"change\"\nkind = \"change\"\nbody = \"thing\"\n";
        let wrong = scene.replace(change, "").replace(&rest, "");
        let wrong = wrong.replace("until = \"change\"", "until = \"end\"");
        let said = replayed(folder.path(), &wrong, &csv, &[marks[0], marks[2]]);
        assert!(
            said["verdict"] != "physical" || said["fits"] != "yes",
            "{said}"
        );
    }
}

#[test]
fn a_phase_that_is_not_there_does_not_fit() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut random = ChaCha8Rng::seed_from_u64(9300);
    let velocity = Vector3::new(1.5, 0.0, 0.0);
    let made = made(
        Moving::Ball(0.03),
        [0.2, 0.01],
        (velocity, Vector3::zeros()),
        1.2,
        &mut random,
    );
    let no_slip_s = made.no_slip_s.expect("it rolls in the end");
    let slide = |ends| phase("sliding", "slide", "friction = 0.2\n", ends);
    let roll = |ends| phase("rolling", "roll", "friction = 0.01\n", ends);
    let rest = |ends| phase("lying", "rest", "", ends);
    let wrong = [
        // It does not slide to its rest, but rolls,
        format!("{}{}", slide(["go", "change"]), rest(["change", "end"])),
        // and does not roll from the beginning.
        format!("{}{}", roll(["go", "change"]), rest(["change", "end"])),
    ];
    for phases in wrong {
        let said = answer(folder.path(), &scene(BALL, &phases), &made, no_slip_s, 1.2);
        assert_ne!(said["fits"], "yes", "{phases}: {said}");
    }
}

#[test]
fn phases_that_cannot_be_are_refused_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let slide = phase("a", "slide", "friction = 0.2\n", ["go", "change"]);
    let face = "friction = 0.2\nfeature = \"face -z\"\n";
    for (shape, phases, expected) in [
        (
            BALL,
            phase("a", "hop", "", ["go", "end"]),
            "\"held\" or \"tumble\"",
        ),
        (
            BALL,
            phase("a", "slide", "", ["go", "change"]),
            "missing key `friction`",
        ),
        (
            BALL,
            phase("a", "roll", "friction = 0.1\n", ["go", "end"]),
            "is between both events",
        ),
        (BALL, slide.clone() + &slide, "expected a name of its own"),
        (
            BALL,
            slide.clone() + &phase("b", "slide", "friction = 0.2\n", ["go", "change"]),
            "of one body at one time",
        ),
        (BALL, slide.replace("0.2", "-0.2"), "expected 0 to 10"),
        (BOX, slide.clone(), "missing key `feature`"),
        (
            BOX,
            phase("a", "roll", face, ["go", "change"]),
            "a face does not roll",
        ),
        (
            BALL,
            phase("a", "roll", "friction = 0.1\n", ["go", "change"])
                + &phase("b", "slide", "friction = 0.1\n", ["change", "end"]),
            "expected an impact",
        ),
        (
            BALL,
            phase("a", "slide", "friction = 0.1\n", ["change", "end"]),
            "nothing puts the body onto the surface",
        ),
        (
            BALL,
            slide.clone() + "[[free]]\nquantity = \"thing.mass\"\n",
            "cannot be free",
        ),
        (
            BALL,
            slide.clone() + "[[free]]\nquantity = \"table.height\"\n",
            "phases are on surfaces",
        ),
        (BALL, String::new(), "nothing changes at the event"),
        (
            BALL,
            slide.replace("name = \"a\"", "name = \"a\"\nspin = 3"),
            "unknown key `spin`",
        ),
    ] {
        std::fs::write(folder.path().join("scene.toml"), scene(shape, &phases)).expect("a scene");
        let ran = enact(folder.path(), &["scene", "check", "scene.toml"]);
        let said = String::from_utf8_lossy(&ran.stderr);
        assert!(
            !ran.status.success() && said.contains(expected),
            "{phases}\n{expected}: {said}"
        );
    }
}
