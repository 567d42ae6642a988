//! Part 1: how fast and how exact the free turn of a body is, by several methods.
//!
//! The position of the centre of mass is one quadratic for all of them; what is compared is the
//! rotation and its derivative by the first angular velocity. A method is asked for one time, as
//! an event asks, and for sixty times up to the same end, as the samples of a flight ask.

mod dual;
mod elliptic;
mod library;
mod lie;
mod method;
mod runge_kutta;
mod taylor;

use std::hint::black_box;
use std::time::Instant;

use anyhow::Result;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::Options;
use crate::book::Book;
use crate::figure::{Axis, Curve, Figure, Mark, Sheet};
use crate::statistics::median;
use enact_tools::front::{Point, Task, Turning};
use enact_tools::reference::{self, Pair};
use method::{Method, Start, Turned};
use taylor::Taylor;

/// Name in files, in words, moments [kg m²], angular velocity [rad/s].
const BODIES: [(&str, &str, [f64; 3], [f64; 3]); 7] = [
    ("cube", "a cube", [1.0, 1.0, 1.0], [3.0, -7.0, 5.0]),
    ("top", "a symmetric top", [1.0, 1.0, 0.2], [3.0, -7.0, 5.0]),
    (
        "generic",
        "three different moments",
        [1.0, 2.0, 2.5],
        [3.0, -7.0, 5.0],
    ),
    (
        "middle",
        "three different moments, spun about the middle axis",
        [1.0, 2.0, 2.5],
        [0.01, 9.0, 0.01],
    ),
    (
        "separatrix",
        "three different moments, 1e-7 from the separatrix",
        [1.0, 2.0, 2.5],
        [1e-3, 9.0, 8.944e-4],
    ),
    (
        "near_equal",
        "two moments a millionth apart",
        [1.0, 1.000_001, 1.6],
        [3.0, -7.0, 5.0],
    ),
    (
        "axis",
        "three different moments, spun about the last axis",
        [1.0, 2.0, 2.5],
        [1e-8, 1e-8, 9.0],
    ),
];

const DURATIONS_S: [f64; 3] = [0.1, 1.0, 10.0];
/// The one that is drawn; the others are in the table and in the numbers.
const DRAWN_S: f64 = 1.0;
/// Times asked for.
const SAMPLES: [usize; 2] = [1, 60];

/// Runs it.
pub fn run(options: &Options, book: &mut Book) -> Result<()> {
    let mut turnings = Vec::new();
    for (name, title, moments, omega) in BODIES {
        let start = Start { moments, omega };
        let mut tasks = Vec::new();
        for duration_s in DURATIONS_S {
            if options.quick && duration_s > 1.0 {
                continue;
            }
            let truth = Truth::of(&start, duration_s);
            for samples in SAMPLES {
                tasks.push(task(&start, samples, duration_s, &truth, options.quick));
            }
        }
        let turning = Turning {
            name: name.to_owned(),
            title: title.to_owned(),
            moments,
            omega,
            class: format!("{:?}", start.body().symmetry()),
            chosen: method::ours(&start).to_owned(),
            tasks,
        };
        let drawn = |task: &&Task| task.duration_s == DRAWN_S;
        for task in turning.tasks.iter().filter(drawn) {
            book.keep(figure(&turning, task, Error::Rotation))?;
            book.keep(figure(&turning, task, Error::Derivative))?;
        }
        book.numbers(&format!("flow_{name}"), &turning)?;
        turnings.push(turning);
    }
    book.tabulate(fronts(&turnings))?;
    book.tabulate(references(&turnings))
}

fn task(start: &Start, samples: usize, duration_s: f64, truth: &Truth, quick: bool) -> Task {
    let times_s: Vec<f64> = (1..=samples)
        .map(|k| duration_s * k as f64 / samples as f64)
        .collect();
    let points = method::methods(start).into_iter();
    Task {
        samples,
        duration_s,
        condition_rad: truth.condition[0],
        condition_derivative: truth.condition[1],
        reference: truth.differs,
        points: points
            .map(|method| point(&method, start, &times_s, truth, quick))
            .collect(),
    }
}

fn point(method: &Method, start: &Start, times_s: &[f64], truth: &Truth, quick: bool) -> Point {
    let mut turns: Vec<Turned> = Vec::with_capacity(times_s.len());
    (method.run)(start, times_s, &mut turns);
    let last = turns.last().filter(|_| turns.len() == times_s.len());
    let number = |error: f64| error.is_finite().then_some(error);
    let error_rad = last.and_then(|turned| {
        let got = turned.rotation.to_rotation_matrix().into_inner();
        number((got - truth.rotation).norm() / 2.0_f64.sqrt())
    });
    let derivative_error = last
        .and_then(|turned| number((turned.right() - truth.by_spin).norm() / truth.by_spin.norm()));
    let [fastest_s, median_s] = time_s(quick, || {
        turns.clear();
        (method.run)(black_box(start), black_box(times_s), &mut turns);
        black_box(&turns);
    });
    let count = times_s.len() as f64;
    Point {
        method: method.name.to_owned(),
        setting: method.setting.clone(),
        is_ours: method.is_ours,
        error_rad,
        derivative_error,
        fastest_s: fastest_s / count,
        median_s: median_s / count,
    }
}

/// Seconds of one call: the fastest and the median of several runs of some milliseconds, or of one
/// call where that is longer.
fn time_s(quick: bool, mut call: impl FnMut()) -> [f64; 2] {
    let (runs, least_s) = if quick { (3, 1e-4) } else { (9, 1e-3) };
    let mut repeat = 1_u32;
    let mut times_s = Vec::new();
    while times_s.len() < runs {
        let begin = Instant::now();
        for _ in 0..repeat {
            call();
        }
        let elapsed_s = begin.elapsed().as_secs_f64();
        if elapsed_s < least_s && repeat < 1 << 20 {
            repeat *= 2;
            continue;
        }
        times_s.push(elapsed_s / f64::from(repeat));
        // Long calls are not repeated as often.
        if elapsed_s > 10.0 * least_s && times_s.len() >= 3 {
            break;
        }
    }
    [
        times_s.iter().copied().fold(f64::INFINITY, f64::min),
        median(&times_s),
    ]
}

/// The turn to thirty digits.
struct Truth {
    rotation: Matrix3<f64>,
    /// Right perturbation by `ω(0)`.
    by_spin: Matrix3<f64>,
    /// What half a rounding of the first angular velocity makes of both: \[rad\], relative.
    condition: [f64; 2],
    /// From the second method: rotation \[rad\], derivative, relative.
    differs: [f64; 2],
}

impl Truth {
    /// By extrapolation, its derivative by central differences with a step of 1e-12; and both by
    /// Taylor series of order 40 in the same numbers.
    fn of(start: &Start, duration_s: f64) -> Self {
        let speed = Vector3::from(start.omega).norm();
        let run =
            |omega: [Pair; 3]| reference::turn(start.moments, &reference::epoch(omega), duration_s);
        let centre = run(start.omega.map(Pair::from));
        let quaternion = |q: &[f64]| nalgebra::Quaternion::new(q[0], q[1], q[2], q[3]);
        let rotation = UnitQuaternion::new_normalize(quaternion(&centre.map(|pair| pair.0)));
        let mut by_spin = Matrix3::zeros();
        let step = 1e-12;
        for column in 0..3 {
            let moved = |sign: f64| {
                let mut moved = start.omega.map(Pair::from);
                moved[column] = moved[column] + Pair(sign * step, 0.0);
                run(moved)
            };
            let (ahead, back) = (moved(1.0), moved(-1.0));
            let change: Vec<f64> = (0..4)
                .map(|i| (ahead[i] - back[i]).0 / (2.0 * step))
                .collect();
            let turn = (rotation.quaternion().conjugate() * quaternion(&change)).imag() * 2.0;
            by_spin.set_column(column, &turn);
        }
        let series = |omega: [f64; 3]| {
            let mut taylor = Taylor::<Pair, 41>::new(start.moments, omega, 1e-34);
            let node = taylor.node(duration_s).expect("steps that end");
            let by_spin = Matrix3::from_fn(|row, column| node.eta[column][row].0);
            (node, by_spin)
        };
        let (node, second) = series(start.omega);
        // Away from its direction, which matters more than its size.
        let [a, b, c] = start.omega;
        let half = f64::EPSILON / 2.0;
        let (_, rounded) = series([a * (1.0 + half), b * (1.0 - half), c * (1.0 + half)]);
        // Half a rounding more may be none: 1 + ε/2 is 1.
        let (_, beyond) = series([
            a * (1.0 + 2.0 * half),
            b * (1.0 - half),
            c * (1.0 + 2.0 * half),
        ]);
        let apart = (0..4).map(|i| (node.turn[i] - centre[i]).0.powi(2));
        let changed = (rounded - second)
            .norm()
            .max((beyond - second).norm() / 2.0);
        Self {
            rotation: rotation.to_rotation_matrix().into_inner(),
            by_spin: second,
            condition: [second.norm() * speed * half, changed / second.norm()],
            differs: [
                2.0 * apart.sum::<f64>().sqrt(),
                (second - by_spin).norm() / second.norm(),
            ],
        }
    }
}

/// Which error stands across.
#[derive(Clone, Copy)]
enum Error {
    Rotation,
    Derivative,
}

fn figure(turning: &Turning, task: &Task, error: Error) -> Figure {
    let Turning {
        title,
        moments,
        omega,
        ..
    } = turning;
    let mut names: Vec<&str> = Vec::new();
    for point in &task.points {
        if !names.contains(&point.method.as_str()) {
            names.push(&point.method);
        }
    }
    let curve = |name: &&str| {
        let own = task.points.iter().filter(|point| point.method == *name);
        let mark = |point: &Point| Mark {
            x: match error {
                Error::Rotation => point.error_rad,
                Error::Derivative => point.derivative_error,
            }
            .map_or(f64::NAN, |error| error.max(1e-17)),
            y: point.fastest_s,
            spread: Some([point.fastest_s, point.median_s]),
            setting: (!point.setting.is_empty()).then(|| point.setting.clone()),
            failed: point.failed(),
        };
        let curve = Curve::new(*name, own.map(mark).collect());
        if *name == turning.chosen {
            Curve::ours(*name, curve.points)
        } else {
            curve
        }
    };
    let (duration_s, condition) = (task.duration_s, task.condition_rad);
    let (of, across, ending) = match error {
        Error::Rotation => (
            "Turn",
            format!("error of the orientation after {duration_s} s [rad]"),
            "",
        ),
        Error::Derivative => (
            "Derivative of the turn",
            format!(
                "error of the orientation's derivative by the first angular velocity after {duration_s} s, relative"
            ),
            "_derivative",
        ),
    };
    let (asked, suffix) = match task.samples {
        1 => ("asked for once".to_owned(), "once"),
        samples => (format!("asked for at {samples} samples"), "flight"),
    };
    Figure {
        name: format!("flow_{}_{duration_s}s_{suffix}{ending}", turning.name),
        title: format!(
            "{of} of {title} over {duration_s} s, {asked}: the further left the more exact, the further down the faster"
        ),
        note: format!(
            "Moments {moments:?}, first angular velocity {omega:?} rad/s. One point per tolerance or step. \
             Times: fastest run, bars to the median of all. Half a rounding of the first angular velocity \
             turns the end by {condition:.1e} rad."
        ),
        x: Axis::logarithmic(&across),
        y: Axis::logarithmic("time per evaluation with derivatives [s]"),
        curves: names.iter().map(curve).collect(),
    }
}

fn fronts(turnings: &[Turning]) -> Sheet {
    let mut rows = Vec::new();
    for turning in turnings {
        for task in &turning.tasks {
            let ours = task.ours();
            let other = task.fastest_exact_other();
            let faster = task.as_exact_and_faster().into_iter();
            let faster = faster.min_by(|a, b| a.fastest_s.total_cmp(&b.fastest_s));
            let named = |point: &Point| format!("{} {}", point.method, point.setting);
            rows.push(vec![
                turning.title.clone(),
                format!("{} s", task.duration_s),
                task.samples.to_string(),
                format!("{:.3} µs", 1e6 * ours.fastest_s),
                format!("{:.0e}", ours.error_rad.unwrap_or(f64::NAN)),
                format!("{:.0e}", ours.derivative_error.unwrap_or(f64::NAN)),
                other.map_or("none".to_owned(), named),
                other.map_or("–".to_owned(), |other| {
                    format!("{:.2}", other.fastest_s / ours.fastest_s)
                }),
                faster.map_or("nothing".to_owned(), named),
                if task.ahead_of_ours().is_empty() {
                    "yes".to_owned()
                } else {
                    "no".to_owned()
                },
            ]);
        }
    }
    let header = [
        "body",
        "duration",
        "times asked for",
        "the program's, per time",
        "its error, rad",
        "its derivative's, relative",
        "fastest other that is exact to rounding",
        "its time over the program's",
        "as exact to rounding, and faster",
        "program on the front",
    ];
    Sheet {
        name: "flow_fronts".to_owned(),
        header: header.map(str::to_owned).to_vec(),
        rows,
        ..Sheet::default()
    }
}

fn references(turnings: &[Turning]) -> Sheet {
    let rows = turnings.iter().map(|turning| {
        let worst = |index: usize| {
            let all = turning.tasks.iter().map(|task| task.reference[index]);
            format!("{:.0e}", all.fold(0.0, f64::max))
        };
        vec![turning.title.clone(), worst(0), worst(1)]
    });
    let header = [
        "body",
        "rotations differ by at most, rad",
        "derivatives, relative",
    ];
    Sheet {
        name: "flow_references".to_owned(),
        header: header.map(str::to_owned).to_vec(),
        rows: rows.collect(),
        ..Sheet::default()
    }
}
