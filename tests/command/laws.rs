//! Laws of contacts and of the air through the program: their truth is made by formulas and small steps of these tests.

use std::path::Path;

use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

use crate::phases::{GRAVITY_M_S2, Samples, assert_within, replayed};
use crate::program::enact;

/// A ball of 30 mm that hits a table, with further keys of its own and of its collision.
fn scene(of_ball: &str, of_hit: &str, free: &str) -> String {
    let hit =
        "[[event]]\nname = \"hit\"\nkind = \"collision\"\nbody = \"ball\"\nsurface = \"table\"\n";
    thrown(of_ball, &format!("{hit}{of_hit}"), free)
}

/// The same with these events between its start and its end.
fn thrown(of_ball: &str, events: &str, free: &str) -> String {
    format!(
        "name = \"a ball\"\nhand = \"none\"\n[timing]\nstamps = \"physical\"\n\
         [[body]]\nname = \"ball\"\nshape = {{ kind = \"sphere\", radius_mm = 30 }}\nmass_g = 60\n{of_ball}\
         [[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
         [[event]]\nname = \"go\"\nkind = \"start\"\n\
         {events}\
         [[event]]\nname = \"end\"\nkind = \"end\"\n{free}"
    )
}

/// A ball that turns as it was thrown, falls onto the table and leaves it `restitution` times as fast: its samples, and when it
/// hits and ends.
fn bounced(restitution: f64, random: &mut ChaCha8Rng) -> (String, [f64; 2]) {
    let level = Vector3::new(random.random_range(-0.8..0.8), 0.5, 0.0);
    let spin = Vector3::from_fn(|_, _| random.random_range(-10.0..10.0));
    let fall_m: f64 = random.random_range(0.2..0.5);
    let hit_s = (2.0 * fall_m / GRAVITY_M_S2).sqrt();
    let up_m_s = restitution * GRAVITY_M_S2 * hit_s;
    let end_s = hit_s + 0.4;
    let mut samples = Samples::default();
    for sample in 0..=(end_s / 0.005) as usize {
        let now_s = sample as f64 * 0.005;
        let since_s = now_s - hit_s;
        let height_m = match since_s < 0.0 {
            true => fall_m - 0.5 * GRAVITY_M_S2 * now_s * now_s,
            false => (up_m_s - 0.5 * GRAVITY_M_S2 * since_s) * since_s,
        };
        let position_m = level * now_s + Vector3::z() * (0.03 + height_m);
        let turned = UnitQuaternion::from_scaled_axis(spin * now_s);
        samples.add(now_s, &position_m, &turned, random);
    }
    (samples.csv, [hit_s, end_s - 0.006])
}

fn answer(folder: &Path, scene: &str, csv: &str, [hit_s, end_s]: [f64; 2]) -> Value {
    replayed(
        folder,
        scene,
        csv,
        &[(0.0, "go"), (hit_s, "hit"), (end_s, "end")],
    )
}

fn assert_right(said: &Value, what: &str) {
    assert_eq!(
        (&said["verdict"], &said["fits"]),
        (&"physical".into(), &"yes".into()),
        "{what}: {said}"
    );
}

/// Only where an event says that it is a bumper, and with as much as that gives.
#[test]
fn a_bumper_gives_energy_where_a_scene_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let free = "[[free]]\nquantity = \"hit.restitution\"\n";
    for (seed, restitution) in [(0, 1.3), (1, 1.6), (2, 1.15), (3, 0.8)] {
        let mut random = ChaCha8Rng::seed_from_u64(9700 + seed);
        let (csv, [hit_s, end_s]) = bounced(restitution, &mut random);
        let marks_s = [hit_s + random.random_range(-0.01..0.01), end_s];
        let asked =
            |of: &str, free: &str| answer(folder.path(), &scene("", of, free), &csv, marks_s);
        let said = asked("restitution = 1.2\nbumper = true\n", free);
        assert_right(&said, &format!("{seed}"));
        assert_within(
            &said["parameters"]["hit.restitution"],
            "value",
            "sd",
            restitution,
            0.02,
            "the bumper",
        );
        // With its restitution given, and with one that is another.
        let given = asked(&format!("restitution = {restitution}\nbumper = true\n"), "");
        assert_right(&given, &format!("{seed}"));
        let wrong = asked(
            &format!("restitution = {}\nbumper = true\n", restitution + 0.3),
            "",
        );
        assert_ne!(wrong["fits"], "yes", "{seed}: {wrong}");
        // What does not say so loses energy.
        let plain = asked("restitution = 0.9\n", free);
        let is_right = plain["verdict"] == "physical" && plain["fits"] == "yes";
        assert_eq!(is_right, restitution < 1.0, "{seed}: {plain}");
    }
    let text = scene("", "restitution = 1.3\n", "");
    std::fs::write(folder.path().join("plain.toml"), text).expect("a scene");
    let ran = enact(folder.path(), &["scene", "check", "plain.toml"]);
    let said = String::from_utf8_lossy(&ran.stderr);
    assert!(!ran.status.success());
    assert!(
        said.contains("restitution is 1.3, expected 0 to 1"),
        "{said}"
    );
    assert!(said.contains("bumper = true"), "{said}");
}

/// A ball that drag slows and lift bends, by the classic Runge–Kutta method in steps of a tenth of a millisecond: its samples.
fn curved(
    [lift, drag_per_m]: [f64; 2],
    velocity_m_s: &Vector3<f64>,
    spin_rad_s: &Vector3<f64>,
    random: &mut ChaCha8Rng,
) -> String {
    let rate = |v: &Vector3<f64>| {
        Vector3::z() * -GRAVITY_M_S2 + spin_rad_s.cross(v) * lift - v * (drag_per_m * v.norm())
    };
    let h = 1e-4;
    let (mut x, mut v) = (Vector3::new(0.2, -0.1, 2.0), *velocity_m_s);
    let mut samples = Samples::default();
    for step in 0..=8000_u32 {
        let now_s = f64::from(step) * h;
        if step % 50 == 0 {
            let turned = UnitQuaternion::from_scaled_axis(spin_rad_s * now_s);
            samples.add(now_s, &x, &turned, random);
        }
        let one = rate(&v);
        let two = rate(&(v + one * (0.5 * h)));
        let three = rate(&(v + two * (0.5 * h)));
        let four = rate(&(v + three * h));
        x += (v + (one + two + three) * (h / 6.0)) * h;
        v += (one + (two + three) * 2.0 + four) * (h / 6.0);
    }
    samples.csv
}

/// Within its interval of 95 % as often as that says, over thirty throws; and what nobody lifts does not curve so.
#[test]
fn a_ball_that_spins_curves_and_its_lift_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let marks = [(0.0, "go"), (0.8, "end")];
    let mut inside = 0;
    for seed in 0..30 {
        let mut random = ChaCha8Rng::seed_from_u64(9800 + seed);
        let lift = random.random_range(0.002..0.009);
        let drag_per_m = random.random_range(0.01..0.15);
        let velocity = Vector3::new(
            random.random_range(6.0..14.0),
            random.random_range(-2.0..2.0),
            random.random_range(1.0..4.0),
        );
        let spin = Vector3::from_fn(|_, _| random.random_range(-50.0..50.0));
        let csv = curved([lift, drag_per_m], &velocity, &spin, &mut random);
        let asked = |of_ball: &str, free: &str| {
            let scene = thrown(of_ball, "", free);
            replayed(folder.path(), &scene, &csv, &marks)
        };
        let free =
            "[[free]]\nquantity = \"ball.lift\"\n[[free]]\nquantity = \"ball.drag.quadratic\"\n";
        let said = asked("lift = 0.005\ndrag_quadratic_per_m = 0.05\n", free);
        assert_right(&said, &format!("{seed}"));
        let of = &said["parameters"]["ball.lift"];
        assert_within(of, "value", "sd", lift, 1e-3, "lift");
        let (value, sd) = (of["value"].as_f64(), of["sd"].as_f64());
        let (value, sd) = value.zip(sd).expect("asserted above");
        inside += usize::from((value - lift).abs() < 1.96 * sd);
        let of = &said["parameters"]["ball.drag.quadratic"];
        assert_within(of, "value", "sd", drag_per_m, 0.02, "drag");
        if seed < 3 {
            let known = format!("lift = {lift}\ndrag_quadratic_per_m = {drag_per_m}\n");
            assert_right(&asked(&known, ""), &format!("{seed}, known"));
            let drag = format!("drag_quadratic_per_m = {drag_per_m}\n");
            let straight = asked(&drag, "");
            assert_ne!(straight["fits"], "yes", "{seed}: {straight}");
            let opposite = asked(&format!("lift = {}\n{drag}", -lift), "");
            assert_ne!(opposite["fits"], "yes", "{seed}: {opposite}");
        }
    }
    assert!(inside >= 25, "{inside} of 30");
}

/// A solid ball of 30 mm that falls onto the table with backspin and bounces thrice, back and forth: flights in closed form,
/// impulses as of Garwin's superball. Its samples, when it hits and ends.
fn superball(restitution: f64, tangential: f64, random: &mut ChaCha8Rng) -> (String, Vec<f64>) {
    let r = 0.03;
    let g = Vector3::z() * -GRAVITY_M_S2;
    let mut x = Vector3::new(0.1, 0.0, r + random.random_range(0.3..0.45));
    let mut v = Vector3::new(
        random.random_range(0.9..1.4),
        random.random_range(-0.3..0.3),
        0.0,
    );
    let mut w = Vector3::new(
        random.random_range(-8.0..8.0),
        random.random_range(-75.0..-50.0),
        random.random_range(-8.0..8.0),
    );
    let mut q = UnitQuaternion::identity();
    let (mut now_s, mut sample) = (0.0, 0);
    let mut samples = Samples::default();
    let mut times_s = Vec::new();
    let mut turns_back = 0;
    for hit in 0..4 {
        let down_m_s = (v.z * v.z + 2.0 * GRAVITY_M_S2 * (x.z - r)).max(0.0).sqrt();
        let lasts_s = match hit {
            3 => 0.2,
            _ => (v.z + down_m_s) / GRAVITY_M_S2,
        };
        while f64::from(sample) * 0.005 <= now_s + lasts_s {
            let s = f64::from(sample) * 0.005 - now_s;
            let position_m = x + v * s + g * (0.5 * s * s);
            let turned = UnitQuaternion::from_scaled_axis(w * s) * q;
            samples.add(now_s + s, &position_m, &turned, random);
            sample += 1;
        }
        now_s += lasts_s;
        x += v * lasts_s + g * (0.5 * lasts_s * lasts_s);
        v += g * lasts_s;
        q = UnitQuaternion::from_scaled_axis(w * lasts_s) * q;
        times_s.push(now_s);
        if hit == 3 {
            break;
        }
        // Per mass; a solid ball's moment is 2/5 m r².
        let arm = Vector3::z() * -r;
        let mut slip = v + w.cross(&arm);
        slip.z = 0.0;
        let across = slip * (-(1.0 + tangential) * 2.0 / 7.0);
        let along = -(1.0 + restitution) * v.z;
        assert!(across.norm() < 0.8 * along, "it grips");
        let came = v.x;
        v += across + Vector3::z() * along;
        w += arm.cross(&across) / (0.4 * r * r);
        turns_back += usize::from(came * v.x < 0.0);
    }
    assert!(turns_back > 1, "it goes back and forth");
    let last = times_s.last_mut().expect("an end");
    *last -= 0.006;
    (samples.csv, times_s)
}

#[test]
fn a_superball_goes_back_and_forth_as_its_law_says() {
    let folder = tempfile::tempdir().expect("a folder");
    let hits = ["one", "two", "three"].map(|name| {
        format!("[[event]]\nname = \"{name}\"\nkind = \"collision\"\nbody = \"ball\"\nsurface = \"table\"\n")
    });
    let free = "[[free]]\nquantity = \"ball.restitution\"\n[[free]]\nquantity = \"ball.tangential_restitution\"\n";
    for seed in 0..6 {
        let mut random = ChaCha8Rng::seed_from_u64(9900 + seed);
        let is_elastic = seed == 5;
        let (restitution, tangential) = match is_elastic {
            true => (1.0, 1.0),
            false => (
                random.random_range(0.8..0.95),
                random.random_range(0.35..0.9),
            ),
        };
        let (csv, times_s) = superball(restitution, tangential, &mut random);
        let names = ["one", "two", "three", "end"];
        let mut marks = vec![(0.0, "go")];
        for (time_s, name) in times_s.iter().zip(names) {
            let off_s = match name {
                "end" => 0.0,
                _ => random.random_range(-0.006..0.006),
            };
            marks.push((time_s + off_s, name));
        }
        let asked = |of_ball: &str, free: &str| {
            let scene = thrown(of_ball, &hits.concat(), free);
            replayed(folder.path(), &scene, &csv, &marks)
        };
        let known = format!(
            "restitution = {restitution}\nfriction = 0.9\ntangential_restitution = {tangential}\n"
        );
        assert_right(&asked(&known, ""), &format!("{seed}, known"));
        let gripping = asked("restitution = 0.9\nfriction = 0.9\n", free_of_restitution());
        assert_ne!(gripping["fits"], "yes", "{seed}: {gripping}");
        if is_elastic {
            continue;
        }
        let said = asked(
            "restitution = 0.9\nfriction = 0.9\ntangential_restitution = 0.5\n",
            free,
        );
        assert_right(&said, &format!("{seed}"));
        for (name, truth) in [
            ("restitution", restitution),
            ("tangential_restitution", tangential),
        ] {
            let of = &said["parameters"][format!("ball.{name}")];
            assert_within(of, "value", "sd", truth, 0.02, name);
        }
    }
}

fn free_of_restitution() -> &'static str {
    "[[free]]\nquantity = \"ball.restitution\"\n"
}
