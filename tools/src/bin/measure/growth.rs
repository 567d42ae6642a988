//! Part 6: how cost grows with samples, events and bodies, and where the time of one estimate goes.

mod crowd;

use std::env;
use std::fs;
use std::hint::black_box;
use std::process::Command;
use std::time::Instant;

use anyhow::Result;
use enact::estimate::point::Point;
use enact::estimate::samples;
use enact::motion::Verdict;
use serde::Serialize;

use crate::Options;
use crate::book::Book;
use crate::figure::{Axis, Curve, Figure, Mark, Sheet};
use crate::scaling::{self, PHASES, Size};
use crate::statistics::exponent;
use enact_tools::case::{Case, Posed};
use enact_tools::perform::{Acting, Style, hat_box};

/// A size, and what else it took.
#[derive(Serialize)]
struct Grown {
    /// Samples, events or bodies.
    count: usize,
    #[serde(flatten)]
    size: Size,
    /// Most memory in use during the estimate beyond what was before it \[bytes\]; none where the
    /// system does not say.
    memory_bytes: Option<u64>,
}

/// What grows, and how far.
struct Sweep {
    name: &'static str,
    curve: &'static str,
    counts: Vec<usize>,
    case: fn(usize) -> Option<Case>,
}

/// All of them.
fn sweeps(quick: bool) -> [Sweep; 4] {
    let powers =
        |last: i32| (4..=last).map(|half| 10f64.powf(0.5 * f64::from(half)).round() as usize);
    let (known, unknown) = if quick { (8, 6) } else { (12, 9) };
    let (most, crowded) = if quick { (30, 8) } else { (1000, 64) };
    let upto = |counts: &[usize], most: usize| {
        let counts = counts.iter().copied();
        counts.filter(|count| *count <= most).collect()
    };
    [
        Sweep {
            name: "samples",
            curve: "timing known",
            counts: powers(known).collect(),
            case: |count| Some(scaling::timing_known(count as f64)),
        },
        Sweep {
            name: "samples",
            curve: "timing unknown",
            counts: powers(unknown).collect(),
            case: |count| Some(scaling::timing_unknown(count as f64)),
        },
        Sweep {
            name: "events",
            curve: "bounces of a cube",
            counts: upto(&[1, 3, 10, 30, 100, 300, 1000], most),
            case: scaling::bouncing,
        },
        Sweep {
            name: "bodies",
            curve: "cubes with a bounce each",
            counts: upto(&[1, 2, 4, 8, 16, 32, 64], crowded),
            case: |count| Some(crowd::crowd(count)),
        },
    ]
}

/// Sizes are not made larger once one takes this long \[s\].
const LONG_S: f64 = 15.0;

/// Runs it.
pub fn run(options: &Options, book: &mut Book) -> Result<()> {
    let sweeps = sweeps(options.quick);
    let mut all = Vec::new();
    for sweep in &sweeps {
        all.push((
            sweep.name,
            sweep.curve,
            grown(sweep, if options.quick { 1 } else { 3 }),
        ));
    }
    for (name, label, title) in [
        (
            "samples",
            "samples in the estimate",
            "How the time of an estimate grows with samples (pencil, tip first)",
        ),
        (
            "events",
            "bounces",
            "How the time of an estimate grows with bounces (cube, timing known, a quarter of the wander)",
        ),
        (
            "bodies",
            "bodies",
            "How the time of an estimate grows with bodies (cubes with one bounce each, timing known)",
        ),
    ] {
        let own: Vec<_> = all.iter().filter(|(of, ..)| *of == name).collect();
        book.keep(times(name, label, title, &own))?;
        book.keep(memory(name, label, &own))?;
    }
    book.tabulate(exponents(&all))?;
    book.numbers("growth", &all)?;
    profile(options, book)
}

type Sized = (&'static str, &'static str, Vec<Grown>);

fn grown(sweep: &Sweep, runs: usize) -> Vec<Grown> {
    let mut all: Vec<Grown> = Vec::new();
    for count in &sweep.counts {
        let Some(case) = (sweep.case)(*count) else {
            eprintln!("{}: no case of {count}", sweep.curve);
            continue;
        };
        let size = scaling::size(sweep.curve, &case, runs);
        let memory_bytes = memory_of_another(sweep.curve, *count);
        let Some(size) = size else { continue };
        let is_long = size.total_s > LONG_S;
        all.push(Grown {
            count: if sweep.name == "samples" {
                size.samples
            } else {
                *count
            },
            size,
            memory_bytes,
        });
        if is_long {
            break;
        }
    }
    all
}

/// What [`peak_bytes`] says in a process of its own: one that has estimated before uses again what
/// it has kept.
fn memory_of_another(curve: &str, count: usize) -> Option<u64> {
    let output = Command::new(env::current_exe().ok()?)
        .args(["--memory", &format!("{count} {curve}")])
        .output()
        .ok()?;
    String::from_utf8(output.stdout).ok()?.trim().parse().ok()
}

/// The most memory in use during one estimate beyond what was before it \[bytes\]; the size by its
/// count and the name of its curve.
pub fn peak_bytes(size: &str) -> Option<u64> {
    let (count, curve) = size.split_once(' ')?;
    let sweeps = sweeps(false);
    let sweep = sweeps.iter().find(|sweep| sweep.curve == curve)?;
    let case = (sweep.case)(count.parse().ok()?)?;
    fs::write("/proc/self/clear_refs", "5").ok()?;
    let before_bytes = status("VmRSS:")?;
    let estimated = case.estimated(&mut ());
    let peak_bytes = status("VmHWM:")?;
    estimated.ok()?;
    Some(peak_bytes.saturating_sub(before_bytes))
}

/// A figure of the process's status \[bytes\].
fn status(key: &str) -> Option<u64> {
    let text = fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find(|line| line.starts_with(key))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(1024 * kib)
}

fn failed(grown: &Grown) -> bool {
    grown.size.verdict != Verdict::Physical.as_str()
}

/// The exponent over the upper half, where what does not grow no longer hides what does.
fn upper_exponent(sizes: &[Grown], value: impl Fn(&Grown) -> f64) -> f64 {
    let good: Vec<&Grown> = sizes.iter().filter(|size| !failed(size)).collect();
    let upper = &good[good.len() / 2..];
    let x: Vec<f64> = upper.iter().map(|size| size.count as f64).collect();
    let y: Vec<f64> = upper.iter().map(|size| value(size)).collect();
    exponent(&x, &y)
}

fn times(name: &str, label: &str, title: &str, all: &[&Sized]) -> Figure {
    let mut curves = Vec::new();
    for (_, curve, sizes) in all {
        let total = sizes.iter().map(|grown| Mark {
            spread: Some([grown.size.fastest_s, grown.size.total_s]),
            failed: failed(grown),
            ..Mark::at(grown.count as f64, grown.size.fastest_s)
        });
        let power = upper_exponent(sizes, |grown| grown.size.fastest_s);
        curves.push(Curve::ours(
            format!("{curve}: whole estimate, power {power:.2}"),
            total.collect(),
        ));
        let each = sizes.iter().map(|grown| Mark {
            failed: failed(grown),
            ..Mark::at(grown.count as f64, grown.size.per_iteration_s)
        });
        let power = upper_exponent(sizes, |grown| grown.size.per_iteration_s);
        curves.push(Curve::new(
            format!("{curve}: one iteration, power {power:.2}"),
            each.collect(),
        ));
    }
    // Two that are ours would look alike.
    for curve in curves.iter_mut().skip(2) {
        curve.role = crate::figure::Role::Compared;
    }
    Figure {
        name: format!("growth_{name}"),
        title: title.to_owned(),
        note: "Fastest of up to three runs, bars to their median. Powers are fitted over the upper half of \
               the sizes. A cross: the estimate did not end as a physical motion."
            .to_owned(),
        x: Axis::logarithmic(label),
        y: Axis::logarithmic("time [s]"),
        curves,
    }
}

fn memory(name: &str, label: &str, all: &[&Sized]) -> Figure {
    let mut curves = Vec::new();
    for (_, curve, sizes) in all {
        let marks = sizes.iter().filter_map(|grown| {
            let bytes = grown.memory_bytes.filter(|bytes| *bytes > 0)?;
            Some(Mark {
                failed: failed(grown),
                ..Mark::at(grown.count as f64, bytes as f64 / 1e6)
            })
        });
        curves.push(Curve::new(*curve, marks.collect()));
    }
    Figure {
        name: format!("growth_{name}_memory"),
        title: format!(
            "Most memory in use during an estimate, beyond what was before it, against {name}"
        ),
        note: "As the system counts it (VmHWM), each in a process of its own.".to_owned(),
        x: Axis::logarithmic(label),
        y: Axis::logarithmic("memory [MB]"),
        curves,
    }
}

fn exponents(all: &[Sized]) -> Sheet {
    let rows = all.iter().map(|(name, curve, sizes)| {
        let power = |value: &dyn Fn(&Grown) -> f64| format!("{:.2}", upper_exponent(sizes, value));
        let (first, last) = (sizes.first(), sizes.last());
        let range = first
            .zip(last)
            .map(|(a, b)| format!("{} to {}", a.count, b.count));
        let most = sizes.iter().max_by_key(|grown| grown.count);
        vec![
            (*name).to_owned(),
            (*curve).to_owned(),
            range.unwrap_or_default(),
            power(&|grown| grown.size.fastest_s),
            power(&|grown| grown.size.per_iteration_s),
            power(&|grown| grown.size.iterations as f64),
            most.map_or(String::new(), |grown| {
                format!("{:.3} s, {}", grown.size.fastest_s, grown.size.verdict)
            }),
        ]
    });
    let header = [
        "what grows",
        "on",
        "range",
        "power of the whole time",
        "of an iteration",
        "of the iterations",
        "the largest took",
    ];
    Sheet {
        name: "growth_exponents".to_owned(),
        header: header.map(str::to_owned).to_vec(),
        rows: rows.collect(),
        ..Sheet::default()
    }
}

/// Where the time of one estimate goes.
fn profile(options: &Options, book: &mut Book) -> Result<()> {
    let known = Acting::timing_known();
    let cases = [
        ("pencil, timing known", Case::pencil(Style::Tip, &known, 1)),
        (
            "pencil, timing unknown",
            Case::pencil(Style::Tip, &Acting::default(), 1),
        ),
        (
            "hat and box, timing known",
            Case::new(&hat_box::truth(), &known, 1),
        ),
        (
            "cube, 8 bounces",
            scaling::bouncing(8).expect("a motion with 8 bounces"),
        ),
    ];
    let runs = if options.quick { 5 } else { 51 };
    let mut names: Vec<String> = PHASES.map(|phase| phase.as_str().to_owned()).to_vec();
    names.extend(["all".to_owned(), "floor".to_owned()]);
    let mut curves = Vec::new();
    let mut rows = Vec::new();
    for (name, case) in &cases {
        let Some(size) = scaling::size("profile", case, runs) else {
            continue;
        };
        let floor_s = floor_s(case, options.quick) * size.iterations as f64;
        let spent = PHASES.map(|phase| size.phases_s[phase.as_str()]);
        let all = spent.into_iter().chain([size.total_s, floor_s]);
        let marks = all.enumerate().map(|(at, s)| Mark::at(at as f64, 1e3 * s));
        curves.push(Curve::new(
            *name,
            marks.filter(|mark| mark.y > 0.0).collect(),
        ));
        rows.push(vec![
            (*name).to_owned(),
            size.samples.to_string(),
            size.iterations.to_string(),
            format!("{:.3} ms", 1e3 * size.total_s),
            format!("{:.3} ms", 1e3 * floor_s),
            format!("{:.1}", size.total_s / floor_s),
            format!("{:.1}", size.solver_s / floor_s),
        ]);
    }
    book.keep(Figure {
        name: "growth_profile".to_owned(),
        title: "Where the time of one estimate goes, beside the floor of evaluating every sample once per iteration".to_owned(),
        note: format!(
            "Medians of {runs} runs. The floor: residual and derivative of every sample by state and time, \
             times the iterations that the estimate took."
        ),
        x: Axis::named("phase", names),
        y: Axis::logarithmic("time [ms]"),
        curves,
    })?;
    let header = [
        "scene",
        "samples",
        "iterations",
        "whole estimate",
        "floor",
        "whole over floor",
        "iterating phases over floor",
    ];
    book.tabulate(Sheet {
        name: "growth_profile".to_owned(),
        header: header.map(str::to_owned).to_vec(),
        rows,
        ..Sheet::default()
    })
}

/// Residuals and derivatives of all samples, once, at the estimate's own first guess \[s\].
fn floor_s(case: &Case, quick: bool) -> f64 {
    let outcome = case.estimated(&mut ()).expect("it was estimated before");
    let posed = Posed::without_marks(case.scene(), &outcome.sketch);
    let (problem, guess) = (&posed.problem, &posed.guesses[0]);
    let point = Point::new(problem, guess);
    let gravity = problem.gravity(&point.parameters);
    let evaluate = || {
        for (index, arc) in problem.arcs.iter().enumerate() {
            let flight = (&point.arcs[index], guess.arcs[index].epoch_s);
            let times_s = &point.node_times_s;
            let each = |node, terms| {
                black_box((node, &terms));
            };
            let terms = samples::unknown_times(problem, (arc, 1), flight, &gravity, times_s, each);
            black_box(&terms);
        }
    };
    let repeats = if quick { 20 } else { 200 };
    let mut fastest_s = f64::INFINITY;
    for _ in 0..repeats {
        let begin = Instant::now();
        evaluate();
        fastest_s = fastest_s.min(begin.elapsed().as_secs_f64());
    }
    fastest_s
}
