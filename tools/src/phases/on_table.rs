//! What slides, rolls and rests on a level table.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{UnitQuaternion, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{
    CHANGE, GRAVITY_M_S2, MadeMotion, STEP_S, TABLE, TruePose, between, body, event, free,
    on_table_phase,
};

/// How long a motion goes on after its last change \[s\].
const AFTER_S: f64 = 0.4;
const FACE: &str = "feature = \"face -z\"\n";

/// The velocity of what slides, in any direction [m/s].
fn level_velocity(random: &mut ChaCha8Rng, least: f64, most: f64) -> Vector3<f64> {
    let angle: f64 = random.random_range(-PI..PI);
    Vector3::new(angle.cos(), angle.sin(), 0.0) * random.random_range(least..most)
}

pub(super) fn slide_roll(random: &mut ChaCha8Rng) -> MadeMotion {
    let radius_m = between(random, 0.01, 0.08);
    let [sliding, rolling] = [
        random.random_range(0.08..0.4),
        random.random_range(0.005..0.03),
    ];
    let mut x = Vector3::new(0.1, -0.2, radius_m);
    let mut v = level_velocity(random, 0.8, 2.0);
    let mut q = UnitQuaternion::identity();
    let mut w = Vector3::from_fn(|_, _| random.random_range(-15.0..15.0));
    let mut poses = Vec::new();
    let mut no_slip_s = None;
    let arm = Vector3::z() * -radius_m;
    loop {
        let now_s = poses.len() as f64 * STEP_S;
        poses.push((x, q));
        let slip = v + w.cross(&arm);
        if no_slip_s.is_none() && slip.norm() > 3.5 * sliding * GRAVITY_M_S2 * STEP_S {
            let force = slip.normalize() * (-sliding * GRAVITY_M_S2);
            v += force * STEP_S;
            w += arm.cross(&force) * (STEP_S / (0.4 * radius_m * radius_m));
        } else {
            no_slip_s.get_or_insert(now_s);
            v -= v.normalize() * (rolling * GRAVITY_M_S2 * STEP_S);
            w = Vector3::z().cross(&v) / radius_m + Vector3::z() * w.z;
        }
        x += v * STEP_S;
        q = UnitQuaternion::from_scaled_axis(w * STEP_S) * q;
        let is_slow = v.norm() < 100.0 * rolling * GRAVITY_M_S2 * STEP_S;
        if is_slow || no_slip_s.is_some_and(|no_slip_s| now_s > no_slip_s + AFTER_S) {
            break;
        }
    }
    let shape = format!("{{ kind = \"sphere\", radius_mm = {} }}", radius_m * 1e3);
    let toml = [
        body(&shape, ""),
        TABLE.into(),
        event("go", "start", ""),
        event("change", "change", CHANGE),
        event("end", "end", ""),
        on_table_phase("sliding", "slide", "friction = 0.2\n", ["go", "change"]),
        on_table_phase("rolling", "roll", "friction = 0.01\n", ["change", "end"]),
        free("sliding.friction"),
        free("rolling.friction"),
    ];
    let end_s = poses.len() as f64 * STEP_S;
    MadeMotion {
        toml: toml.concat(),
        poses,
        changes_s: vec![("change", no_slip_s.unwrap_or(end_s))],
        values: vec![("sliding.friction", sliding), ("rolling.friction", rolling)],
    }
}

/// A box's size \[m\] and its gyration radius about the vertical.
fn drawn_box(random: &mut ChaCha8Rng) -> ([f64; 3], f64) {
    let size_m = [
        between(random, 0.06, 0.3),
        between(random, 0.05, 0.2),
        between(random, 0.02, 0.06),
    ];
    (size_m, (size_m[0].hypot(size_m[1])) / 12_f64.sqrt())
}

fn cuboid([x, y, z]: [f64; 3]) -> String {
    let [x, y, z] = [x, y, z].map(|length_m| length_m * 1e3);
    format!("{{ kind = \"cuboid\", size_mm = [{x}, {y}, {z}] }}")
}

/// Slides a box from a place to rest and a while longer; says when it rests.
fn slid(
    poses: &mut Vec<TruePose>,
    mut v: Vector3<f64>,
    mut yaw_rad_s: f64,
    friction: f64,
    gyration_m: f64,
) -> f64 {
    let (mut x, mut q) = poses[poses.len() - 1];
    let mut still_s: Option<f64> = None;
    loop {
        let now_s = (poses.len() - 1) as f64 * STEP_S;
        let both = Vector3::new(v.x, v.y, gyration_m * yaw_rad_s);
        let slowed = friction * GRAVITY_M_S2 * STEP_S;
        let left = (1.0 - slowed / both.norm().max(slowed)).max(0.0);
        if left == 0.0 {
            still_s.get_or_insert(now_s);
        }
        (v, yaw_rad_s) = (v * left, yaw_rad_s * left);
        x += v * STEP_S;
        q = UnitQuaternion::from_scaled_axis(Vector3::z() * (yaw_rad_s * STEP_S)) * q;
        poses.push((x, q));
        if let Some(still_s) = still_s.filter(|still_s| now_s > still_s + AFTER_S) {
            return still_s;
        }
    }
}

pub(super) fn slide_rest(random: &mut ChaCha8Rng) -> MadeMotion {
    let (size_m, gyration_m) = drawn_box(random);
    let friction = random.random_range(0.1..0.5);
    let v = level_velocity(random, 0.5, 1.8);
    let yaw_rad_s = random.random_range(-8.0..8.0);
    let first = Vector3::new(0.1, -0.2, 0.5 * size_m[2]);
    let mut poses = vec![(first, UnitQuaternion::identity())];
    let still_s = slid(&mut poses, v, yaw_rad_s, friction, gyration_m);
    let toml = [
        body(&cuboid(size_m), ""),
        TABLE.into(),
        event("go", "start", ""),
        event("still", "change", CHANGE),
        event("end", "end", ""),
        on_table_phase(
            "sliding",
            "slide",
            &format!("friction = 0.3\n{FACE}"),
            ["go", "still"],
        ),
        on_table_phase("lying", "rest", FACE, ["still", "end"]),
        free("sliding.friction"),
    ];
    MadeMotion {
        toml: toml.concat(),
        poses,
        changes_s: vec![("still", still_s)],
        values: vec![("sliding.friction", friction)],
    }
}

pub(super) fn landing(random: &mut ChaCha8Rng) -> MadeMotion {
    let (size_m, gyration_m) = drawn_box(random);
    let friction = random.random_range(0.15..0.45);
    let mut v = level_velocity(random, 1.5, 2.5);
    v.z = random.random_range(-0.5..0.5);
    let yaw_rad_s: f64 = random.random_range(-5.0..5.0);
    let flown_s: f64 = random.random_range(0.15..0.3);
    let fallen_m = v.z * flown_s - 0.5 * GRAVITY_M_S2 * flown_s * flown_s;
    let first = Vector3::new(0.1, -0.2, 0.5 * size_m[2] - fallen_m);
    let steps = (flown_s / STEP_S).round() as usize;
    let flown = (0..=steps).map(|step| {
        let now_s = step as f64 * STEP_S;
        let fallen = Vector3::z() * (-0.5 * GRAVITY_M_S2 * now_s * now_s);
        let turn = Vector3::z() * (yaw_rad_s * now_s);
        (
            first + v * now_s + fallen,
            UnitQuaternion::from_scaled_axis(turn),
        )
    });
    let mut poses: Vec<TruePose> = flown.collect();
    let down_m_s = GRAVITY_M_S2 * flown_s - v.z;
    let both = Vector3::new(v.x, v.y, gyration_m * yaw_rad_s);
    let left = (1.0 - friction * down_m_s / both.norm()).max(0.0);
    let level = Vector3::new(v.x, v.y, 0.0) * left;
    let still_s = slid(&mut poses, level, yaw_rad_s * left, friction, gyration_m);
    let toml = [
        body(&cuboid(size_m), "restitution = 0\nfriction = 0.3\n"),
        TABLE.into(),
        event("go", "start", ""),
        event(
            "land",
            "collision",
            &format!("{CHANGE}surface = \"table\"\n{FACE}"),
        ),
        event("still", "change", CHANGE),
        event("end", "end", ""),
        on_table_phase("sliding", "slide", FACE, ["land", "still"]),
        on_table_phase("lying", "rest", FACE, ["still", "end"]),
        free("thing.friction"),
    ];
    MadeMotion {
        toml: toml.concat(),
        poses,
        changes_s: vec![("land", flown_s), ("still", still_s)],
        values: vec![("thing.friction", friction)],
    }
}

pub(super) fn roll_rest(random: &mut ChaCha8Rng) -> MadeMotion {
    let radius_m = between(random, 0.008, 0.05);
    let length_m = between(random, 0.05, 0.3);
    let friction = random.random_range(0.015..0.06);
    let speed_m_s = random.random_range(0.3..0.9);
    let yaw = random.random_range(-PI..PI);
    let about_z = UnitQuaternion::from_scaled_axis(Vector3::z() * yaw);
    let (axis, way) = (about_z * Vector3::x(), about_z * Vector3::y());
    let laid = UnitQuaternion::from_scaled_axis(Vector3::y() * FRAC_PI_2);
    let stops_s = speed_m_s / (friction * GRAVITY_M_S2);
    let steps = ((stops_s + AFTER_S) / STEP_S) as usize;
    let poses = (0..=steps).map(|step| {
        let rolling_s = (step as f64 * STEP_S).min(stops_s);
        let way_m = (speed_m_s - 0.5 * friction * GRAVITY_M_S2 * rolling_s) * rolling_s;
        let rolled = UnitQuaternion::from_scaled_axis(axis * (-way_m / radius_m));
        (
            Vector3::z() * radius_m + way * way_m,
            rolled * about_z * laid,
        )
    });
    let shape = format!(
        "{{ kind = \"cylinder\", length_mm = {}, radius_mm = {} }}",
        length_m * 1e3,
        radius_m * 1e3
    );
    const SIDE: &str = "feature = \"side\"\n";
    let toml = [
        body(&shape, ""),
        TABLE.into(),
        event("go", "start", ""),
        event("still", "change", CHANGE),
        event("end", "end", ""),
        on_table_phase(
            "rolling",
            "roll",
            &format!("friction = 0.03\n{SIDE}"),
            ["go", "still"],
        ),
        on_table_phase("lying", "rest", SIDE, ["still", "end"]),
        free("rolling.friction"),
    ];
    MadeMotion {
        toml: toml.concat(),
        poses: poses.collect(),
        changes_s: vec![("still", stops_s)],
        values: vec![("rolling.friction", friction)],
    }
}
