//! How exactly exact performances are recovered.
//!
//! With timing known the truth is the optimum, and what is left is rounding: of the arithmetic,
//! and of stamps to a nanosecond where the sampling interval is no whole number of them (120 Hz).
//! With timing unknown the truth is the optimum where the tempo is constant; a tempo that
//! varies costs something under its prior, and the optimum gives a little of the fit for it.

use anyhow::Result;
use enact::motion::Verdict;
use serde::Serialize;

use crate::results::Options;
use crate::statistics::{largest, median};
use crate::table::{Table, number, percent};
use enact_tools::case::Case;
use enact_tools::errors::{Errors, has_converged};
use enact_tools::perform::{Acting, Style, Truth, bounces};

/// Its interval is 8 ms, a whole number of nanoseconds.
const WHOLE_RATE_HZ: f64 = 125.0;
/// Motions with three bounces.
const BOUNCING: u64 = 20;

/// One way of acting one kind of motion.
#[derive(Serialize)]
struct Row {
    motion: String,
    acting: &'static str,
    target: Option<f64>,
    runs: usize,
    physical: usize,
    /// Of the physical ones.
    errors: Vec<Errors>,
    failed_seeds: Vec<u64>,
    /// Physical, but the solver got no further before it had converged: seed and its reason.
    stalled: Vec<(u64, String)>,
}

/// Runs it.
pub fn run(options: &Options) -> Result<()> {
    let exact = Acting {
        rate_hz: WHOLE_RATE_HZ,
        ..Acting::exact()
    };
    let unknown = Acting {
        slowdown: Acting::default().slowdown,
        ..exact
    };
    let varying = Acting {
        tempo_variation: Acting::default().tempo_variation,
        ..unknown
    };
    let rounded = Acting::exact();
    let ways = [
        ("timing known", exact, Some(1e-9)),
        (
            "timing known, 120 Hz: stamps rounded to 1 ns",
            rounded,
            None,
        ),
        ("timing unknown, constant tempo", unknown, Some(1e-6)),
        ("timing unknown, varying tempo", varying, None),
    ];
    let mut rows = Vec::new();
    for (name, acting, target) in ways {
        for style in Style::ALL {
            // Without noise a seed is in the tempo only.
            let seeds = if acting.tempo_variation > 0.0 {
                options.range()
            } else {
                0..1
            };
            let truth = style.truth();
            let runs = seeds.map(|seed| (seed, truth.clone()));
            rows.push(row(style.as_str().into(), (name, acting, target), runs));
        }
        let runs = (0..BOUNCING).filter_map(|seed| Some((seed, bounces(3, seed).ok()?)));
        rows.push(row("cube, 3 bounces".into(), (name, acting, target), runs));
    }
    options.show(table(&rows));
    options.write_json("accuracy", &rows)
}

fn row(
    motion: String,
    (name, acting, target): (&'static str, Acting, Option<f64>),
    runs: impl Iterator<Item = (u64, Truth)>,
) -> Row {
    let mut row = Row {
        motion,
        acting: name,
        target,
        runs: 0,
        physical: 0,
        errors: Vec::new(),
        failed_seeds: Vec::new(),
        stalled: Vec::new(),
    };
    for (seed, truth) in runs {
        row.runs += 1;
        let case = Case::new(&truth, &acting, seed);
        match case.estimated(&mut ()) {
            Ok(outcome) if outcome.estimate.verdict == Verdict::Physical => {
                row.physical += 1;
                row.errors.push(Errors::of(&case, &outcome));
                if !has_converged(&outcome.estimate) {
                    let (scene, reason) = (&outcome.scene, &outcome.estimate.reason);
                    row.stalled
                        .push((seed, enact::report::reason_text(scene, reason)));
                }
            }
            _ => row.failed_seeds.push(seed),
        }
    }
    row
}

fn table(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "Exact performances: largest relative error, median (worst) over the runs",
        &[
            "acted",
            "motion",
            "runs",
            "physical",
            "converged",
            "position",
            "orientation rad",
            "velocity",
            "angular velocity",
            "event times",
            "sample times",
            "target",
            "met",
        ],
    );
    for row in rows {
        let errors = (0..6).map(|kind| {
            let of_kind: Vec<f64> = row.errors.iter().map(|errors| errors.all()[kind]).collect();
            format!(
                "{} ({})",
                number(median(&of_kind)),
                number(largest(&of_kind))
            )
        });
        let met = row.target.map_or("–".to_owned(), |target| {
            let met = row.errors.iter().filter(|errors| errors.worst() <= target);
            percent(met.count(), row.runs)
        });
        let cells = [
            row.acting.to_owned(),
            row.motion.clone(),
            row.runs.to_string(),
            percent(row.physical, row.runs),
            percent(row.physical - row.stalled.len(), row.runs),
        ];
        let target = row.target.map_or("–".to_owned(), number);
        table.row(cells.into_iter().chain(errors).chain([target, met]));
    }
    table
}
