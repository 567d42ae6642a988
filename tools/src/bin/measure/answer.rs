//! How often the program finds the best known optimum, and what it takes.

mod rows;

use std::time::Instant;

use anyhow::Result;
use enact::motion::Verdict;
use serde::Serialize;

use crate::options::Options;
use crate::record::Record;
use crate::statistics::{largest, median, rms};
use crate::table::{Table, number, percent, share};
use enact_tools::case::{Case, best_verdict};
use enact_tools::errors::{goal_gap, has_converged, sample_time_errors_s, simulated_goal_gap};
use enact_tools::starts::{is_best, lowest, starts};
use rows::Row;

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
        ..refused(estimate.reason.clone())
    })
}

/// Only of what has goals and flies without jumps.
fn simulated(case: &Case, estimate: &enact::motion::Estimate) -> (f64, f64) {
    if case.scene().goals.is_empty() || estimate.verdict != Verdict::Physical {
        return (f64::NAN, f64::NAN);
    }
    simulated_goal_gap(case, estimate)
}

impl Block {
    /// Of those that have an estimate.
    fn of(&self, value: impl Fn(&Judged) -> f64) -> Vec<f64> {
        let estimated = self.seeds.iter().filter(|seed| seed.verdict != "refused");
        estimated.map(value).collect()
    }

    /// Largest of the physical ones, of both parts of a gap.
    fn gap(&self, value: impl Fn(&Judged) -> (f64, f64)) -> String {
        let physical = self.seeds.iter().filter(|seed| seed.verdict == "physical");
        let (m, rad): (Vec<f64>, Vec<f64>) = physical.map(value).unzip();
        format!("{}, {}", number(largest(&m)), number(largest(&rad)))
    }

    fn share(&self, is: impl Fn(&Judged) -> bool) -> String {
        share(&self.seeds, is)
    }
}

fn found(name: &str, title: &str, blocks: &[&Block]) -> Table {
    let header = [
        "performed",
        "n",
        "gaps closed",
        "physical",
        "plausible",
        "converged",
        "best known optimum",
        "largest goal gap m, rad",
        "the same simulated",
        "event error ms median (max)",
        "iterations median (max)",
        "time ms median (max)",
    ];
    let mut table = Table::new(name, title, &header);
    for block in blocks {
        let both = |value: fn(&Judged) -> f64| {
            let values = block.of(value);
            format!("{} ({})", number(median(&values)), number(largest(&values)))
        };
        table.row([
            block.name.clone(),
            block.seeds.len().to_string(),
            block.share(|seed| seed.verdict == "physical"),
            block.share(|seed| seed.checked == "physical"),
            block.share(|seed| seed.checked == "plausible"),
            block.share(|seed| seed.has_converged),
            block.share(|seed| seed.is_best),
            block.gap(|seed| seed.goal_gap),
            block.gap(|seed| seed.simulated_gap),
            both(|seed| seed.event_error_ms),
            both(|seed| seed.iterations as f64),
            both(|seed| seed.time_ms),
        ]);
    }
    table
}

fn sample_times(blocks: &[Block]) -> Table {
    let header = [
        "performed",
        "rms ms",
        "rms ms, best offset taken off",
        "worst seed ms, offset taken off",
    ];
    let title = "Recovered sample times of pencils, error against the hidden ones";
    let mut table = Table::new("sample_times", title, &header);
    let is_told = |block: &&Block| block.table == "pencils" && !block.timing_known;
    for block in blocks.iter().filter(is_told) {
        let centred = block.of(|seed| seed.sample_times_ms.1);
        table.row([
            block.name.clone(),
            number(rms(&block.of(|seed| seed.sample_times_ms.0))),
            number(rms(&centred)),
            number(largest(&centred)),
        ]);
    }
    table
}

/// Seeds that are not at the best known optimum.
fn failures(blocks: &[Block]) -> Table {
    let header = [
        "performed",
        "without its verdict",
        "above the best (objective over lowest)",
    ];
    let title = "Seeds that do not end at the best known optimum";
    let mut table = Table::new("failures", title, &header);
    let list = |texts: Vec<String>| match texts.len().saturating_sub(12) {
        0 => texts.join(", "),
        more => format!("{}, {more} more", texts[..12].join(", ")),
    };
    for block in blocks {
        let (mut without, mut above) = (Vec::new(), Vec::new());
        for seed in block.seeds.iter().filter(|seed| !seed.is_best) {
            match &seed.lowest {
                Some((lowest, _)) if !is_best(seed.objective, *lowest) => {
                    above.push(format!("{} ({:.4})", seed.seed, seed.objective / lowest));
                }
                _ => without.push(seed.seed.to_string()),
            }
        }
        if !(without.is_empty() && above.is_empty()) {
            table.row([block.name.clone(), list(without), list(above)]);
        }
    }
    table
}
