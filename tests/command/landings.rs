//! Flat landings through the program: their truth is made by forces in small steps.

use std::path::Path;

use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

use crate::impacts::{assert_change, assert_force};
use crate::phases::{GRAVITY_M_S2, STEP_S, Samples, assert_within, phase, replayed};

/// A box that flies, lands flat on the level table, slides and rests: flights in closed form, friction in small steps.
/// `friction` at the landing and after it.
pub(crate) fn thrown(
    friction: f64,
    velocity_m_s: Vector3<f64>,
    yaw_rad_s: f64,
    random: &mut ChaCha8Rng,
) -> Thrown {
    let gyration_m = ((0.12_f64.powi(2) + 0.08_f64.powi(2)) / 12.0).sqrt();
    let g = Vector3::z() * -GRAVITY_M_S2;
    let (mut x, mut v) = (Vector3::new(0.1, -0.2, 0.25), velocity_m_s);
    let (mut q, mut yaw) = (UnitQuaternion::identity(), yaw_rad_s);
    let mut samples = Samples::default();
    let (mut landed_s, mut still_s) = (None, None);
    let (mut arriving_m_s, mut landed) = (Vector3::zeros(), 1.0);
    let end_s = 2.0;
    for step in 0..=(end_s / STEP_S).round() as usize {
        let now_s = step as f64 * STEP_S;
        if step % 500 == 0 {
            samples.add(now_s, &x, &q, random);
        }
        if landed_s.is_none() && x.z + v.z * STEP_S < 0.02 {
            landed_s = Some(now_s);
            let both = Vector3::new(v.x, v.y, gyration_m * yaw);
            let left = (1.0 - friction * -v.z / both.norm()).max(0.0);
            (arriving_m_s, landed) = (v, left);
            v = Vector3::new(v.x * left, v.y * left, 0.0);
            yaw *= left;
            x.z = 0.02;
        }
        if landed_s.is_some() {
            let both = Vector3::new(v.x, v.y, gyration_m * yaw);
            let slowed = friction * GRAVITY_M_S2 * STEP_S;
            let left = if both.norm() > slowed {
                1.0 - slowed / both.norm()
            } else {
                0.0
            };
            if left == 0.0 {
                still_s.get_or_insert(now_s);
            }
            (v, yaw) = (v * left, yaw * left);
            x += v * STEP_S;
        } else {
            x += v * STEP_S + g * (0.5 * STEP_S * STEP_S);
            v += g * STEP_S;
        }
        q = UnitQuaternion::from_scaled_axis(Vector3::z() * (yaw * STEP_S)) * q;
    }
    Thrown {
        arriving_m_s,
        left: landed,
        csv: samples.csv,
        landed_s: landed_s.expect("it lands"),
        still_s: still_s.expect("it rests"),
        end_s,
    }
}

pub(crate) struct Thrown {
    /// Velocity and yaw before the landing, and which share of both friction leaves.
    arriving_m_s: Vector3<f64>,
    left: f64,
    pub(crate) csv: String,
    landed_s: f64,
    still_s: f64,
    end_s: f64,
}

/// The answer about a thrown box, with the marks of its landing and of its rest.
fn answer_of_thrown(
    folder: &Path,
    size_mm: &str,
    phases: &str,
    thrown: &Thrown,
    off_s: f64,
) -> Value {
    let slides = phases.contains("\"slide\"");
    let still = "[[event]]\nname = \"still\"\nkind = \"change\"\nbody = \"thing\"\n";
    let scene = format!(
        "name = \"thrown\"\nhand = \"none\"\n[timing]\nstamps = \"physical\"\n\
         [[body]]\nname = \"thing\"\nshape = {{ kind = \"cuboid\", size_mm = {size_mm} }}\nmass_g = 170\nrestitution = 0\nfriction = 0.3\n\
         [[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
         [[event]]\nname = \"go\"\nkind = \"start\"\n\
         [[event]]\nname = \"land\"\nkind = \"collision\"\nbody = \"thing\"\nsurface = \"table\"\nfeature = \"face -z\"\n\
         {}[[event]]\nname = \"end\"\nkind = \"end\"\n{phases}",
        if slides { still } else { "" },
    );
    let mut marks = vec![(0.0, "go"), (thrown.landed_s + off_s, "land")];
    marks.extend(slides.then_some((thrown.still_s - off_s, "still")));
    marks.push((thrown.end_s, "end"));
    replayed(folder, &scene, &thrown.csv, &marks)
}

const FACE: &str = "feature = \"face -z\"\n";

#[test]
fn a_box_lands_flat_slides_and_rests() {
    let folder = tempfile::tempdir().expect("a folder");
    let phases = phase("sliding", "slide", FACE, ["land", "still"])
        + &phase("lying", "rest", FACE, ["still", "end"])
        + "[[free]]\nquantity = \"thing.friction\"\n";
    for seed in 0..6 {
        let mut random = ChaCha8Rng::seed_from_u64(9400 + seed);
        let friction = random.random_range(0.15..0.45);
        let velocity = Vector3::new(
            random.random_range(1.8..2.6),
            random.random_range(-0.8..0.8),
            random.random_range(-0.3..0.5),
        );
        let yaw_rad_s = random.random_range(-6.0..6.0);
        let thrown = thrown(friction, velocity, yaw_rad_s, &mut random);
        let off_s = random.random_range(-0.01..0.01);
        let said = answer_of_thrown(folder.path(), "[120, 80, 40]", &phases, &thrown, off_s);
        assert_eq!(
            (&said["verdict"], &said["fits"]),
            (&"physical".into(), &"yes".into()),
            "{seed}: {said}"
        );
        for (event, truth) in [(1, thrown.landed_s), (2, thrown.still_s)] {
            let of = &said["events"][event];
            assert_within(of, "time_s", "time_sd_s", truth, 0.02, "an event");
        }
        let of = &said["parameters"]["thing.friction"];
        assert_within(of, "value", "sd", friction, 0.02, "friction");
        assert_landing(&said, &thrown, yaw_rad_s, friction);
        assert_change(folder.path(), &said, "still", ["sliding", "lying"]);
        // Each piece says what it is, and how certain it is.
        let segments = said["segments"].as_array().expect("segments");
        let names: Vec<_> = segments.iter().map(|of| of["phase"].as_str()).collect();
        assert_eq!(names, [None, Some("sliding"), Some("lying")]);
        for along in said["certainty"].as_array().expect("certainty") {
            let of = &along["position_sd_mm"]["largest"];
            let sd_mm = of.as_f64().unwrap_or_else(|| panic!("{seed}: {along}"));
            assert!(sd_mm < 2.0, "{seed}: {along}");
        }
    }
}

/// The landing and the phases after it, in impulses and forces.
fn assert_landing(said: &Value, thrown: &Thrown, yaw_rad_s: f64, friction: f64) {
    const MASS_KG: f64 = 0.17;
    let impacts = said["events"][1]["impacts"].as_array().expect("impacts");
    assert_eq!(impacts.len(), 1);
    let impact = &impacts[0];
    let v = thrown.arriving_m_s;
    let lost = 1.0 - thrown.left;
    let about_kg_m2 = MASS_KG * (0.12_f64.powi(2) + 0.08_f64.powi(2)) / 12.0;
    let twist = -about_kg_m2 * yaw_rad_s * lost;
    for (told, truth, most) in [
        (&impact["approach_m_s"], -v.z, 0.02),
        (&impact["parting_m_s"], 0.0, 1e-9),
        (&impact["moment_n_m_s"][2], twist, 5e-5),
    ] {
        let told = told.as_f64().expect("a number");
        assert!((told - truth).abs() < most, "{told} {truth}: {impact}");
    }
    for (axis, truth) in [-v.x * lost, -v.y * lost, -v.z].iter().enumerate() {
        let told = impact["impulse_n_s"][axis].as_f64().expect("a number");
        assert!((told - MASS_KG * truth).abs() < 0.01, "{truth}: {impact}");
    }
    let weight_n = MASS_KG * GRAVITY_M_S2;
    let [slides, lies] = [1, 2].map(|at| &said["segments"][at]);
    for phase in [slides, lies] {
        assert_force(&phase["normal_n"], [weight_n; 2], 1e-3);
    }
    assert_force(&lies["friction_n"], [0.0; 2], 1e-9);
    // Of velocity and yaw friction takes in proportion.
    let level_m_s = v.x.hypot(v.y);
    let both_m_s = level_m_s.hypot((about_kg_m2 / MASS_KG).sqrt() * yaw_rad_s);
    let rubbed_n = friction * weight_n * level_m_s / both_m_s;
    assert_force(&slides["friction_n"], [rubbed_n; 2], 0.06 * weight_n);
}

/// Where friction is enough for the speed with which it comes down, a box lies where it lands; where it is not, a rest is
/// not there.
#[test]
fn a_box_lies_where_it_lands_if_friction_stops_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let rests = phase("lying", "rest", FACE, ["land", "end"]);
    for (seed, level_m_s, friction, stops) in [
        (0, 0.3, 0.6, true),
        (1, 0.4, 0.5, true),
        (2, 1.6, 0.3, false),
        (3, 1.0, 0.2, false),
    ] {
        let mut random = ChaCha8Rng::seed_from_u64(9500 + seed);
        let velocity = Vector3::new(level_m_s, 0.0, 0.2);
        let thrown = thrown(friction, velocity, 0.5, &mut random);
        let said = answer_of_thrown(folder.path(), "[120, 80, 40]", &rests, &thrown, 0.004);
        let is_right = said["verdict"] == "physical" && said["fits"] == "yes";
        assert_eq!(is_right, stops, "{seed}: {said}");
    }
}

/// What is tall and lands on a rough table would tip over its leading edge: that it slides standing is no motion.
#[test]
fn what_would_tip_is_not_said_to_slide() {
    let folder = tempfile::tempdir().expect("a folder");
    let phases = phase("sliding", "slide", FACE, ["land", "still"])
        + &phase("lying", "rest", FACE, ["still", "end"])
        + "[[free]]\nquantity = \"thing.friction\"\n";
    let mut random = ChaCha8Rng::seed_from_u64(9600);
    let thrown = thrown(0.4, Vector3::new(1.6, 0.0, 0.2), 0.0, &mut random);
    // The same motion of the same middle: of a box whose edges are 6 mm from it, not 40.
    for (size_mm, is_there) in [("[80, 80, 40]", true), ("[12, 12, 40]", false)] {
        let said = answer_of_thrown(folder.path(), size_mm, &phases, &thrown, 0.004);
        assert_eq!(said["verdict"] == "physical", is_there, "{size_mm}: {said}");
        let doubts = said["doubts"].as_array().expect("doubts");
        let tips = doubts
            .iter()
            .any(|of| of["quantity"] == "tips" || of["quantity"] == "pull");
        assert_eq!(tips, !is_there, "{size_mm}: {said}");
    }
}
