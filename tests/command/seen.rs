//! What is acted besides flights: phases are proposed, and pasted into the scene they give a motion that fits.

use std::path::Path;

use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

use crate::landings::thrown;
use crate::phases::{BALL, BOX, GRAVITY_M_S2, Moving, Samples, made, replayed};
use crate::program::enact;

fn scene(shape: &str, more: &str) -> String {
    format!(
        "name = \"on a table\"\n[timing]\nstamps = \"physical\"\n\
         [[body]]\nname = \"thing\"\nshape = {shape}\nmass_g = 170\n{more}\
         [[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
         [[event]]\nname = \"go\"\nkind = \"start\"\n\
         [[event]]\nname = \"end\"\nkind = \"end\"\n"
    )
}

/// What a command prints as one line of JSON.
fn told(folder: &Path, arguments: &[&str]) -> Value {
    let ran = enact(folder, arguments);
    let said = String::from_utf8_lossy(&ran.stderr);
    serde_json::from_slice(&ran.stdout).unwrap_or_else(|_| panic!("{arguments:?}: {said}"))
}

/// What is proposed for a table without marks.
fn proposed(folder: &Path, scene: &str, csv: &str) -> Value {
    std::fs::write(folder.join("scene.toml"), scene).expect("a scene");
    std::fs::write(folder.join("poses.csv"), csv).expect("a table");
    let import = "import poses.csv --scene scene.toml -o take.mcap";
    let import: Vec<&str> = import.split(' ').collect();
    let ran = enact(folder, &import);
    assert!(
        ran.status.success(),
        "{}",
        String::from_utf8_lossy(&ran.stderr)
    );
    told(
        folder,
        &["mark", "take.mcap", "--propose", "--format", "ndjson"],
    )
}

/// The phases that are proposed: motion, beginning and end.
fn seen(proposed: &Value) -> Vec<(String, f64, f64)> {
    let phases = proposed["phases"].as_array().expect("phases");
    let of = |phase: &Value| {
        let [from_s, until_s] = ["from_s", "until_s"].map(|key| phase[key].as_f64());
        let motion = phase["motion"].as_str().expect("a motion").to_owned();
        (motion, from_s.expect("a time"), until_s.expect("a time"))
    };
    phases.iter().map(of).collect()
}

/// The answer about a table with the scene that is proposed for it, and marks that are proposed for that.
fn answer_as_proposed(folder: &Path, scene: &str, csv: &str) -> Value {
    let first = proposed(folder, scene, csv);
    let text = first["scene_toml"].as_str();
    std::fs::write(
        folder.join("said.toml"),
        text.unwrap_or_else(|| panic!("nothing is proposed: {first}")),
    )
    .expect("a scene");
    let mark = "mark take.mcap --scene said.toml --propose -o marked.mcap --format ndjson";
    let again = told(folder, &mark.split(' ').collect::<Vec<_>>());
    let all = again["phases"].as_array().expect("phases");
    assert!(all.iter().all(|of| of["is_said"] == true), "{again}");
    assert!(again["toml"].is_null(), "{again}");
    let replay = "replay marked.mcap --scene said.toml -o out.mcap --format ndjson";
    let answer = told(folder, &replay.split(' ').collect::<Vec<_>>());
    for file in ["take.mcap", "marked.mcap", "out.mcap"] {
        std::fs::remove_file(folder.join(file)).expect("a file");
    }
    answer
}

fn assert_fits(said: &Value) {
    let answer = (&said["verdict"], &said["fits"]);
    assert_eq!(answer, (&"physical".into(), &"yes".into()), "{said}");
    assert_eq!(said["seen_phases"], serde_json::json!([]), "{said}");
}

#[test]
fn a_ball_that_slides_and_rolls_is_said_by_what_is_proposed() {
    let folder = tempfile::tempdir().expect("a folder");
    for seed in 0..3 {
        let mut random = ChaCha8Rng::seed_from_u64(7700 + seed);
        let velocity = Vector3::new(random.random_range(1.0..2.0), 0.3, 0.0);
        let frictions = [random.random_range(0.15..0.3), 0.012];
        let spin = Vector3::zeros();
        let ball = Moving::Ball(0.03);
        let made = made(ball, frictions, (velocity, spin), 1.2, &mut random);
        let scene = scene(BALL, "");
        let found = seen(&proposed(folder.path(), &scene, &made.csv));
        let motions: Vec<&str> = found.iter().map(|of| of.0.as_str()).collect();
        assert_eq!(motions, ["slide", "roll"], "{found:?}");
        let no_slip_s = made.no_slip_s.expect("it rolls in the end");
        assert!(
            (found[0].2 - no_slip_s).abs() < 0.05,
            "{found:?} {no_slip_s}"
        );
        assert_fits(&answer_as_proposed(folder.path(), &scene, &made.csv));
        // Without them, something speaks against any motion, and the account says what is seen.
        let marks = [(0.0, "go"), (1.195, "end")];
        let without = replayed(folder.path(), &scene, &made.csv, &marks);
        assert_ne!(without["verdict"], "physical", "{without}");
        let hint = &without["seen_phases"][0];
        assert_eq!(
            (&hint["motion"], &hint["surface"]),
            (&"slide".into(), &"table".into())
        );
    }
}

#[test]
fn a_box_that_slides_until_it_rests_is_said_by_what_is_proposed() {
    let folder = tempfile::tempdir().expect("a folder");
    for seed in 0..3 {
        let mut random = ChaCha8Rng::seed_from_u64(7710 + seed);
        let velocity = Vector3::new(random.random_range(0.8..1.6), 0.2, 0.0);
        let spin = Vector3::z() * random.random_range(-6.0..6.0);
        let friction = random.random_range(0.2..0.5);
        let made = made(
            Moving::Box(0.0416),
            [friction, 0.0],
            (velocity, spin),
            1.4,
            &mut random,
        );
        let found = seen(&proposed(folder.path(), &scene(BOX, ""), &made.csv));
        let motions: Vec<&str> = found.iter().map(|of| of.0.as_str()).collect();
        assert_eq!(motions, ["slide", "rest"], "{found:?}");
        assert_fits(&answer_as_proposed(
            folder.path(),
            &scene(BOX, ""),
            &made.csv,
        ));
    }
}

#[test]
fn a_landing_a_slide_and_a_rest_are_said_by_what_is_proposed() {
    let folder = tempfile::tempdir().expect("a folder");
    for seed in 0..3 {
        let mut random = ChaCha8Rng::seed_from_u64(7720 + seed);
        let velocity = Vector3::new(
            random.random_range(2.0..3.0),
            0.3,
            random.random_range(0.5..1.5),
        );
        let made = thrown(0.35, velocity, 0.0, &mut random);
        let scene = scene(BOX, "friction = 0.3\nrestitution = 0\n");
        assert_fits(&answer_as_proposed(folder.path(), &scene, &made.csv));
    }
}

/// A path at 120 Hz with the tracker's noise.
fn acted(duration_s: f64, seed: u64, at: impl Fn(f64) -> (Vector3<f64>, Vector3<f64>)) -> String {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut samples = Samples::default();
    for step in 0..(duration_s * 120.0) as usize {
        let now_s = step as f64 / 120.0;
        let (position_m, turned) = at(now_s);
        let orientation = UnitQuaternion::from_scaled_axis(turned);
        samples.add(now_s, &position_m, &orientation, &mut random);
    }
    samples.csv
}

#[test]
fn flights_and_bounces_are_no_phases() {
    let folder = tempfile::tempdir().expect("a folder");
    let bounce_s = 2.0 * 1.5 / GRAVITY_M_S2;
    for seed in 0..4 {
        let across_m_s = 0.4 * seed as f64;
        // Straight up and down again, and, of a ball, up from the table twice.
        for (shape, lowest_m) in [(BALL, 0.03), (BOX, 0.3)] {
            let at = |now_s: f64| {
                let since_s = now_s % bounce_s;
                let height_m = lowest_m + (1.5 - 0.5 * GRAVITY_M_S2 * since_s) * since_s;
                let place_m = Vector3::new(across_m_s * now_s, 0.0, height_m);
                (place_m, Vector3::new(3.0 * now_s, 0.0, 0.0))
            };
            let found = proposed(
                folder.path(),
                &scene(shape, ""),
                &acted(2.0 * bounce_s, seed, at),
            );
            assert!(seen(&found).is_empty(), "{shape} {found}");
        }
    }
}

#[test]
fn what_is_lifted_from_a_table_rested_and_is_in_a_hand() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |now_s: f64| {
        let share = ((now_s - 0.6) / 0.7).clamp(0.0, 1.0);
        let smooth = share.powi(3) * (10.0 - 15.0 * share + 6.0 * share * share);
        (
            Vector3::new(0.0, 0.3, 0.02 + 0.25 * smooth),
            Vector3::x() * smooth,
        )
    };
    let found = proposed(folder.path(), &scene(BOX, ""), &acted(1.3, 5, at));
    let found_s = seen(&found);
    let motions: Vec<&str> = found_s.iter().map(|of| of.0.as_str()).collect();
    assert_eq!(motions, ["rest", "held"], "{found}");
    // A lift begins too smoothly to be seen at once.
    assert!((found_s[0].2 - 0.6).abs() < 0.15, "{found}");
    // The take may begin after the rest.
    std::fs::write(folder.path().join("marks.csv"), "0.9,go\n1.29,end\n").expect("marks");
    let mark = "mark take.mcap --from marks.csv -o later.mcap";
    assert!(
        enact(folder.path(), &mark.split(' ').collect::<Vec<_>>())
            .status
            .success()
    );
    let later = told(
        folder.path(),
        &["mark", "later.mcap", "--propose", "--format", "ndjson"],
    );
    let motions: Vec<String> = seen(&later).into_iter().map(|of| of.0).collect();
    assert_eq!(motions, ["held"], "{later}");
}
