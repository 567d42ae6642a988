//! How cost grows with samples, bounces and bodies, and where the time of one estimate goes.

mod crowd;
pub mod memory;
mod phases;
mod size;

use anyhow::Result;
use enact::motion::{Phase, Verdict};
use serde::Serialize;

use crate::figure::{Axis, Curve, Figure, Mark};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::exponent;
use crate::table::{Table, number};
use enact_tools::case::Case;
use enact_tools::perform::{Acting, Style, bounces};
use size::{PHASES, Size};

/// Sizes are not made larger once one takes this long \[s\].
const LONG_S: f64 = 15.0;

/// What grows, and how far.
struct Sweep {
    /// What grows.
    name: &'static str,
    /// On what.
    curve: &'static str,
    counts: Vec<usize>,
    case: fn(usize) -> Option<Case>,
}

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

/// A sweep and what became of it.
#[derive(Serialize)]
struct Swept {
    name: &'static str,
    curve: &'static str,
    sizes: Vec<Grown>,
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let runs = options.either(1, 5);
    let swept: Vec<Swept> = sweeps(options.quick)
        .iter()
        .map(|sweep| grown(sweep, runs))
        .collect();
    for (name, label, title) in [
        (
            "samples",
            "samples in the estimate",
            "How the time of an estimate grows with samples (pencil, tip first)",
        ),
        (
            "bounces",
            "bounces",
            "How the time of an estimate grows with bounces (cube, timing known, a quarter of the wander)",
        ),
        (
            "bodies",
            "bodies",
            "How the time of an estimate grows with bodies (cubes with one bounce each, timing known)",
        ),
    ] {
        let own: Vec<&Swept> = swept.iter().filter(|swept| swept.name == name).collect();
        record.figure(times(name, label, title, &own));
        record.figure(memory_figure(name, label, &own));
    }
    for swept in &swept {
        record.table(sizes(swept));
    }
    record.table(exponents(&swept));
    record.table(largest(&swept));
    let power = |curve: &str| {
        let of = swept.iter().find(|swept| swept.curve == curve);
        of.map_or(f64::NAN, |swept| upper(swept, |grown| grown.size.fastest_s))
    };
    record.say(format!(
        "The time of an estimate grows with the power {:.2} of the samples (timing known), {:.2} of the bounces and {:.2} of the bodies.",
        power(KNOWN), power(BOUNCES), power(BODIES),
    ));
    record.numbers("sizes", &swept)?;
    phases::run(options, record)
}

const KNOWN: &str = "samples, timing known";
const BOUNCES: &str = "bounces of a cube";
const BODIES: &str = "cubes with a bounce each";

/// All of them.
fn sweeps(quick: bool) -> [Sweep; 4] {
    let powers = |last: i32| {
        let halves = (4..=last).map(|half| 10f64.powf(0.5 * f64::from(half)));
        halves.map(|count| count.round() as usize).collect()
    };
    let (known, unknown) = if quick { (6, 5) } else { (12, 10) };
    let (most, crowded) = if quick { (10, 4) } else { (1000, 64) };
    let upto = |counts: &[usize], most: usize| {
        let counts = counts.iter().copied();
        counts.filter(|count| *count <= most).collect()
    };
    [
        Sweep {
            name: "samples",
            curve: KNOWN,
            counts: powers(known),
            case: |count| Some(timing_known(count as f64)),
        },
        Sweep {
            name: "samples",
            curve: "samples, timing unknown",
            counts: powers(unknown),
            case: |count| Some(timing_unknown(count as f64)),
        },
        Sweep {
            name: "bounces",
            curve: BOUNCES,
            counts: upto(&[1, 3, 10, 30, 100, 300, 1000], most),
            case: bouncing,
        },
        Sweep {
            name: "bodies",
            curve: BODIES,
            counts: upto(&[1, 2, 4, 8, 16, 32, 64], crowded),
            case: |count| Some(crowd::crowd(count)),
        },
    ]
}

/// A pencil, tip first, in about so many samples with stamps of physical times.
fn timing_known(count: f64) -> Case {
    let truth = Style::Tip.truth();
    let rate_hz = count / truth.duration_s;
    let acting = Acting {
        rate_hz,
        // The stamps of a mark and of samples stay within a sample of each other.
        mark_error_s: 0.5 / rate_hz,
        ..Acting::timing_known()
    };
    Case::new(&truth, &acting, 1)
}

/// The same, acted slowly.
fn timing_unknown(count: f64) -> Case {
    let truth = Style::Tip.truth();
    let slow = Acting {
        hold_after_s: 0.0,
        ..Acting::default()
    };
    let rate_hz = count / truth.duration_s / slow.slowdown;
    let acting = Acting {
        rate_hz,
        stamp_jitter_s: 0.05 / rate_hz,
        ..slow
    };
    Case::new(&truth, &acting, 1)
}

/// A cube that bounces so often, if such a motion is found; a quarter of the wander.
fn bouncing(count: usize) -> Option<Case> {
    let truth = bounces(count, 1).ok()?;
    let acting = Acting {
        distortion: 0.25,
        ..Acting::timing_known()
    };
    Some(Case::new(&truth, &acting, 1))
}

fn grown(sweep: &Sweep, runs: usize) -> Swept {
    let mut sizes: Vec<Grown> = Vec::new();
    for count in &sweep.counts {
        let Some(case) = (sweep.case)(*count) else {
            eprintln!("  {}: no case of {count}", sweep.curve);
            continue;
        };
        let Some(size) = Size::of(&case, runs) else {
            continue;
        };
        let is_long = size.total_s > LONG_S;
        sizes.push(Grown {
            count: if sweep.name == "samples" {
                size.samples
            } else {
                *count
            },
            size,
            memory_bytes: memory::of_another(sweep.curve, *count),
        });
        if is_long {
            break;
        }
    }
    Swept {
        name: sweep.name,
        curve: sweep.curve,
        sizes,
    }
}

fn failed(grown: &Grown) -> bool {
    grown.size.verdict != Verdict::Physical.as_str()
}

/// The exponent over the upper half of what succeeded, where what does not grow no longer hides what does.
fn upper(swept: &Swept, value: impl Fn(&Grown) -> f64) -> f64 {
    let good: Vec<&Grown> = swept.sizes.iter().filter(|size| !failed(size)).collect();
    let upper = &good[good.len() / 2..];
    let x: Vec<f64> = upper.iter().map(|size| size.count as f64).collect();
    let y: Vec<f64> = upper.iter().map(|size| value(size)).collect();
    exponent(&x, &y)
}

fn times(name: &str, label: &str, title: &str, all: &[&Swept]) -> Figure {
    let mut curves = Vec::new();
    for (index, swept) in all.iter().enumerate() {
        let mark = |grown: &Grown, y: f64| Mark {
            failed: failed(grown),
            ..Mark::at(grown.count as f64, y)
        };
        let total = swept.sizes.iter().map(|grown| Mark {
            spread: Some([grown.size.fastest_s, grown.size.total_s]),
            ..mark(grown, grown.size.fastest_s)
        });
        let power = upper(swept, |grown| grown.size.fastest_s);
        let whole = format!("{}: whole estimate, power {power:.2}", swept.curve);
        curves.push(match index {
            0 => Curve::ours(whole, total.collect()),
            _ => Curve::new(whole, total.collect()),
        });
        let each = swept
            .sizes
            .iter()
            .map(|grown| mark(grown, grown.size.per_iteration_s));
        let power = upper(swept, |grown| grown.size.per_iteration_s);
        let one = format!("{}: one iteration, power {power:.2}", swept.curve);
        curves.push(Curve::new(one, each.collect()));
    }
    Figure {
        name: format!("cost_{name}"),
        title: title.to_owned(),
        note: "Fastest of up to five runs, bars to their median. Powers are fitted over the upper half of \
               the sizes. A cross: the estimate did not end as a physical motion."
            .to_owned(),
        x: Axis::logarithmic(label),
        y: Axis::logarithmic("time [s]"),
        curves,
    }
}

fn memory_figure(name: &str, label: &str, all: &[&Swept]) -> Figure {
    let curve = |swept: &&Swept| {
        let marks = swept.sizes.iter().filter_map(|grown| {
            let bytes = grown.memory_bytes.filter(|bytes| *bytes > 0)?;
            Some(Mark {
                failed: failed(grown),
                ..Mark::at(grown.count as f64, bytes as f64 / 1e6)
            })
        });
        Curve::new(swept.curve, marks.collect())
    };
    Figure {
        name: format!("cost_{name}_memory"),
        title: format!(
            "Most memory in use during an estimate, beyond what was before it, against {name}"
        ),
        note: "As the system counts it (VmHWM), each in a process of its own.".to_owned(),
        x: Axis::logarithmic(label),
        y: Axis::logarithmic("memory [MB]"),
        curves: all.iter().map(curve).collect(),
    }
}

/// Every size of a sweep.
fn sizes(swept: &Swept) -> Table {
    let header = [
        "samples",
        "flights",
        "verdict",
        "iterations",
        "per iteration ms",
        "solver ms",
        "total ms",
        "total per sample µs",
    ];
    let name = swept.curve.replace([',', ' '], "_").replace("__", "_");
    let mut table = Table::new(&name, &format!("Cost against {}", swept.curve), &header);
    for Grown { size, .. } in &swept.sizes {
        table.row([
            size.samples.to_string(),
            size.flights.to_string(),
            size.verdict.to_owned(),
            size.iterations.to_string(),
            number(1e3 * size.per_iteration_s),
            number(1e3 * size.solver_s),
            number(1e3 * size.total_s),
            number(1e6 * size.total_s / size.samples as f64),
        ]);
    }
    table
}

/// Fitted powers, over all sizes and over the upper half.
fn exponents(all: &[Swept]) -> Table {
    let header = [
        "what grows",
        "range",
        "power of the whole time (of the upper half)",
        "of the solver's",
        "of an iteration's",
        "of the iterations",
        "the largest took",
    ];
    let mut table = Table::new("exponents", "", &header);
    for swept in all {
        let counts: Vec<f64> = swept.sizes.iter().map(|grown| grown.count as f64).collect();
        let power = |value: &dyn Fn(&Grown) -> f64| {
            let values: Vec<f64> = swept.sizes.iter().map(value).collect();
            format!(
                "{:.2} ({:.2})",
                exponent(&counts, &values),
                upper(swept, value)
            )
        };
        let Some((first, last)) = swept.sizes.first().zip(swept.sizes.last()) else {
            continue;
        };
        table.row([
            swept.curve.to_owned(),
            format!("{} to {}", first.count, last.count),
            power(&|grown| grown.size.fastest_s),
            power(&|grown| grown.size.solver_s),
            power(&|grown| grown.size.per_iteration_s),
            power(&|grown| grown.size.iterations as f64),
            format!("{:.3} s, {}", last.size.fastest_s, last.size.verdict),
        ]);
    }
    table
}

/// The phases of the largest size of each sweep.
fn largest(all: &[Swept]) -> Table {
    let mut header = vec!["what grows", "samples", "flights"];
    header.extend(PHASES.map(Phase::as_str));
    let mut table = Table::new("largest", "Phases of the largest size [ms]", &header);
    for swept in all {
        let Some(Grown { size, .. }) = swept.sizes.last() else {
            continue;
        };
        let head = [
            swept.curve.to_owned(),
            size.samples.to_string(),
            size.flights.to_string(),
        ];
        table.row(
            head.into_iter()
                .chain(size.phases_s.map(|s| number(1e3 * s))),
        );
    }
    table
}
