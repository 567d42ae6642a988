//! What a hand throws, catches and puts down: hands move by polynomials of degree five.

use std::f64::consts::PI;

use nalgebra::{Matrix6, UnitQuaternion, Vector3, Vector6};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{
    CHANGE, GRAVITY_M_S2, MadeMotion, STEP_S, TABLE, TruePose, between, body, direction, event,
    on_table_phase,
};

/// Place, velocity and acceleration of a hand \[m, s\].
type HandEnd = [Vector3<f64>; 3];

/// Along one axis the polynomial of degree five between two ends.
fn quintic(ends: [[f64; 3]; 2], duration_s: f64) -> impl Fn(f64) -> f64 {
    let row = |time_s: f64, derivative: usize| {
        let entry = |power: usize| {
            let factor: f64 = (0..derivative).map(|k| power as f64 - k as f64).product();
            match power >= derivative {
                true => factor * time_s.powi((power - derivative) as i32),
                false => 0.0,
            }
        };
        [0, 1, 2, 3, 4, 5].map(entry)
    };
    let rows = [0.0, duration_s].map(|time_s| [0, 1, 2].map(|of| row(time_s, of)));
    let matrix = Matrix6::from_fn(|at, power| rows[at / 3][at % 3][power]);
    let values = Vector6::from_fn(|at, _| ends[at / 3][at % 3]);
    let by = matrix.lu().solve(&values).unwrap_or_default();
    move |time_s| {
        (0..6)
            .map(|power| by[power] * time_s.powi(power as i32))
            .sum()
    }
}

/// A hand's way from one end to another.
fn way(from: HandEnd, to: HandEnd, duration_s: f64) -> impl Fn(f64) -> Vector3<f64> {
    let along = [0, 1, 2].map(|axis| {
        let ends = [from, to].map(|end| end.map(|of| of[axis]));
        quintic(ends, duration_s)
    });
    move |time_s| Vector3::from_fn(|axis, _| along[axis](time_s))
}

/// A box, and its free flight.
struct Flown {
    moments: Vector3<f64>,
    shape: String,
}

impl Flown {
    fn draw(random: &mut ChaCha8Rng) -> Self {
        let size = [
            between(random, 0.06, 0.2),
            between(random, 0.04, 0.12),
            between(random, 0.03, 0.1),
        ];
        let [x, y, z] = size.map(|length_m| length_m * length_m / 12.0);
        let [a, b, c] = size.map(|length_m| length_m * 1e3);
        Self {
            moments: Vector3::new(y + z, x + z, x + y),
            shape: format!("{{ kind = \"cuboid\", size_mm = [{a}, {b}, {c}] }}"),
        }
    }

    /// Flies on from a pose, with a velocity and a spin about its own axes, for a while; both at the end.
    fn fly(
        &self,
        poses: &mut Vec<TruePose>,
        [velocity, spin]: [Vector3<f64>; 2],
        duration_s: f64,
    ) -> [Vector3<f64>; 2] {
        let (from, mut q) = poses[poses.len() - 1];
        let rate = |w: &Vector3<f64>| {
            let turning = w.cross(&self.moments.component_mul(w));
            -turning.component_div(&self.moments)
        };
        let mut w = spin;
        let steps = (duration_s / STEP_S).round() as usize;
        for step in 1..=steps {
            let middle = w + rate(&w) * (0.5 * STEP_S);
            q *= UnitQuaternion::from_scaled_axis(middle * STEP_S);
            w += rate(&middle) * STEP_S;
            let since_s = step as f64 * STEP_S;
            let fallen = Vector3::z() * (-0.5 * GRAVITY_M_S2 * since_s * since_s);
            poses.push((from + velocity * since_s + fallen, q));
        }
        [velocity - Vector3::z() * (GRAVITY_M_S2 * duration_s), w]
    }
}

fn drawn(random: &mut ChaCha8Rng, of: [[f64; 2]; 3]) -> Vector3<f64> {
    Vector3::from_iterator(of.map(|[least, most]| random.random_range(least..most)))
}

pub(super) fn thrown(random: &mut ChaCha8Rng) -> MadeMotion {
    let flown = Flown::draw(random);
    let let_go_s = random.random_range(0.45..0.9);
    let from = drawn(random, [[-0.3, 0.3], [-0.3, 0.3], [0.9, 1.2]]);
    let at = from + drawn(random, [[0.1, 0.5], [-0.2, 0.2], [0.1, 0.4]]);
    let velocity = drawn(random, [[0.5, 2.5], [-0.8, 0.8], [0.5, 3.0]]);
    let pushed = drawn(random, [[-12.0, 12.0], [-12.0, 12.0], [-4.0, 25.0]]);
    let still = [from, Vector3::zeros(), Vector3::zeros()];
    let carried = way(still, [at, velocity, pushed], let_go_s);
    let about = direction(random);
    let rate_rad_s = random.random_range(0.5..9.0);
    let turn = quintic(
        [
            [0.0; 3],
            [
                random.random_range(-1.2..1.2),
                rate_rad_s,
                random.random_range(-40.0..40.0),
            ],
        ],
        let_go_s,
    );
    let first = UnitQuaternion::from_scaled_axis(direction(random) * random.random_range(0.0..2.0));
    let steps = (let_go_s / STEP_S).round() as usize;
    let poses = (0..=steps).map(|step| {
        let now_s = step as f64 * STEP_S;
        let turned = UnitQuaternion::from_scaled_axis(about * turn(now_s));
        (carried(now_s), first * turned)
    });
    let mut poses: Vec<TruePose> = poses.collect();
    let lasts_s = random.random_range(0.3..0.55);
    flown.fly(&mut poses, [velocity, about * rate_rad_s], lasts_s);
    let toml = [
        body(&flown.shape, ""),
        event("go", "start", ""),
        event("thrown", "change", CHANGE),
        event("end", "end", ""),
        held("carried", ["go", "thrown"]),
    ];
    MadeMotion {
        toml: toml.concat(),
        poses,
        changes_s: vec![("thrown", let_go_s)],
        values: Vec::new(),
    }
}

pub(super) fn caught(random: &mut ChaCha8Rng) -> MadeMotion {
    let flown = Flown::draw(random);
    let from = drawn(random, [[-0.3, 0.3], [-0.3, 0.3], [0.9, 1.2]]);
    let velocity = drawn(random, [[-2.0, 2.0], [-1.0, 1.0], [0.5, 2.5]]);
    let spin = direction(random) * random.random_range(0.5..9.0);
    let first = UnitQuaternion::from_scaled_axis(direction(random) * random.random_range(0.0..2.0));
    let caught_s = random.random_range(0.35..0.6);
    let mut poses = vec![(from, first)];
    let [arriving, _] = flown.fly(&mut poses, [velocity, spin], caught_s);
    let (at, q) = poses[poses.len() - 1];
    let lasts_s = random.random_range(0.35..0.7);
    let hand = arriving * random.random_range(-0.1..0.5)
        + drawn(random, [[-0.4, 0.4], [-0.4, 0.4], [-0.4, 0.4]]);
    let slowed = drawn(random, [[-5.0, 5.0], [-5.0, 5.0], [-5.0, 5.0]]);
    let to = at + drawn(random, [[-0.15, 0.15], [-0.15, 0.15], [-0.15, 0.15]]);
    let carried = way(
        [at, hand, slowed],
        [to, Vector3::zeros(), Vector3::zeros()],
        lasts_s,
    );
    let about = direction(random);
    let turn = quintic(
        [
            [0.0, random.random_range(-2.0..2.0), 0.0],
            [random.random_range(-0.6..0.6), 0.0, 0.0],
        ],
        lasts_s,
    );
    let steps = (lasts_s / STEP_S).round() as usize;
    poses.extend((1..=steps).map(|step| {
        let since_s = step as f64 * STEP_S;
        let turned = UnitQuaternion::from_scaled_axis(about * turn(since_s));
        (carried(since_s), q * turned)
    }));
    let toml = [
        body(&flown.shape, ""),
        event("go", "start", ""),
        event("caught", "change", CHANGE),
        event("end", "end", ""),
        held("taken", ["caught", "end"]),
    ];
    MadeMotion {
        toml: toml.concat(),
        poses,
        changes_s: vec![("caught", caught_s)],
        values: Vec::new(),
    }
}

pub(super) fn put_down(random: &mut ChaCha8Rng) -> MadeMotion {
    let height_m = between(random, 0.03, 0.1);
    let (length_m, width_m) = (between(random, 0.06, 0.2), between(random, 0.04, 0.12));
    let [a, b, c] = [length_m, width_m, height_m].map(|of| of * 1e3);
    let shape = format!("{{ kind = \"cuboid\", size_mm = [{a}, {b}, {c}] }}");
    let lying = UnitQuaternion::from_scaled_axis(Vector3::z() * random.random_range(-PI..PI));
    let mut at = drawn(random, [[-0.2, 0.2], [-0.2, 0.2], [0.0, 1.0]]);
    at.z = 0.5 * height_m;
    let down_s = random.random_range(0.45..0.9);
    let away = at + drawn(random, [[-0.3, 0.3], [-0.3, 0.3], [0.15, 0.4]]);
    let mut arriving = drawn(random, [[-0.05, 0.05], [-0.05, 0.05], [-0.25, -0.02]]);
    let slowed = Vector3::z() * random.random_range(-1.0..1.0);
    arriving.z = arriving.z.min(-0.02);
    let still = [away, Vector3::zeros(), Vector3::zeros()];
    let carried = way(still, [at, arriving, slowed], down_s);
    let about = direction(random);
    let turn = quintic(
        [[random.random_range(-0.6..0.6), 0.0, 0.0], [0.0; 3]],
        down_s,
    );
    let steps = (down_s / STEP_S).round() as usize;
    let poses = (0..=steps).map(|step| {
        let now_s = step as f64 * STEP_S;
        let turned = UnitQuaternion::from_scaled_axis(about * turn(now_s));
        (carried(now_s), lying * turned)
    });
    let mut poses: Vec<TruePose> = poses.collect();
    let rests = (random.random_range(0.4..0.9) / STEP_S) as usize;
    poses.extend(std::iter::repeat_n((at, lying), rests));
    let toml = [
        body(&shape, ""),
        TABLE.into(),
        event("go", "start", ""),
        event("down", "change", CHANGE),
        event("end", "end", ""),
        held("carried", ["go", "down"]),
        on_table_phase("lying", "rest", "feature = \"face -z\"\n", ["down", "end"]),
    ];
    MadeMotion {
        toml: toml.concat(),
        poses,
        changes_s: vec![("down", down_s)],
        values: Vec::new(),
    }
}

fn held(name: &str, ends: [&str; 2]) -> String {
    let [from, until] = ends;
    format!(
        "[[phase]]\nname = \"{name}\"\nmotion = \"held\"\nbody = \"thing\"\nfrom = \"{from}\"\nuntil = \"{until}\"\n"
    )
}
