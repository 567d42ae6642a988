//! How often the program finds the best known optimum, and what it takes.

use std::ops::Range;
use std::time::Instant;

use anyhow::Result;
use enact::motion::Verdict;
use serde::{Serialize, Serializer};

use crate::results::Options;
use crate::statistics::{largest, median, rms};
use crate::table::{Table, number, percent};
use enact_tools::case::{Case, Posed};
use enact_tools::errors::{goal_gap, has_converged, sample_time_errors_s, simulated_goal_gap};
use enact_tools::perform::{Acting, Style};
use enact_tools::starts::{is_best, lowest, starts};

/// How long the hand rests after the landing in the recordings of this repository \[s\].
const REST_S: f64 = 0.3;

/// A style, acted in one way, at all seeds.
#[derive(Serialize)]
struct Row {
    style: &'static str,
    timing_known: bool,
    distortion: f64,
    rest_s: f64,
    #[serde(rename = "not_physical_or_not_best", serialize_with = "failing")]
    seeds: Vec<Seed>,
}

/// One performance.
#[derive(Serialize)]
struct Seed {
    seed: u64,
    verdict: &'static str,
    reason: String,
    objective: f64,
    /// Lowest objective of any start that converged, and which start it was.
    lowest: Option<f64>,
    lowest_start: Option<String>,
    is_best: bool,
    has_converged: bool,
    starts_tried: usize,
    iterations: usize,
    time_s: f64,
    goal_gap_m: f64,
    goal_gap_rad: f64,
    simulated_gap_m: f64,
    simulated_gap_rad: f64,
    sample_time_rms_s: f64,
    sample_time_rms_without_offset_s: f64,
}

/// Runs it.
pub fn run(options: &Options) -> Result<()> {
    let mut rows = Vec::new();
    for style in Style::ALL {
        for distortion in [1.0, 2.0, 4.0, 8.0] {
            rows.push(row(
                style,
                Acting::timing_known(),
                distortion,
                options.range(),
            ));
        }
    }
    // A recorder that stops with the motion, and one that runs on while the hand rests.
    for hold_after_s in [0.0, REST_S] {
        for style in Style::ALL {
            for distortion in [1.0, 2.0, 4.0] {
                let acting = Acting {
                    hold_after_s,
                    ..Acting::default()
                };
                rows.push(row(style, acting, distortion, options.range()));
            }
        }
    }
    options.show(found(&rows));
    options.show(timing(&rows));
    options.show(failures(&rows));
    options.write_json("answer", &rows)?;
    let header = "style,timing_known,rest_s,distortion,seed,verdict,converged,best,objective,lowest,\
                  starts,iterations,time_ms,sample_time_rms_ms,without_offset_ms";
    options.write_csv("answer", header, &lines(&rows))
}

/// The full account of these only; all seeds are in the CSV.
fn failing<S: Serializer>(seeds: &[Seed], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(seeds.iter().filter(|seed| !seed.is_best))
}

fn lines(rows: &[Row]) -> Vec<String> {
    let mut lines = Vec::new();
    for row in rows {
        let Row {
            style,
            timing_known,
            rest_s,
            distortion,
            ..
        } = row;
        for seed in &row.seeds {
            lines.push(format!(
                "{style},{timing_known},{rest_s},{distortion},{},{},{},{},{:.6e},{:.6e},{},{},{:.3},{:.3},{:.3}",
                seed.seed,
                seed.verdict,
                seed.has_converged,
                seed.is_best,
                seed.objective,
                seed.lowest.unwrap_or(f64::NAN),
                seed.starts_tried,
                seed.iterations,
                1e3 * seed.time_s,
                1e3 * seed.sample_time_rms_s,
                1e3 * seed.sample_time_rms_without_offset_s,
            ));
        }
    }
    lines
}

fn row(style: Style, acting: Acting, distortion: f64, seeds: Range<u64>) -> Row {
    let acting = Acting {
        distortion,
        ..acting
    };
    Row {
        style: style.as_str(),
        timing_known: acting.is_timing_known(),
        distortion,
        rest_s: acting.hold_after_s,
        seeds: seeds.map(|seed| one(style, &acting, seed)).collect(),
    }
}

fn one(style: Style, acting: &Acting, seed: u64) -> Seed {
    let case = Case::pencil(style, acting, seed);
    let begin = Instant::now();
    let outcome = case.estimated(&mut ());
    let time_s = begin.elapsed().as_secs_f64();
    let mut result = Seed {
        seed,
        verdict: "refused",
        reason: String::new(),
        objective: f64::NAN,
        lowest: None,
        lowest_start: None,
        is_best: false,
        has_converged: false,
        starts_tried: 0,
        iterations: 0,
        time_s,
        goal_gap_m: f64::NAN,
        goal_gap_rad: f64::NAN,
        simulated_gap_m: f64::NAN,
        simulated_gap_rad: f64::NAN,
        sample_time_rms_s: f64::NAN,
        sample_time_rms_without_offset_s: f64::NAN,
    };
    let outcome = match outcome {
        Ok(outcome) => outcome,
        Err(error) => {
            result.reason = error.to_string();
            return result;
        }
    };
    let estimate = &outcome.estimate;
    result.verdict = estimate.verdict.as_str();
    result.reason = enact::report::reason_text(&outcome.scene, &estimate.reason);
    result.has_converged = has_converged(estimate);
    result.objective = estimate.objective;
    result.starts_tried = estimate.counters.starts;
    result.iterations = estimate.counters.iterations;
    (result.goal_gap_m, result.goal_gap_rad) = goal_gap(&case, estimate);
    (result.simulated_gap_m, result.simulated_gap_rad) = simulated_goal_gap(&case, estimate);
    (
        result.sample_time_rms_s,
        result.sample_time_rms_without_offset_s,
    ) = sample_time_errors_s(&case, &outcome);
    let posed = Posed::new(case.scene(), &outcome.sketch);
    let true_guess = case.true_guess(&posed, &outcome.sketch);
    let is_physical = estimate.verdict == Verdict::Physical;
    match lowest(&posed, &starts(&posed, &true_guess, seed)) {
        Some(optimum) => {
            result.is_best = is_physical && is_best(estimate.objective, optimum.objective);
            result.lowest = Some(optimum.objective);
            result.lowest_start = Some(optimum.start);
        }
        None => result.is_best = is_physical,
    }
    result
}

impl Row {
    fn of(&self, value: impl Fn(&Seed) -> f64) -> Vec<f64> {
        let estimated = self.seeds.iter().filter(|seed| seed.verdict != "refused");
        estimated.map(value).collect()
    }

    fn count(&self, holds: impl Fn(&Seed) -> bool) -> usize {
        self.seeds.iter().filter(|seed| holds(seed)).count()
    }

    /// Largest of the physical ones.
    fn largest(&self, value: impl Fn(&Seed) -> f64) -> String {
        let physical = self.seeds.iter().filter(|seed| seed.verdict == "physical");
        number(largest(&physical.map(value).collect::<Vec<f64>>()))
    }

    fn head(&self) -> [String; 3] {
        let timing = match (self.timing_known, self.rest_s > 0.0) {
            (true, _) => "known",
            (false, false) => "unknown",
            (false, true) => "unknown, rest",
        };
        [
            self.style.to_owned(),
            timing.to_owned(),
            format!("{}×", self.distortion),
        ]
    }
}

fn found(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "The right answer",
        &[
            "style",
            "timing",
            "distortion",
            "n",
            "physical",
            "converged",
            "best known optimum",
            "largest goal gap m, rad",
            "the same simulated",
            "iterations median (max)",
            "time ms median (max)",
        ],
    );
    for row in rows {
        let iterations = row.of(|seed| seed.iterations as f64);
        let time_ms = row.of(|seed| 1e3 * seed.time_s);
        let both = |m: String, rad: String| format!("{m}, {rad}");
        table.row(row.head().into_iter().chain([
            row.seeds.len().to_string(),
            percent(
                row.count(|seed| seed.verdict == "physical"),
                row.seeds.len(),
            ),
            percent(row.count(|seed| seed.has_converged), row.seeds.len()),
            percent(row.count(|seed| seed.is_best), row.seeds.len()),
            both(
                row.largest(|s| s.goal_gap_m),
                row.largest(|s| s.goal_gap_rad),
            ),
            both(
                row.largest(|s| s.simulated_gap_m),
                row.largest(|s| s.simulated_gap_rad),
            ),
            format!("{:.0} ({:.0})", median(&iterations), largest(&iterations)),
            format!("{:.2} ({:.1})", median(&time_ms), largest(&time_ms)),
        ]));
    }
    table
}

fn timing(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "Recovered sample times, error against the hidden ones",
        &[
            "style",
            "timing",
            "distortion",
            "rms ms",
            "rms ms, best offset taken off",
            "worst seed ms, offset taken off",
        ],
    );
    for row in rows.iter().filter(|row| !row.timing_known) {
        let raw = row.of(|seed| 1e3 * seed.sample_time_rms_s);
        let centred = row.of(|seed| 1e3 * seed.sample_time_rms_without_offset_s);
        table.row(row.head().into_iter().chain([
            number(rms(&raw)),
            number(rms(&centred)),
            number(largest(&centred)),
        ]));
    }
    table
}

fn failures(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "Seeds that are not physical or not at the best known optimum (the first 12 of a row)",
        &[
            "style",
            "timing",
            "distortion",
            "not physical",
            "physical, but above the best (objective over lowest)",
        ],
    );
    for row in rows {
        let list = |texts: Vec<String>| {
            let more = texts.len().saturating_sub(12);
            let shown = texts[..texts.len() - more].join(", ");
            if more > 0 {
                format!("{shown}, {more} more")
            } else {
                shown
            }
        };
        let unphysical = row.seeds.iter().filter(|seed| seed.verdict != "physical");
        let unphysical: Vec<String> = unphysical.map(|seed| seed.seed.to_string()).collect();
        let above = row
            .seeds
            .iter()
            .filter(|seed| seed.verdict == "physical" && !seed.is_best);
        let above: Vec<String> = above
            .map(|seed| format!("{} ({})", seed.seed, ratio(seed)))
            .collect();
        if !unphysical.is_empty() || !above.is_empty() {
            table.row(
                row.head()
                    .into_iter()
                    .chain([list(unphysical), list(above)]),
            );
        }
    }
    table
}

fn ratio(seed: &Seed) -> String {
    seed.lowest.map_or("–".into(), |lowest| {
        format!("{:.4}", seed.objective / lowest)
    })
}
