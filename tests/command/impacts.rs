//! Impacts and forces of phases through the program: balls that bounce with friction, whose truth has a closed form, and
//! what surfaces and pivots bear.

use std::path::Path;

use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

use crate::phases::{GRAVITY_M_S2, Samples, replayed};
use crate::program::enact;

const MASS_KG: f64 = 0.17;
const RADIUS_M: f64 = 0.03;

fn number(of: &Value) -> f64 {
    of.as_f64().unwrap_or_else(|| panic!("a number: {of}"))
}

/// The velocity of a ball's lowest point.
fn lowest_m_s(velocity_m_s: &Vector3<f64>, spin_rad_s: &Vector3<f64>) -> Vector3<f64> {
    velocity_m_s + spin_rad_s.cross(&(Vector3::z() * -RADIUS_M))
}

#[test]
fn a_ball_tells_how_it_hit_the_table() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mut slid, mut gripped) = (0, 0);
    for seed in 0..6 {
        let mut random = ChaCha8Rng::seed_from_u64(9800 + seed);
        let (restitution, friction) = (
            random.random_range(0.6..0.9),
            random.random_range(0.05..0.5),
        );
        let before = Vector3::new(
            random.random_range(-1.5..1.5),
            random.random_range(-1.5..1.5),
            random.random_range(-3.0..-2.0),
        );
        let spin = Vector3::from_fn(|_, _| random.random_range(-30.0..30.0));
        // Coulomb's law at one contact: slip ends, or friction is as great as it may be.
        let slip = lowest_m_s(&before, &spin);
        let slip = Vector3::new(slip.x, slip.y, 0.0);
        let pressed_n_s = (1.0 + restitution) * MASS_KG * -before.z;
        let to_end_n_s = 2.0 / 7.0 * MASS_KG * slip.norm();
        let rubbed_n_s = (friction * pressed_n_s).min(to_end_n_s);
        slid += usize::from(rubbed_n_s < to_end_n_s);
        gripped += usize::from(rubbed_n_s == to_end_n_s);
        let impulse = Vector3::z() * pressed_n_s - slip.normalize() * rubbed_n_s;
        let after = before + impulse / MASS_KG;
        let inertia = 0.4 * MASS_KG * RADIUS_M * RADIUS_M;
        let spin_after = spin + (Vector3::z() * -RADIUS_M).cross(&impulse) / inertia;
        // Flights on both sides.
        let hit_s = 0.35;
        let g = Vector3::z() * -GRAVITY_M_S2;
        let at_m = Vector3::new(0.1, -0.2, RADIUS_M);
        let touched_m = [at_m.x, at_m.y, 0.0];
        let hit_turn = UnitQuaternion::from_euler_angles(0.3, -0.5, 1.1);
        let mut samples = Samples::default();
        for step in 0..=114 {
            let since_s = f64::from(step) * 0.005 - hit_s;
            let (v, w) = if since_s < 0.0 {
                (before, spin)
            } else {
                (after, spin_after)
            };
            let place_m = at_m + v * since_s + g * (0.5 * since_s * since_s);
            let turn = UnitQuaternion::from_scaled_axis(w * since_s) * hit_turn;
            samples.add(since_s + hit_s, &place_m, &turn, &mut random);
        }
        let scene = format!(
            "name = \"ball\"\nhand = \"none\"\n[timing]\nstamps = \"physical\"\n\
             [[body]]\nname = \"thing\"\nshape = {{ kind = \"sphere\", radius_mm = 30 }}\nmass_g = 170\n\
             restitution = {restitution}\nfriction = {friction}\n\
             [[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
             [[event]]\nname = \"go\"\nkind = \"start\"\n\
             [[event]]\nname = \"hit\"\nkind = \"collision\"\nbody = \"thing\"\nsurface = \"table\"\n\
             [[event]]\nname = \"end\"\nkind = \"end\"\n"
        );
        let marks = [(0.0, "go"), (hit_s + 0.004, "hit"), (0.57, "end")];
        let said = replayed(folder.path(), &scene, &samples.csv, &marks);
        assert_eq!(said["verdict"], "physical", "{seed}: {said}");
        let impact = &said["events"][1]["impacts"][0];
        for (told, truth) in [
            (&impact["approach_m_s"], -before.z),
            (&impact["slip_m_s"], slip.norm()),
            (&impact["parting_m_s"], restitution * -before.z),
            (&impact["slip_after_m_s"], {
                let left = lowest_m_s(&after, &spin_after);
                Vector3::new(left.x, left.y, 0.0).norm()
            }),
        ] {
            let off = (number(told) - truth).abs();
            assert!(off < 0.02, "{seed}: {told} for {truth}: {impact}");
        }
        for axis in 0..3 {
            let told = number(&impact["impulse_n_s"][axis]);
            let off = (told - impulse[axis]).abs() / impulse.norm();
            assert!(off < 0.01, "{seed}: {told} for {impulse}");
            let off_m = (number(&impact["point_m"][axis]) - touched_m[axis]).abs();
            assert!(off_m < 0.001, "{seed}: {impact}");
        }
    }
    assert!(slid > 0 && gripped > 0, "{slid} {gripped}");
}

/// Asserts a force at the beginning and at the end of a phase [N].
pub(crate) fn assert_force(of: &Value, ends_n: [f64; 2], most_n: f64) {
    for (end, truth_n) in ["at_start", "at_end"].iter().zip(ends_n) {
        let off_n = (number(&of[end]) - truth_n).abs();
        assert!(off_n < most_n, "{end} {truth_n}: {of}");
    }
}

/// A table of events, and the keys of one body, of the take that was replayed last.
pub(crate) fn exported(folder: &Path) -> [Vec<Vec<String>>; 2] {
    [("events", "x.events.csv"), ("csv", "x.csv")].map(|(to, name)| {
        let arguments = [
            "export",
            "take.estimate.mcap",
            "--fps",
            "24",
            "--to",
            to,
            "-o",
            name,
        ];
        let ran = enact(folder, &arguments);
        let said = String::from_utf8_lossy(&ran.stderr);
        assert!(ran.status.success(), "{said}");
        let text = std::fs::read_to_string(folder.join(name)).expect("a table");
        let lines = text.lines().filter(|line| !line.starts_with('#')).skip(1);
        lines
            .map(|line| line.split(',').map(str::to_owned).collect())
            .collect()
    })
}

/// Asserts the phases beside a change, and that keys of films have its very moment, with its name.
pub(crate) fn assert_change(folder: &Path, said: &Value, change: &str, phases: [&str; 2]) {
    let events = said["events"].as_array().expect("events");
    let event = events.iter().find(|event| event["name"] == change);
    let event = event.expect("the change");
    assert_eq!(event["impacts"], serde_json::json!([]));
    let [table, keys] = exported(folder);
    let row = table.iter().find(|row| row[3] == change).expect("its row");
    assert_eq!(row[0].parse::<f64>().ok(), event["time_s"].as_f64());
    assert_eq!((row[4].as_str(), row[5].as_str()), ("change", "thing"));
    assert_eq!([row[7].as_str(), row[8].as_str()], phases);
    let key = keys.iter().find(|key| key[4] == change).expect("its key");
    assert_eq!(key[1], row[2], "one stamp");
}
