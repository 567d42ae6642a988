//! What swings on a nail.

use nalgebra::{UnitQuaternion, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{CHANGE, GRAVITY_M_S2, MadeMotion, STEP_S, between, body, event};

/// How long it flies \[s\].
const FLOWN_S: f64 = 0.35;

pub(super) fn let_go(random: &mut ChaCha8Rng) -> MadeMotion {
    let (length_m, radius_m) = (between(random, 0.15, 0.8), 0.005);
    let half_m = 0.5 * length_m;
    let about_m2 = radius_m * radius_m / 4.0 + length_m * length_m / 12.0 + half_m * half_m;
    let nail_m = Vector3::new(0.1, -0.2, 1.5);
    let let_go_s = random.random_range(0.4..1.0);
    let mut angle: f64 = random.random_range(-1.5..1.5);
    let mut rate_rad_s: f64 = random.random_range(-4.0..4.0);
    let (mut x, mut v) = (Vector3::zeros(), Vector3::zeros());
    let mut poses = Vec::new();
    loop {
        let now_s = poses.len() as f64 * STEP_S;
        if now_s < let_go_s {
            x = nail_m + Vector3::new(-angle.sin(), 0.0, -angle.cos()) * half_m;
            v = Vector3::new(-angle.cos(), 0.0, angle.sin()) * (half_m * rate_rad_s);
        }
        poses.push((x, UnitQuaternion::from_scaled_axis(Vector3::y() * angle)));
        if now_s > let_go_s + FLOWN_S {
            break;
        }
        if now_s < let_go_s {
            rate_rad_s -= GRAVITY_M_S2 * half_m / about_m2 * angle.sin() * STEP_S;
        } else {
            v.z -= GRAVITY_M_S2 * STEP_S;
            x += v * STEP_S;
        }
        angle += rate_rad_s * STEP_S;
    }
    let shape = format!(
        "{{ kind = \"cylinder\", length_mm = {}, radius_mm = {} }}",
        length_m * 1e3,
        radius_m * 1e3
    );
    let joint = format!(
        "[[joint]]\nname = \"nail\"\nkind = \"pin\"\naxis = [0, 1, 0]\nparent_at_mm = [100, -200, 1500]\nchild = \"thing\"\nchild_at_mm = [0, 0, {}]\nuntil = \"let go\"\n",
        half_m * 1e3
    );
    let toml = [
        body(&shape, ""),
        event("go", "start", ""),
        event("let go", "change", CHANGE),
        event("end", "end", ""),
        joint,
    ];
    MadeMotion {
        toml: toml.concat(),
        poses,
        changes_s: vec![("let go", let_go_s)],
        values: Vec::new(),
    }
}
