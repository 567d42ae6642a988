//! How often the program finds the best known optimum, and what it takes.

mod rows;
mod show;

use std::time::Instant;

use anyhow::Result;
use enact::motion::Verdict;
use enact::report::reason_text;
use serde::Serialize;

use crate::options::Options;
use crate::record::Record;
use crate::table::percent;
use enact_tools::case::{Case, best_verdict};
use enact_tools::errors::{goal_gap, has_converged, sample_time_errors_s, simulated_goal_gap};
use enact_tools::starts::{is_best, lowest, starts};
use rows::Row;
use show::{failures, found, sample_times};

/// Performances of a row.
const SEEDS: u64 = 50;
/// One of so many rows is in a quick run.
const QUICK: usize = 5;

/// One performance. Numbers of what was refused are none.
#[derive(Serialize)]
struct Judged {
    seed: u64,
    /// By the gaps that the solver left.
    verdict: &'static str,
    /// With all checks.
    checked: &'static str,
    reason: String,
    has_converged: bool,
    /// Whether it has the verdict that its scene allows and the lowest objective known.
    is_best: bool,
    objective: f64,
    /// Lowest objective of any start that converged, and which start it was.
    lowest: Option<(f64, String)>,
    starts_tried: usize,
    iterations: usize,
    time_ms: f64,
    /// How far the goals are missed \[m, rad\]: by the estimate's arcs, and simulated.
    goal_gap: (f64, f64),
    simulated_gap: (f64, f64),
    /// Largest distance of an event from the true one \[ms\].
    event_error_ms: f64,
    /// Rms error of the sample times: as it is, and with the best constant taken off \[ms\].
    sample_times_ms: (f64, f64),
}

/// A row and what became of it.
#[derive(Serialize)]
struct Block {
    table: &'static str,
    name: String,
    timing_known: bool,
    seeds: Vec<Judged>,
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let mut blocks = Vec::new();
    // A quick run makes some rows of each table.
    for row in rows::all().into_iter().step_by(options.either(QUICK, 1)) {
        if !options.wants(&row.name) {
            continue;
        }
        let (seeds, most) = (options.seeds(SEEDS), options.either(3, usize::MAX));
        let seeds: Vec<Judged> = seeds.filter_map(|seed| judged(&row, seed, most)).collect();
        let good = seeds.iter().filter(|seed| seed.is_best).count();
        eprintln!("  {}: {good} of {}", row.name, seeds.len());
        blocks.push(Block {
            table: row.table,
            name: row.name,
            timing_known: row.acting.is_timing_known(),
            seeds,
        });
    }
    for (name, title) in [
        ("pencils", "A pencil that bounces into a mug"),
        ("scenes", "Several bodies and many bounces"),
        (
            "scales",
            "Cubes of any size and speed, and how marks are made",
        ),
    ] {
        let own: Vec<&Block> = blocks.iter().filter(|block| block.table == name).collect();
        record.table(found(name, title, &own));
        let count = |is: fn(&Judged) -> bool| {
            own.iter()
                .flat_map(|block| &block.seeds)
                .filter(|seed| is(seed))
                .count()
        };
        record.say(format!(
            "{title}: {} of {} performances end at the best optimum known.",
            percent(count(|seed| seed.is_best), count(|_| true)),
            count(|_| true),
        ));
    }
    record.table(sample_times(&blocks));
    record.table(failures(&blocks));
    record.numbers("rows", &blocks)
}

/// What became of a performance beside so many starts; `None` where no motion is found.
fn judged(row: &Row, seed: u64, starts_max: usize) -> Option<Judged> {
    let case = row.case(seed)?;
    let pipeline = case.pipeline();
    let began = Instant::now();
    let outcome = pipeline.estimate(&mut ());
    let time_ms = 1e3 * began.elapsed().as_secs_f64();
    let none = (f64::NAN, f64::NAN);
    let refused = |reason: String| Judged {
        seed,
        verdict: "refused",
        checked: "refused",
        reason,
        has_converged: false,
        is_best: false,
        objective: f64::NAN,
        lowest: None,
        starts_tried: 0,
        iterations: 0,
        time_ms,
        goal_gap: none,
        simulated_gap: none,
        event_error_ms: f64::NAN,
        sample_times_ms: none,
    };
    let outcome = match outcome {
        Ok(outcome) => outcome,
        Err(error) => return Some(refused(error.to_string())),
    };
    let estimate = &outcome.estimate;
    let (posed, truth) = case.posed(&outcome);
    let mut from = starts(&posed, &truth, seed);
    from.truncate(starts_max);
    let known = lowest(&posed, &from);
    let is_right = estimate.verdict == best_verdict(case.scene());
    let is_lowest = |lowest: f64| is_best(estimate.objective, lowest);
    let errors = estimate.events.iter().zip(&truth.event_times_s);
    let errors = errors.map(|(event, true_s)| 1e3 * (event.time_s - true_s).abs());
    // Of the others no table tells; what an editing interface leaves has no hidden times.
    let sample_times_s = match row.table {
        "pencils" => sample_time_errors_s(&case, &outcome),
        _ => none,
    };
    Some(Judged {
        verdict: estimate.verdict.as_str(),
        checked: case.checked().map_or("refused", Verdict::as_str),
        has_converged: has_converged(estimate),
        is_best: is_right
            && known
                .as_ref()
                .is_none_or(|known| is_lowest(known.objective)),
        objective: estimate.objective,
        lowest: known.map(|known| (known.objective, known.start)),
        starts_tried: estimate.counters.starts,
        iterations: estimate.counters.iterations,
        goal_gap: goal_gap(&case, estimate),
        simulated_gap: simulated(&case, estimate),
        event_error_ms: errors.fold(0.0, f64::max),
        sample_times_ms: (1e3 * sample_times_s.0, 1e3 * sample_times_s.1),
        ..refused(reason_text(case.scene(), &estimate.reason))
    })
}

/// Only of what has goals and flies without jumps.
fn simulated(case: &Case, estimate: &enact::motion::Estimate) -> (f64, f64) {
    if case.scene().goals.is_empty() || estimate.verdict != Verdict::Physical {
        return (f64::NAN, f64::NAN);
    }
    simulated_goal_gap(case, estimate)
}
