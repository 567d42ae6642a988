//! What one estimate costs when there are more samples, and when there are more segments.

use std::collections::BTreeMap;

use anyhow::Result;
use enact::motion::{Phase, Verdict};
use serde::Serialize;

use crate::results::Options;
use crate::statistics::{exponent, median};
use crate::stopwatch::Stopwatch;
use crate::table::{Table, number};
use enact_tools::case::Case;
use enact_tools::perform::{Acting, Style, bounces};

/// Runs of each size; the medians count.
const RUNS: usize = 5;
/// Phases told apart.
pub const PHASES: [Phase; 7] = [
    Phase::Clean,
    Phase::Marks,
    Phase::ArcFits,
    Phase::Sweep,
    Phase::Multipliers,
    Phase::Finish,
    Phase::Covariance,
];
/// Phases that iterate.
const SOLVER: [Phase; 3] = [Phase::Sweep, Phase::Multipliers, Phase::Finish];

/// One size.
#[derive(Serialize)]
pub struct Size {
    pub what: &'static str,
    pub samples: usize,
    pub segments: usize,
    pub verdict: &'static str,
    pub reason: String,
    pub iterations: usize,
    /// Of sweep, multiplier rounds and finish, per iteration \[s\].
    pub per_iteration_s: f64,
    /// Of sweep, multiplier rounds and finish \[s\].
    pub solver_s: f64,
    /// Of everything, the median and the fastest run \[s\].
    pub total_s: f64,
    pub fastest_s: f64,
    pub phases_s: BTreeMap<&'static str, f64>,
}

/// Runs it.
pub fn run(options: &Options) -> Result<()> {
    // From 100 samples on, half a power of ten more each time.
    let sizes = |last: i32| (0..=last).map(|half| 100.0 * 10f64.powf(0.5 * f64::from(half)));
    let of = |what: &'static str, last: i32, case: fn(f64) -> Case| -> Vec<Size> {
        let found = sizes(last).filter_map(|count| size(what, &case(count), RUNS));
        found.collect()
    };
    let samples = of("samples, timing known", 8, timing_known);
    let title = "Cost against samples (pencil, tip first, timing known)";
    options.show(table(title, &samples, |s| s.samples));
    let unknown = of("samples, timing unknown", 6, timing_unknown);
    let title = "Cost against samples (pencil, tip first, timing unknown)";
    options.show(table(title, &unknown, |s| s.samples));
    let mut segments = Vec::new();
    for count in [1, 3, 10, 30, 100, 300, 1000] {
        let Some(case) = bouncing(count) else {
            eprintln!("no motion with {count} bounces was found");
            continue;
        };
        segments.extend(size("segments, timing known", &case, RUNS));
    }
    let title = "Cost against segments (cube, timing known, wander 0.25×)";
    options.show(table(title, &segments, |s| s.segments));
    options.show(shares(&[&samples, &unknown, &segments]));
    options.write_json("scaling", &[samples, unknown, segments])
}

/// A pencil, tip first, in about so many samples with stamps of physical times.
pub fn timing_known(count: f64) -> Case {
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
pub fn timing_unknown(count: f64) -> Case {
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
pub fn bouncing(count: usize) -> Option<Case> {
    let truth = bounces(count, 1).ok()?;
    let acting = Acting {
        distortion: 0.25,
        ..Acting::timing_known()
    };
    Some(Case::new(&truth, &acting, 1))
}

/// Medians of several runs; none where there is nothing to estimate from.
pub fn size(what: &'static str, case: &Case, runs: usize) -> Option<Size> {
    let mut watches = Vec::new();
    let mut last = None;
    for _ in 0..runs {
        let mut stopwatch = Stopwatch::default();
        match case.estimated(&mut stopwatch) {
            Ok(outcome) => last = Some(outcome),
            Err(error) => eprintln!("{what}: {error}"),
        }
        let long = stopwatch.total_s() > 20.0;
        watches.push(stopwatch);
        if long {
            break;
        }
    }
    let outcome = last?;
    let of = |value: &dyn Fn(&Stopwatch) -> f64| {
        median(&watches.iter().map(value).collect::<Vec<f64>>())
    };
    let solver_s = of(&|w| SOLVER.iter().map(|phase| w.spent_s(*phase)).sum());
    let estimate = &outcome.estimate;
    let iterations = estimate.counters.iterations;
    Some(Size {
        what,
        samples: outcome.counts.used,
        segments: estimate.arcs.len(),
        verdict: estimate.verdict.as_str(),
        reason: enact::report::reason_text(&outcome.scene, &estimate.reason),
        iterations,
        per_iteration_s: solver_s / iterations.max(1) as f64,
        solver_s,
        fastest_s: watches
            .iter()
            .map(Stopwatch::total_s)
            .fold(f64::INFINITY, f64::min),
        total_s: of(&Stopwatch::total_s),
        phases_s: PHASES
            .iter()
            .map(|phase| (phase.as_str(), of(&|w| w.spent_s(*phase))))
            .collect(),
    })
}

fn table(title: &str, sizes: &[Size], by: impl Fn(&Size) -> usize) -> Table {
    let mut table = Table::new(
        title,
        &[
            "samples",
            "segments",
            "verdict",
            "iterations",
            "per iteration ms",
            "solver ms",
            "total ms",
            "total per sample µs",
        ],
    );
    for size in sizes {
        table.row([
            size.samples.to_string(),
            size.segments.to_string(),
            size.verdict.to_owned(),
            size.iterations.to_string(),
            number(1e3 * size.per_iteration_s),
            number(1e3 * size.solver_s),
            number(1e3 * size.total_s),
            number(1e6 * size.total_s / size.samples as f64),
        ]);
    }
    let x: Vec<f64> = sizes.iter().map(|size| by(size) as f64).collect();
    let fitted = |value: &dyn Fn(&Size) -> f64| {
        let y: Vec<f64> = sizes.iter().map(value).collect();
        // The upper half, where what does not grow no longer hides what does.
        let half = x.len() / 2;
        format!(
            "{:.2} ({:.2})",
            exponent(&x, &y),
            exponent(&x[half..], &y[half..])
        )
    };
    table.row([
        "exponent (of the upper half)".to_owned(),
        String::new(),
        if sizes
            .iter()
            .all(|s| s.verdict == Verdict::Physical.as_str())
        {
            "all physical"
        } else {
            "not all physical"
        }
        .to_owned(),
        fitted(&|size| size.iterations as f64),
        fitted(&|size| size.per_iteration_s),
        fitted(&|size| size.solver_s),
        fitted(&|size| size.total_s),
        String::new(),
    ]);
    table
}

/// What the phases are of the largest size.
fn shares(studies: &[&[Size]]) -> Table {
    let mut header = vec!["", "samples", "segments"];
    header.extend(PHASES.map(Phase::as_str));
    let mut table = Table::new("Phases of the largest size [ms]", &header);
    for size in studies.iter().filter_map(|sizes| sizes.last()) {
        let head = [
            size.what.to_owned(),
            size.samples.to_string(),
            size.segments.to_string(),
        ];
        let phases = PHASES
            .iter()
            .map(|phase| number(1e3 * size.phases_s[phase.as_str()]));
        table.row(head.into_iter().chain(phases));
    }
    table
}
