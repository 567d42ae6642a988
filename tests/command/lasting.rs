//! Contacts that last, through the program: their truth is made by a spring with a damper in small steps.

use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::phases::{GRAVITY_M_S2, STEP_S, Samples, assert_within, replayed};

const RADIUS_M: f64 = 0.03;
const MASS_KG: f64 = 0.06;

/// A ball that bounces on a soft mat, with friction while it slides there.
struct Bounced {
    csv: String,
    touch_s: f64,
    left_s: f64,
    /// Speed along the normal after, over that before.
    restitution: f64,
    second_s: f64,
}

/// The ball touches for about `contact_s`; the damper takes a share of the speed.
fn bounced(contact_s: f64, damping: f64, friction: f64, random: &mut ChaCha8Rng) -> Bounced {
    let stiffness_s2 = (std::f64::consts::PI / contact_s).powi(2);
    let damping_s = 2.0 * damping * stiffness_s2.sqrt();
    let mut x = Vector3::new(0.1, -0.2, random.random_range(0.4..0.8));
    let mut v = Vector3::new(
        random.random_range(1.0..2.0),
        random.random_range(-0.5..0.5),
        random.random_range(-1.0..0.0),
    );
    let mut q = UnitQuaternion::identity();
    let mut w = Vector3::from_fn(|_, _| random.random_range(-8.0..8.0));
    let mut samples = Samples::default();
    let (mut touches, mut leaves, mut speeds) = (Vec::new(), Vec::new(), Vec::new());
    let mut step = 0;
    // Until shortly before it would touch for the second time.
    loop {
        let now_s = step as f64 * STEP_S;
        if step % 400 == 0 {
            samples.add(now_s, &x, &q, random);
        }
        let depth_m = RADIUS_M - x.z;
        let was_touching = touches.len() > leaves.len();
        if depth_m > 0.0 && !was_touching {
            touches.push(now_s);
            speeds.push(v.z);
        }
        if depth_m <= 0.0 && was_touching {
            leaves.push(now_s);
            speeds.push(v.z);
        }
        if touches.len() == 2 {
            break;
        }
        let mut a = Vector3::z() * -GRAVITY_M_S2;
        if depth_m > 0.0 {
            let pushed = (stiffness_s2 * depth_m - damping_s * v.z).max(0.0);
            let arm = Vector3::z() * -RADIUS_M;
            let slip = v + w.cross(&arm);
            let slip = Vector3::new(slip.x, slip.y, 0.0);
            let rubbed = -slip / slip.norm() * friction * pushed;
            a += Vector3::z() * pushed + rubbed;
            w += arm.cross(&rubbed) * (STEP_S / (0.4 * RADIUS_M * RADIUS_M));
        }
        v += a * STEP_S;
        x += v * STEP_S;
        q = UnitQuaternion::from_scaled_axis(w * STEP_S) * q;
        step += 1;
    }
    Bounced {
        csv: samples.csv,
        touch_s: touches[0],
        left_s: leaves[0],
        restitution: -speeds[1] / speeds[0],
        second_s: touches[1],
    }
}

fn scene(friction: f64, more: &str) -> String {
    format!(
        "name = \"ball on a mat\"\nhand = \"none\"\n[timing]\nstamps = \"physical\"\n\
         [[body]]\nname = \"ball\"\nshape = {{ kind = \"sphere\", radius_mm = {} }}\nmass_g = {}\nrestitution = 0.7\n\
         friction = {friction}\n[[surface]]\nname = \"mat\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
         [[event]]\nname = \"go\"\nkind = \"start\"\n\
         [[event]]\nname = \"hit\"\nkind = \"collision\"\nbody = \"ball\"\nsurface = \"mat\"\n\
         [[event]]\nname = \"end\"\nkind = \"end\"\n[[free]]\nquantity = \"ball.restitution\"\n{more}",
        RADIUS_M * 1e3,
        MASS_KG * 1e3
    )
}

const LASTS: &str = "[[free]]\nquantity = \"hit.contact_duration\"\n";

#[test]
fn how_long_a_contact_lasts_and_its_restitution_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    for seed in 0..10 {
        let mut random = ChaCha8Rng::seed_from_u64(9900 + seed);
        let contact_s = random.random_range(0.004_f64.ln()..0.04_f64.ln()).exp();
        let friction = random.random_range(0.005..0.02);
        let damping = random.random_range(0.02..0.15);
        let made = bounced(contact_s, damping, friction, &mut random);
        let off_s = random.random_range(-0.02..0.02);
        let end_s = made.second_s - 0.01;
        let marks = [(0.0, "go"), (made.touch_s + off_s, "hit"), (end_s, "end")];
        let said = replayed(folder.path(), &scene(friction, LASTS), &made.csv, &marks);
        let what = format!("{seed}: {contact_s} s");
        assert_eq!(
            (&said["verdict"], &said["fits"]),
            (&"physical".into(), &"yes".into()),
            "{what}: {said}"
        );
        let of = &said["parameters"];
        let lasted_s = made.left_s - made.touch_s;
        assert_within(
            &of["hit.contact_duration"],
            "value",
            "sd",
            lasted_s,
            0.001,
            &what,
        );
        assert_within(
            &of["ball.restitution"],
            "value",
            "sd",
            made.restitution,
            0.01,
            &what,
        );
        assert_within(
            &said["events"][1],
            "time_s",
            "time_sd_s",
            made.touch_s,
            0.001,
            &what,
        );
    }
}

#[test]
fn a_contact_of_one_moment_is_told_as_such() {
    let folder = tempfile::tempdir().expect("a folder");
    for seed in 0..3 {
        let mut random = ChaCha8Rng::seed_from_u64(9950 + seed);
        let made = bounced(0.0004, 0.05, 0.02, &mut random);
        let end_s = made.second_s - 0.01;
        let marks = [(0.0, "go"), (made.touch_s, "hit"), (end_s, "end")];
        let said = replayed(folder.path(), &scene(0.02, LASTS), &made.csv, &marks);
        assert_eq!(said["verdict"], "physical", "{said}");
        let lasts_s = said["parameters"]["hit.contact_duration"]["value"].as_f64();
        assert!(lasts_s.is_some_and(|lasts_s| lasts_s < 0.001), "{said}");
    }
}

#[test]
fn a_contact_that_lasts_is_suspected_beside_what_it_looks_like() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut random = ChaCha8Rng::seed_from_u64(9960);
    let made = bounced(0.03, 0.1, 0.02, &mut random);
    let end_s = made.second_s - 0.01;
    let marks = [(0.0, "go"), (made.touch_s, "hit"), (end_s, "end")];
    let said = replayed(folder.path(), &scene(0.02, ""), &made.csv, &marks);
    assert_ne!(said["fits"], "yes", "{said}");
    let suspects = said["suspects"].as_array().expect("suspects");
    let named = |of: &&serde_json::Value| of["quantity"] == "hit.contact_duration";
    let lasting = suspects
        .iter()
        .find(named)
        .and_then(|of| of["value"].as_f64());
    let lasted_s = made.left_s - made.touch_s;
    assert!(
        lasting.is_some_and(|lasting_s| (lasting_s - lasted_s).abs() < 0.2 * lasted_s),
        "{lasted_s}: {said}"
    );
}

#[test]
fn a_contact_after_which_a_phase_begins_is_one_moment() {
    let folder = tempfile::tempdir().expect("a folder");
    let phase = "[[phase]]\nname = \"rolling\"\nmotion = \"roll\"\nbody = \"ball\"\nsurface = \"mat\"\nfriction = 0.01\nfrom = \"hit\"\nuntil = \"end\"\n";
    let text = scene(0.1, &format!("{LASTS}{phase}"))
        .replace("restitution = 0.7", "restitution = 0.0")
        .replace("[[free]]\nquantity = \"ball.restitution\"\n", "");
    std::fs::write(folder.path().join("scene.toml"), text).expect("a scene");
    let ran = crate::program::enact(folder.path(), &["scene", "check", "scene.toml"]);
    let said = String::from_utf8_lossy(&ran.stderr);
    assert!(!ran.status.success());
    assert!(said.contains("its contact is one moment"), "{said}");
}
