//! Cubes of any size and speed that bounce, at any rate of samples, with marks as people and as
//! annotators make them: how often the best known optimum is found.

use std::time::Instant;

use anyhow::Result;
use enact::motion::Verdict;
use serde::Serialize;

use crate::results::Options;
use crate::statistics::{largest, median};
use crate::table::{Table, number, percent};
use enact_tools::case::{Case, Posed};
use enact_tools::perform::{Acting, Polyhedron, Throw, hat_box, thrown};
use enact_tools::starts::{is_best, lowest, starts};

/// How marks and stamps are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
enum Marks {
    /// At the very time of the event, stamps physical.
    Exact,
    /// Within a sample, stamps physical.
    Sample,
    /// As people press a button, stamps physical.
    Human,
    /// As people press a button while they act slowly; the tempo is unknown.
    Slow,
}

impl Marks {
    fn acting(self, rate_hz: f64, distortion: f64) -> Acting {
        let known = Acting {
            rate_hz,
            distortion,
            ..Acting::timing_known()
        };
        match self {
            Marks::Exact => Acting {
                mark_error_s: 0.0,
                ..known
            },
            Marks::Sample => known,
            Marks::Human => Acting {
                mark_error_s: 0.03,
                ..known
            },
            Marks::Slow => Acting {
                rate_hz,
                distortion,
                ..Acting::default()
            },
        }
    }
}

/// A row of the table; no throw: the hat and the box.
#[derive(Clone, Copy)]
struct Row {
    throw: Option<Throw>,
    bounces: usize,
    rate_hz: f64,
    marks: Marks,
    distortion: f64,
}

impl Row {
    fn name(&self) -> String {
        let what = self.throw.map_or("hat and box".into(), |throw| {
            let (side_mm, fastest) = (2e3 * throw.half_m, throw.fastest_rad_s);
            format!(
                "{side_mm:.0} mm, {fastest:.0} rad/s, {} bounces",
                self.bounces
            )
        });
        let Self {
            rate_hz,
            marks,
            distortion,
            ..
        } = self;
        format!("{what}, {rate_hz:.0} Hz, {marks:?} marks, {distortion}x")
    }
}

fn rows() -> Vec<Row> {
    let die = |throw: Throw, bounces, rate_hz, marks| Row {
        throw: Some(throw),
        bounces,
        rate_hz,
        marks,
        distortion: 1.0,
    };
    let mut rows = Vec::new();
    for marks in [Marks::Exact, Marks::Sample, Marks::Human, Marks::Slow] {
        for bounces in [4, 8, 12, 20] {
            rows.push(die(Throw::DIE, bounces, 120.0, marks));
        }
        rows.push(Row {
            throw: None,
            bounces: 0,
            rate_hz: 120.0,
            marks,
            distortion: 1.0,
        });
    }
    for (side_m, fastest_rad_s) in [
        (0.005, 200.0),
        (0.016, 100.0),
        (0.03, 50.0),
        (0.1, 20.0),
        (0.3, 5.0),
        (0.3, 12.0),
        (1.0, 5.0),
    ] {
        let throw = Throw::sized(side_m, fastest_rad_s);
        rows.extend([120.0, 240.0].map(|rate_hz| die(throw, 4, rate_hz, Marks::Sample)));
    }
    for rate_hz in [60.0, 500.0, 1000.0] {
        rows.push(die(Throw::sized(0.03, 50.0), 4, rate_hz, Marks::Sample));
    }
    rows
}

/// One performance.
#[derive(Serialize)]
struct Seed {
    row: String,
    seed: u64,
    /// Whether the solver closed every gap.
    is_closed: bool,
    /// With all checks.
    verdict: &'static str,
    reason: String,
    objective: f64,
    lowest: Option<f64>,
    is_best: bool,
    /// Largest distance of an event from the true one \[ms\].
    event_error_ms: f64,
    iterations: usize,
    time_ms: f64,
}

/// Runs it.
pub fn run(options: &Options) -> Result<()> {
    let header = [
        "row",
        "n",
        "gaps closed",
        "physical",
        "plausible",
        "best known optimum",
        "event error ms median (max)",
        "iterations median (max)",
        "time ms median (max)",
    ];
    let mut table = Table::new("Sizes, speeds, rates and marks", &header);
    let mut all = Vec::new();
    for row in rows() {
        if !options.wants(&row.name()) {
            continue;
        }
        let seeds = options.range();
        let seeds: Vec<Seed> = seeds.filter_map(|seed| judged(&row, seed)).collect();
        let count = |holds: &dyn Fn(&Seed) -> bool| {
            percent(seeds.iter().filter(|seed| holds(seed)).count(), seeds.len())
        };
        let both = |value: &dyn Fn(&Seed) -> f64| {
            let values: Vec<f64> = seeds.iter().map(value).collect();
            format!("{} ({})", number(median(&values)), number(largest(&values)))
        };
        table.row([
            row.name(),
            seeds.len().to_string(),
            count(&|seed| seed.is_closed),
            count(&|seed| seed.verdict == "physical"),
            count(&|seed| seed.verdict == "plausible"),
            count(&|seed| seed.is_best),
            both(&|seed| seed.event_error_ms),
            both(&|seed| seed.iterations as f64),
            both(&|seed| seed.time_ms),
        ]);
        all.extend(seeds);
    }
    options.show(&table);
    if options.only.is_some() {
        let missed = all.iter().filter(|seed: &&Seed| !seed.is_best);
        for Seed {
            row,
            seed,
            verdict,
            reason,
            objective,
            lowest,
            ..
        } in missed
        {
            println!("{row}, seed {seed}: {verdict}, {objective:.1}, {lowest:.1?}: {reason}");
        }
        return Ok(());
    }
    options.write_json("scales", &all)
}

fn judged(row: &Row, seed: u64) -> Option<Seed> {
    let truth = match row.throw {
        Some(throw) => thrown(Polyhedron::Cube, &throw, row.bounces, seed).ok()?,
        None => hat_box::truth(),
    };
    let case = Case::new(&truth, &row.marks.acting(row.rate_hz, row.distortion), seed);
    let mut result = Seed {
        row: row.name(),
        seed,
        is_closed: false,
        verdict: "refused",
        reason: String::new(),
        objective: f64::NAN,
        lowest: None,
        is_best: false,
        event_error_ms: f64::NAN,
        iterations: 0,
        time_ms: 0.0,
    };
    let pipeline = case.pipeline();
    let began = Instant::now();
    let outcome = match pipeline.estimate(&mut ()) {
        Ok(outcome) => outcome,
        Err(error) => {
            result.reason = error.to_string();
            return Some(result);
        }
    };
    result.time_ms = began.elapsed().as_secs_f64() * 1e3;
    let estimate = &outcome.estimate;
    result.is_closed = estimate.verdict == Verdict::Physical;
    result.verdict = case.checked().map_or("refused", Verdict::as_str);
    result.reason = enact::report::reason_text(&outcome.scene, &estimate.reason);
    result.objective = estimate.objective;
    result.iterations = estimate.counters.iterations;

    let posed = Posed::new(case.scene(), &outcome.sketch);
    let true_guess = case.true_guess(&posed, &outcome.sketch);
    let errors = estimate.events.iter().zip(&true_guess.event_times_s);
    let errors = errors.map(|(event, true_s)| 1e3 * (event.time_s - true_s).abs());
    result.event_error_ms = errors.fold(0.0, f64::max);
    let found = lowest(&posed, &starts(&posed, &true_guess, seed));
    result.is_best = result.is_closed
        && found
            .as_ref()
            .is_none_or(|best| is_best(estimate.objective, best.objective));
    result.lowest = found.map(|best| best.objective);
    Some(result)
}
