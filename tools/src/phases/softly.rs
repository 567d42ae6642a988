//! A ball on a soft mat: a spring with a damper, and friction while it slides there.

use std::f64::consts::PI;

use nalgebra::{UnitQuaternion, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{CHANGE, GRAVITY_M_S2, MadeMotion, STEP_S, TABLE, between, body, event, free};

/// How long before the second touch it ends \[s\].
const BEFORE_S: f64 = 0.01;

pub(super) fn bounced(random: &mut ChaCha8Rng) -> MadeMotion {
    let radius_m = between(random, 0.015, 0.1);
    let contact_s = between(random, 0.003, 0.1);
    let damping = random.random_range(0.02..0.15);
    let friction = random.random_range(0.005..0.03);
    let frequency_rad_s = PI / contact_s;
    let mut x = Vector3::new(0.1, -0.2, radius_m + random.random_range(0.3..0.8));
    let mut v = Vector3::new(
        random.random_range(1.0..2.0),
        random.random_range(-0.5..0.5),
        random.random_range(-1.0..0.0),
    );
    let mut q = UnitQuaternion::identity();
    let mut w = Vector3::from_fn(|_, _| random.random_range(-8.0..8.0));
    let (mut poses, mut touched, mut left) = (Vec::new(), None, None);
    loop {
        let now_s = poses.len() as f64 * STEP_S;
        poses.push((x, q));
        let depth_m = radius_m - x.z;
        if depth_m > 0.0 && left.is_some() {
            break;
        }
        if depth_m > 0.0 {
            touched.get_or_insert((now_s, v.z));
            let pushed = frequency_rad_s * (frequency_rad_s * depth_m - 2.0 * damping * v.z);
            let pushed = pushed.max(0.0);
            let arm = Vector3::z() * -radius_m;
            let slip = v + w.cross(&arm);
            let slip = Vector3::new(slip.x, slip.y, 0.0);
            let rubbed = -slip.normalize() * (friction * pushed);
            v += (Vector3::z() * pushed + rubbed) * STEP_S;
            w += arm.cross(&rubbed) * (STEP_S / (0.4 * radius_m * radius_m));
        } else if touched.is_some() {
            left.get_or_insert((now_s, v.z));
        }
        v.z -= GRAVITY_M_S2 * STEP_S;
        x += v * STEP_S;
        q = UnitQuaternion::from_scaled_axis(w * STEP_S) * q;
    }
    let kept = poses.len() - (BEFORE_S / STEP_S) as usize;
    poses.truncate(kept);
    let ((touch_s, before), (left_s, after)) =
        (touched.unwrap_or_default(), left.unwrap_or_default());
    let shape = format!("{{ kind = \"sphere\", radius_mm = {} }}", radius_m * 1e3);
    let toml = [
        body(
            &shape,
            &format!("restitution = 0.7\nfriction = {friction}\n"),
        ),
        TABLE.into(),
        event("go", "start", ""),
        event(
            "hit",
            "collision",
            &format!("{CHANGE}surface = \"table\"\n"),
        ),
        event("end", "end", ""),
        free("thing.restitution"),
        free("hit.contact_duration"),
    ];
    MadeMotion {
        toml: toml.concat(),
        poses,
        changes_s: vec![("hit", touch_s)],
        values: vec![
            ("thing.restitution", -after / before),
            ("hit.contact_duration", left_s - touch_s),
        ],
    }
}
