//! How fast and how exact the free turn of a body with three different moments is, by several
//! methods.
//!
//! ```text
//! cargo run --release --example flows
//! ```
//!
//! The program's Taylor steps, the closed form in elliptic functions (derivatives by numbers
//! that carry them) and the classic Runge–Kutta method, against a reference to thirty digits.
//! Prints a table and leaves it in `tools/flows/results/flows.csv`. Times are the fastest of
//! seven runs.

mod dual;
mod elliptic;
#[path = "../../src/physics/flow/reference.rs"]
mod reference;
mod runge_kutta;

use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

use dual::Dual;
use elliptic::Elliptic;
use enact::physics::Body;
use enact::physics::flow::{self, Spin};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use reference::Pair;

/// Name, moments [kg m²], angular velocity [rad/s].
const CASES: [(&str, [f64; 3], [f64; 3]); 6] = [
    ("generic", [1.0, 2.0, 2.5], [3.0, -7.0, 5.0]),
    ("flips", [1.0, 2.0, 2.5], [0.01, 9.0, 0.01]),
    ("near separatrix", [1.0, 2.0, 2.5], [1e-3, 9.0, 8.944e-4]),
    (
        "two moments 1e-6 apart",
        [1.0, 1.000_001, 1.6],
        [3.0, -7.0, 5.0],
    ),
    (
        "three moments 1e-9 apart",
        [1.0, 1.000_000_001, 1.000_000_002],
        [3.0, -7.0, 5.0],
    ),
    ("about an axis", [1.0, 2.0, 2.5], [1e-8, 1e-8, 9.0]),
];

const DURATIONS_S: [f64; 3] = [0.1, 1.0, 10.0];

/// Samples of an arc: 60 at 120 Hz about its epoch.
const SAMPLES: usize = 60;

/// What is compared: rotation, `ω`, right perturbation and change of `ω` by `ω(0)`.
struct Turned {
    rotation: Matrix3<f64>,
    omega: Vector3<f64>,
    turn_by_spin: Matrix3<f64>,
    spin_by_spin: Matrix3<f64>,
}

fn taylor(moments: [f64; 3], omega: [f64; 3], duration_s: f64) -> Turned {
    let body = Body::new(1.0, moments.into()).expect("a body");
    let turn = flow::turn(
        &body,
        &UnitQuaternion::identity(),
        &omega.into(),
        duration_s,
    );
    Turned {
        rotation: turn.orientation.to_rotation_matrix().into_inner(),
        omega: turn.angular_velocity_rad_s,
        turn_by_spin: turn.orientation_by_angular_velocity,
        spin_by_spin: turn.angular_velocity_by_angular_velocity,
    }
}

fn closed_form(moments: [f64; 3], omega: [f64; 3]) -> Elliptic<Dual> {
    let variables = [0, 1, 2].map(|i| Dual::variable(omega[i], i));
    Elliptic::new(moments, variables)
}

fn elliptic(moments: [f64; 3], omega: [f64; 3], duration_s: f64) -> Turned {
    let turn = closed_form(moments, omega);
    let (rotation, omega, left, spin_by_spin) = elliptic::with_derivatives(&turn, duration_s);
    Turned {
        rotation,
        omega,
        turn_by_spin: rotation.transpose() * left,
        spin_by_spin,
    }
}

fn runge_kutta(moments: [f64; 3], omega: [f64; 3], duration_s: f64, step_s: f64) -> Turned {
    let turned = runge_kutta::turn(&moments.into(), &omega.into(), duration_s, step_s);
    let rotation = UnitQuaternion::new_normalize(turned.rotation);
    Turned {
        rotation: rotation.to_rotation_matrix().into_inner(),
        omega: turned.omega,
        turn_by_spin: turned.turn_by_spin,
        spin_by_spin: turned.spin_by_spin,
    }
}

/// The reference, its derivatives by central differences with a step of 1e-12.
fn truth(moments: [f64; 3], omega: [f64; 3], duration_s: f64) -> Turned {
    let run = |omega: [Pair; 3]| reference::turn(moments, &reference::epoch(omega), duration_s);
    let centre = run(omega.map(Pair::from)).map(|pair| pair.0);
    let quaternion = |q: &[f64]| nalgebra::Quaternion::new(q[0], q[1], q[2], q[3]);
    let rotation = UnitQuaternion::new_normalize(quaternion(&centre));
    let (mut turn_by_spin, mut spin_by_spin) = (Matrix3::zeros(), Matrix3::zeros());
    let step = 1e-12;
    for column in 0..3 {
        let moved = |sign: f64| {
            let mut moved = omega.map(Pair::from);
            moved[column] = moved[column] + Pair(sign * step, 0.0);
            run(moved)
        };
        let (ahead, back) = (moved(1.0), moved(-1.0));
        let change: Vec<f64> = (0..7)
            .map(|i| (ahead[i] - back[i]).0 / (2.0 * step))
            .collect();
        let turn = (rotation.quaternion().conjugate() * quaternion(&change)).imag() * 2.0;
        turn_by_spin.set_column(column, &turn);
        spin_by_spin.set_column(column, &Vector3::from_column_slice(&change[4..]));
    }
    Turned {
        rotation: rotation.to_rotation_matrix().into_inner(),
        omega: Vector3::from_column_slice(&centre[4..]),
        turn_by_spin,
        spin_by_spin,
    }
}

/// Nanoseconds of one call, the fastest of seven runs of at least two milliseconds.
fn time_ns(mut call: impl FnMut()) -> f64 {
    let mut repeat = 1;
    let mut best = f64::INFINITY;
    let mut runs = 0;
    while runs < 7 {
        let start = Instant::now();
        for _ in 0..repeat {
            call();
        }
        let elapsed = start.elapsed().as_nanos() as f64;
        if elapsed < 2e6 && repeat < 1 << 20 {
            repeat *= 2;
            continue;
        }
        best = best.min(elapsed / f64::from(repeat));
        runs += 1;
    }
    best
}

type Method = (&'static str, fn([f64; 3], [f64; 3], f64) -> Turned);

fn methods() -> [Method; 5] {
    [
        ("taylor", taylor),
        ("elliptic", elliptic),
        ("rk4 10 ms", |m, w, s| runge_kutta(m, w, s, 1e-2)),
        ("rk4 1 ms", |m, w, s| runge_kutta(m, w, s, 1e-3)),
        ("rk4 0.1 ms", |m, w, s| runge_kutta(m, w, s, 1e-4)),
    ]
}

/// Per sample of an arc, its start included: Taylor steps, elliptic functions.
fn arc_times_ns(moments: [f64; 3], omega: [f64; 3]) -> [f64; 2] {
    let body = Body::new(1.0, moments.into()).expect("a body");
    let times_s: Vec<f64> = (0..SAMPLES).map(|i| (i as f64 - 29.5) / 120.0).collect();
    let steps = time_ns(|| {
        let mut spin = Spin::new(&body, black_box(&omega.into()));
        for s in &times_s {
            black_box(spin.turn_and_derivative(*s));
        }
    });
    let closed = time_ns(|| {
        let turn = closed_form(moments, black_box(omega));
        for s in &times_s {
            black_box(elliptic::with_derivatives(&turn, *s));
        }
    });
    [steps, closed].map(|ns| ns / SAMPLES as f64)
}

fn main() -> std::io::Result<()> {
    let mut csv = String::from(
        "case,method,duration_s,time_ns,rotation_error_rad,spin_error_relative,\
         turn_derivative_error_relative,spin_derivative_error_relative,condition_rad\n",
    );
    println!("| case | s | method | µs | rotation rad | ω | ∂R/∂ω | ∂ω/∂ω | conditioning rad |");
    println!("|---|---|---|---|---|---|---|---|---|");
    for (case, moments, omega) in CASES {
        for duration_s in DURATIONS_S {
            let truth = truth(moments, omega, duration_s);
            let speed = Vector3::from(omega).norm();
            // A change of ω by half its rounding turns the end by this.
            let condition = truth.turn_by_spin.norm() * speed * f64::EPSILON / 2.0;
            for (name, method) in methods() {
                let got = method(moments, omega, duration_s);
                let errors = [
                    (got.rotation - truth.rotation).norm() / 2.0_f64.sqrt(),
                    (got.omega - truth.omega).norm() / truth.omega.norm(),
                    (got.turn_by_spin - truth.turn_by_spin).norm() / truth.turn_by_spin.norm(),
                    (got.spin_by_spin - truth.spin_by_spin).norm() / truth.spin_by_spin.norm(),
                ];
                let ns = time_ns(|| {
                    black_box(method(black_box(moments), black_box(omega), duration_s));
                });
                let [a, b, c, d] = errors;
                println!(
                    "| {case} | {duration_s} | {name} | {:.2} | {a:.1e} | {b:.1e} | {c:.1e} | {d:.1e} | {condition:.1e} |",
                    ns / 1e3
                );
                writeln!(
                    csv,
                    "{case},{name},{duration_s},{ns:.0},{a:.2e},{b:.2e},{c:.2e},{d:.2e},{condition:.2e}"
                )
                .expect("text takes text");
            }
        }
        let [steps, closed] = arc_times_ns(moments, omega);
        println!(
            "| {case} | arc of {SAMPLES} | taylor | {:.3} per sample ||||||",
            steps / 1e3
        );
        println!(
            "| {case} | arc of {SAMPLES} | elliptic | {:.3} per sample ||||||",
            closed / 1e3
        );
        for (name, ns) in [("taylor", steps), ("elliptic", closed)] {
            writeln!(csv, "{case},{name},arc,{ns:.0},,,,,").expect("text takes text");
        }
    }
    std::fs::write("tools/flows/results/flows.csv", csv)
}
