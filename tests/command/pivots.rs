//! Bodies that are tied to the world, or held still, until they are let go: the truth is a pendulum's equation in small
//! steps, then a flight.

use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

use crate::impacts::assert_force;
use crate::phases::{GRAVITY_M_S2, STEP_S, Samples, assert_within, replayed};
use crate::program::enact;

/// A rod of 0.4 m whose end hangs on a nail at 1.2 m, or is held there.
const LENGTH_M: f64 = 0.4;
const NAIL_M: Vector3<f64> = Vector3::new(0.1, -0.2, 1.2);
const RADIUS_M: f64 = 0.005;

const JOINT: &str = "[[joint]]\nname = \"nail\"\nkind = \"pin\"\naxis = [0, 1, 0]\nparent_at_mm = [100, -200, 1200]\n\
                     child = \"rod\"\nchild_at_mm = [0, 0, 200]\n";

fn scene(tie: &str) -> String {
    format!(
        "name = \"let go\"\nhand = \"none\"\n[timing]\nstamps = \"physical\"\n\
         [[body]]\nname = \"rod\"\nshape = {{ kind = \"cylinder\", length_mm = 400, radius_mm = 5 }}\nmass_g = 120\n\
         [[event]]\nname = \"go\"\nkind = \"start\"\n\
         [[event]]\nname = \"let go\"\nkind = \"change\"\nbody = \"rod\"\n\
         [[event]]\nname = \"end\"\nkind = \"end\"\n{tie}"
    )
}

/// A rod at an angle from hanging and with a rate, let go at a time; it stands still until then where it is held.
fn made(angle: f64, rate_rad_s: f64, let_go_s: f64, is_held: bool, seed: u64) -> (String, f64) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut samples = Samples::default();
    let end_s = let_go_s + 0.35;
    let (half_m, across_m2) = (0.5 * LENGTH_M, RADIUS_M * RADIUS_M / 4.0);
    let about_m2 = across_m2 + LENGTH_M * LENGTH_M / 12.0 + half_m * half_m;
    let (mut angle, mut rate_rad_s) = (angle, rate_rad_s);
    let (mut position_m, mut velocity_m_s) = (Vector3::zeros(), Vector3::zeros());
    let steps = (end_s / STEP_S) as usize;
    for step in 0..=steps {
        let now_s = step as f64 * STEP_S;
        let arm = Vector3::new(-angle.sin(), 0.0, -angle.cos());
        if now_s < let_go_s {
            position_m = NAIL_M + arm * half_m;
            let along = Vector3::new(-angle.cos(), 0.0, angle.sin());
            velocity_m_s = along * (half_m * rate_rad_s);
        }
        if step % 800 == 0 {
            let orientation = UnitQuaternion::from_scaled_axis(Vector3::y() * angle);
            samples.add(now_s, &position_m, &orientation, &mut random);
        }
        if now_s < let_go_s && !is_held {
            rate_rad_s -= GRAVITY_M_S2 * half_m / about_m2 * angle.sin() * STEP_S;
        } else if now_s >= let_go_s {
            velocity_m_s.z -= GRAVITY_M_S2 * STEP_S;
            position_m += velocity_m_s * STEP_S;
        }
        angle += rate_rad_s * STEP_S;
    }
    (samples.csv, end_s)
}

/// A rod that flies until the nail catches its end, at an angle, with the velocity of its middle and a rate: what the nail
/// leaves is the turning about it.
fn caught(
    angle: f64,
    velocity_m_s: Vector3<f64>,
    rate_rad_s: f64,
    caught_s: f64,
    seed: u64,
) -> (String, f64) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut samples = Samples::default();
    let end_s = caught_s + 0.5;
    let half_m = 0.5 * LENGTH_M;
    let own_m2 = RADIUS_M * RADIUS_M / 4.0 + LENGTH_M * LENGTH_M / 12.0;
    let about_m2 = own_m2 + half_m * half_m;
    let arm = |angle: f64| Vector3::new(-angle.sin(), 0.0, -angle.cos()) * half_m;
    let momentum = own_m2 * rate_rad_s + arm(angle).cross(&velocity_m_s).y;
    let (mut swung, mut swinging_rad_s) = (angle, momentum / about_m2);
    for step in 0..=(end_s / STEP_S) as usize {
        let now_s = step as f64 * STEP_S;
        let since_s = now_s - caught_s;
        let (place_m, turned) = if since_s < 0.0 {
            let fallen = Vector3::z() * (-0.5 * GRAVITY_M_S2 * since_s * since_s);
            let place_m = NAIL_M + arm(angle) + velocity_m_s * since_s + fallen;
            (place_m, angle + rate_rad_s * since_s)
        } else {
            (NAIL_M + arm(swung), swung)
        };
        if step % 800 == 0 {
            let orientation = UnitQuaternion::from_scaled_axis(Vector3::y() * turned);
            samples.add(now_s, &place_m, &orientation, &mut random);
        }
        if since_s >= 0.0 {
            swinging_rad_s -= GRAVITY_M_S2 * half_m / about_m2 * swung.sin() * STEP_S;
            swung += swinging_rad_s * STEP_S;
        }
    }
    (samples.csv, end_s)
}

/// What the nail does to a rod that it catches so, by momentum.
fn assert_catch(event: &Value, angle: f64, velocity_m_s: Vector3<f64>, rate_rad_s: f64) {
    let half_m = 0.5 * LENGTH_M;
    let own_m2 = RADIUS_M * RADIUS_M / 4.0 + LENGTH_M * LENGTH_M / 12.0;
    let arm = Vector3::new(-angle.sin(), 0.0, -angle.cos()) * half_m;
    let turn = Vector3::y();
    let swinging_rad_s =
        (own_m2 * rate_rad_s + arm.cross(&velocity_m_s).y) / (own_m2 + half_m * half_m);
    let after = turn.cross(&arm) * swinging_rad_s;
    let impulse = (after - velocity_m_s) * 0.12;
    let end = velocity_m_s - turn.cross(&arm) * rate_rad_s;
    let impact = &event["impacts"][0];
    let told = |name: &str, axis: usize| impact[name][axis].as_f64().expect("a number");
    for axis in 0..3 {
        let off_n_s = (told("impulse_n_s", axis) - impulse[axis]).abs();
        assert!(off_n_s < 0.005, "{off_n_s} of {impulse}: {impact}");
        let off_m = (told("point_m", axis) - NAIL_M[axis]).abs();
        assert!(off_m < 1e-6, "{impact}");
        assert!(told("moment_n_m_s", axis).abs() < 2e-3, "{impact}");
    }
    assert!(told("moment_n_m_s", 1).abs() < 1e-9, "{impact}");
    let approach = impact["approach_m_s"].as_f64().expect("a number");
    assert!((approach - end.norm()).abs() < 0.05, "{end}: {impact}");
    assert_eq!(impact["contact"], "nail");
}

fn answer(tie: &str, csv: &str, [mark_s, end_s]: [f64; 2]) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    let marks = [(0.0, "go"), (mark_s, "let go"), (end_s - 0.01, "end")];
    replayed(folder.path(), &scene(tie), csv, &marks)
}

fn let_go(said: &Value) -> &Value {
    let events = said["events"].as_array().expect("events");
    let found = events.iter().find(|event| event["name"] == "let go");
    found.expect("the event")
}

#[test]
fn the_moment_in_which_a_pendulum_is_let_go_is_told() {
    let mut random = ChaCha8Rng::seed_from_u64(9500);
    for seed in 0..4 {
        let angle = random.random_range(-1.5..1.5);
        let rate_rad_s = random.random_range(-4.0..4.0);
        let let_go_s = random.random_range(0.4..0.9);
        let (csv, end_s) = made(angle, rate_rad_s, let_go_s, false, 9501 + seed);
        let mark_s = let_go_s + random.random_range(-0.03..0.03);
        let tie = format!("{JOINT}until = \"let go\"\n");
        let said = answer(&tie, &csv, [mark_s, end_s]);
        assert_eq!(said["verdict"], "physical", "{said}");
        assert_eq!(said["fits"], "yes", "{said}");
        let event = let_go(&said);
        assert_within(event, "time_s", "time_sd_s", let_go_s, 2e-3, "let go");
        assert_eq!(said["segments"][0]["phase"], "nail");
        // From the swing's own equation: the nail carries the weight and keeps the middle on its circle.
        let half_m = 0.5 * LENGTH_M;
        let about_m2 = RADIUS_M * RADIUS_M / 4.0 + LENGTH_M * LENGTH_M / 3.0;
        let slowed_rad_s2 = -GRAVITY_M_S2 * half_m * angle.sin() / about_m2;
        let (along, inward) = (half_m * slowed_rad_s2, half_m * rate_rad_s * rate_rad_s);
        let level_m_s2 = inward * angle.sin() - along * angle.cos();
        let up_m_s2 = along * angle.sin() + inward * angle.cos() + GRAVITY_M_S2;
        let borne_n = 0.12 * level_m_s2.hypot(up_m_s2);
        let told_n = said["segments"][0]["pivot_n"]["at_start"].as_f64();
        let off_n = (told_n.expect("a force") - borne_n).abs();
        assert!(off_n < 0.05, "{off_n} of {borne_n} N");
        assert_eq!(said["segments"][1]["pivot_n"], Value::Null);
        assert_eq!(said["segments"][1]["phase"], Value::Null);
    }
}

#[test]
fn what_is_held_still_falls_from_the_moment_in_which_it_is_let_go() {
    let (csv, end_s) = made(0.6, 0.0, 0.5, true, 9510);
    let held = "[[phase]]\nname = \"held\"\nmotion = \"rest\"\nbody = \"rod\"\nfrom = \"go\"\nuntil = \"let go\"\n";
    let said = answer(held, &csv, [0.53, end_s]);
    assert_eq!(said["verdict"], "physical", "{said}");
    assert_eq!(said["fits"], "yes", "{said}");
    assert_within(let_go(&said), "time_s", "time_sd_s", 0.5, 2e-3, "let go");
    let weight_n = 0.12 * GRAVITY_M_S2;
    assert_force(&said["segments"][0]["pivot_n"], [weight_n; 2], 1e-3);
    // It moved until then.
    let (csv, end_s) = made(0.6, 2.0, 0.5, false, 9511);
    let said = answer(held, &csv, [0.53, end_s]);
    assert_ne!(said["fits"], "yes", "{said}");
}

#[test]
fn a_nail_catches_what_flies_and_leaves_its_turning_about_it() {
    let mut random = ChaCha8Rng::seed_from_u64(9530);
    for seed in 0..4 {
        let angle = random.random_range(-1.0..1.0);
        let [x, z] = [(); 2].map(|()| random.random_range(-1.5..1.5));
        let rate_rad_s = random.random_range(-8.0..8.0);
        let caught_s = random.random_range(0.3..0.5);
        let velocity_m_s = Vector3::new(x, 0.0, z);
        let (csv, end_s) = caught(angle, velocity_m_s, rate_rad_s, caught_s, 9531 + seed);
        let mark_s = caught_s + random.random_range(-0.03..0.03);
        let tie = format!("{JOINT}from = \"let go\"\n");
        let said = answer(&tie, &csv, [mark_s, end_s]);
        assert_eq!(said["verdict"], "physical", "{said}");
        assert_eq!(said["fits"], "yes", "{said}");
        let event = let_go(&said);
        assert_within(event, "time_s", "time_sd_s", caught_s, 2e-3, "caught");
        assert_catch(event, angle, velocity_m_s, rate_rad_s);
        // Held still, it would not swing.
        let held = "[[phase]]\nname = \"held\"\nmotion = \"rest\"\nbody = \"rod\"\nfrom = \"let go\"\nuntil = \"end\"\n";
        let said = answer(held, &csv, [mark_s, end_s]);
        assert_ne!(said["fits"], "yes", "{said}");
    }
}

#[test]
fn what_hangs_elsewhere_or_not_at_all_does_not_fit() {
    let tie = format!("{JOINT}until = \"let go\"\n");
    let (csv, end_s) = made(0.9, 1.0, 0.6, false, 9520);
    let said = answer(&tie.replace("200, 1200]", "200, 1215]"), &csv, [0.6, end_s]);
    assert_ne!(said["fits"], "yes", "{said}");
    // It flies from the beginning.
    let (csv, end_s) = made(0.9, 3.0, 0.0, false, 9521);
    let said = answer(&tie, &csv, [0.2, end_s]);
    assert_ne!(said["fits"], "yes", "{said}");
}

#[test]
fn joints_that_cannot_end_are_refused_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let tie = format!("{JOINT}until = \"let go\"\n");
    let fixed =
        "[[joint]]\nname = \"glue\"\nkind = \"fixed\"\nchild = \"rod\"\nuntil = \"let go\"\n";
    let held = "[[phase]]\nname = \"held\"\nmotion = \"rest\"\nbody = \"rod\"\nfrom = \"go\"\nuntil = \"let go\"\n";
    for (tie, expected) in [
        (fixed.to_owned(), "a pin or a ball joint"),
        (
            tie.clone() + "stiffness_n_m = 1\n",
            "neither a spring nor limits",
        ),
        (
            tie.clone() + "limits_deg = [[-10, 10]]\n",
            "neither a spring nor limits",
        ),
        (
            tie.replace("until = \"let go\"", "until = \"go\""),
            "it ends before it begins",
        ),
        (
            tie.replace("until = \"let go\"", "until = \"soon\""),
            "unknown event \"soon\"",
        ),
        (
            tie.clone() + &JOINT.replace("\"nail\"", "\"second\""),
            "joined to something",
        ),
        (tie.clone() + held, "of one body at one time"),
        (
            tie.clone() + &held.replace("\"held\"", "\"nail\""),
            "name of its own",
        ),
        (held.replace("rest", "roll"), "missing key `surface`"),
        (
            held.to_owned() + "friction = 0.1\n",
            "missing key `surface`",
        ),
        (tie + "[[free]]\nquantity = \"nail.parent.x\"\n", "nail"),
    ] {
        std::fs::write(folder.path().join("scene.toml"), scene(&tie)).expect("a scene");
        let ran = enact(folder.path(), &["scene", "check", "scene.toml"]);
        let said = String::from_utf8_lossy(&ran.stderr);
        assert!(
            !ran.status.success() && said.contains(expected),
            "{tie}\n{expected}: {said}"
        );
    }
}

#[test]
fn what_is_tied_to_the_end_is_not_continued() {
    let folder = tempfile::tempdir().expect("a folder");
    let tied = scene(&format!("{JOINT}from = \"let go\"\n"));
    let refused = |arguments: &[&str], expected: &str| {
        let ran = enact(folder.path(), arguments);
        let said = String::from_utf8_lossy(&ran.stderr);
        assert!(!ran.status.success() && said.contains(expected), "{said}");
    };
    let settling = tied.replace("[timing]", "settle_s = 3\n[timing]");
    std::fs::write(folder.path().join("scene.toml"), settling).expect("a scene");
    refused(
        &["scene", "check", "scene.toml"],
        "what follows is not known",
    );
    std::fs::write(folder.path().join("scene.toml"), tied).expect("a scene");
    let (csv, end_s) = caught(0.3, Vector3::x(), 2.0, 0.4, 9540);
    std::fs::write(folder.path().join("poses.csv"), csv).expect("a table");
    let end = format!("{}:end", end_s - 0.01);
    let import = "import poses.csv --scene scene.toml -o take.mcap --mark 0:go";
    let mut import: Vec<&str> = import.split(' ').collect();
    import.extend(["--mark", "0.4:let go", "--mark", &end]);
    assert!(enact(folder.path(), &import).status.success());
    refused(
        &["predict", "take.mcap"],
        "\"nail\" ties \"rod\" until \"end\"",
    );
}
