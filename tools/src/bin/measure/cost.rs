//! How cost grows with samples, bounces and bodies, and where the time of one estimate goes.

mod crowd;
pub mod memory;
mod phases;
mod show;
mod size;

use anyhow::Result;
use serde::Serialize;

use crate::options::Options;
use crate::record::Record;
use enact_tools::case::Case;
use enact_tools::perform::{Acting, Style, bounces};
use size::Size;

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
        record.figure(show::times(name, label, title, &own));
        record.figure(show::memory(name, label, &own));
    }
    for swept in &swept {
        record.table(show::sizes(swept));
    }
    record.table(show::exponents(&swept));
    record.table(show::largest(&swept));
    let power = |curve: &str| {
        let of = swept.iter().find(|swept| swept.curve == curve);
        of.map_or(f64::NAN, |swept| {
            show::upper(swept, |grown| grown.size.fastest_s)
        })
    };
    record.say(format!(
        "Over the larger half of the sizes the time of an estimate grows with the power {:.2} of the samples (timing known), {:.2} of the bounces and {:.2} of the bodies.",
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
