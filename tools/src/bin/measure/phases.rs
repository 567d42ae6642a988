//! Where the time of one estimate goes.

use std::ops::Range;

use anyhow::Result;
use enact::motion::Phase;
use enact::pipeline::Outcome;
use serde::Serialize;

use crate::results::Options;
use crate::scaling::PHASES;
use crate::statistics::median;
use crate::stopwatch::Stopwatch;
use crate::table::{Table, number};
use enact_tools::case::Case;
use enact_tools::perform::{Acting, Style};

/// Runs of each performance, of which the fastest counts: whatever else the machine does makes a
/// run slower, never faster.
const REPEATS: usize = 5;

/// A way of acting: time by phase \[s\], seed by seed.
#[derive(Serialize)]
struct Row {
    style: &'static str,
    timing_known: bool,
    samples: Vec<usize>,
    iterations: Vec<usize>,
    phases_s: Vec<[f64; 7]>,
    total_s: Vec<f64>,
}

/// Runs it.
pub fn run(options: &Options) -> Result<()> {
    let mut rows = Vec::new();
    for acting in [Acting::timing_known(), Acting::default()] {
        for style in Style::ALL {
            rows.push(row(style, &acting, options.range()));
        }
    }
    options.show(table(&rows));
    options.write_json("phases", &rows)
}

fn row(style: Style, acting: &Acting, seeds: Range<u64>) -> Row {
    let mut row = Row {
        style: style.as_str(),
        timing_known: acting.is_timing_known(),
        samples: Vec::new(),
        iterations: Vec::new(),
        phases_s: Vec::new(),
        total_s: Vec::new(),
    };
    for seed in seeds {
        let case = Case::pencil(style, acting, seed);
        let mut fastest: Option<(Stopwatch, Outcome)> = None;
        for _ in 0..REPEATS {
            let mut stopwatch = Stopwatch::default();
            let Ok(outcome) = case.estimated(&mut stopwatch) else {
                break;
            };
            let total_s = stopwatch.total_s();
            if fastest
                .as_ref()
                .is_none_or(|(least, _)| total_s < least.total_s())
            {
                fastest = Some((stopwatch, outcome));
            }
        }
        let Some((stopwatch, outcome)) = fastest else {
            continue;
        };
        row.samples.push(outcome.counts.used);
        row.iterations.push(outcome.estimate.counters.iterations);
        row.phases_s
            .push(PHASES.map(|phase| stopwatch.spent_s(phase)));
        row.total_s.push(stopwatch.total_s());
    }
    row
}

fn table(rows: &[Row]) -> Table {
    let mut header = vec!["style", "timing", "samples", "iterations"];
    header.extend(PHASES.map(Phase::as_str));
    header.push("total");
    let mut table = Table::new("Medians of each phase at 1× [ms], one thread", &header);
    for row in rows {
        let whole = |values: &[usize]| {
            let values: Vec<f64> = values.iter().map(|value| *value as f64).collect();
            format!("{:.0}", median(&values))
        };
        let phase = |index: usize| {
            let of_phase: Vec<f64> = row.phases_s.iter().map(|run| 1e3 * run[index]).collect();
            number(median(&of_phase))
        };
        let total_ms: Vec<f64> = row.total_s.iter().map(|total_s| 1e3 * total_s).collect();
        let timing = if row.timing_known { "known" } else { "unknown" };
        let head = [
            row.style.to_owned(),
            timing.to_owned(),
            whole(&row.samples),
            whole(&row.iterations),
        ];
        let last = [number(median(&total_ms))];
        table.row(
            head.into_iter()
                .chain((0..PHASES.len()).map(phase))
                .chain(last),
        );
    }
    table
}
