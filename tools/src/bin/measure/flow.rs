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
mod show;
mod taylor;
mod truth;

use std::hint::black_box;
use std::time::Instant;

use anyhow::Result;

use crate::options::Options;
use crate::record::Record;
use crate::statistics::median;
use enact_tools::front::{Point, Task, Turning};
use method::{Method, Start, Turned};
use show::{Error, figure, fronts, references};
use truth::Truth;

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
/// Bodies, times asked for and errors that are drawn.
const DRAWN: [(&str, usize, Error); 7] = [
    ("cube", 60, Error::Rotation),
    ("top", 60, Error::Rotation),
    ("generic", 60, Error::Rotation),
    ("middle", 60, Error::Rotation),
    ("generic", 1, Error::Rotation),
    ("separatrix", 1, Error::Derivative),
    ("axis", 1, Error::Derivative),
];
/// Times asked for.
const SAMPLES: [usize; 2] = [1, 60];

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let mut turnings = Vec::new();
    for (name, title, moments, omega) in BODIES {
        let start = Start { moments, omega };
        let mut tasks = Vec::new();
        for duration_s in DURATIONS_S {
            if options.quick && duration_s != DRAWN_S {
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
        for (_, samples, error) in DRAWN.iter().filter(|(drawn, ..)| *drawn == name) {
            let is_drawn = |task: &&Task| (task.duration_s, task.samples) == (DRAWN_S, *samples);
            if let Some(task) = turning.tasks.iter().find(is_drawn) {
                record.figure(figure(&turning, task, *error));
            }
        }
        turnings.push(turning);
    }
    let tasks = || turnings.iter().flat_map(|turning| &turning.tasks);
    let ahead = tasks()
        .filter(|task| task.ahead_of_ours().is_empty())
        .count();
    record.say(format!(
        "In {ahead} of {} tasks no flow is at once faster than enact's, as exact to rounding in the turn and its derivative, \
         and more exact in one.",
        tasks().count()
    ));
    record.table(fronts(&turnings));
    record.table(references(&turnings));
    record.numbers("flow", &turnings)
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
pub fn time_s(quick: bool, mut call: impl FnMut()) -> [f64; 2] {
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
