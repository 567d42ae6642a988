//! Sketches of a few poses: how often exact keyframes give back the motion, and how far off the motion
//! of imprecise ones is.

use std::time::Instant;

use anyhow::Result;
use enact::motion::{Timing, Verdict};
use enact::pipeline::Pipeline;
use enact_tools::perform::{Keyframed, Keyframing, Off, Style};
use serde::Serialize;

use crate::options::Options;
use crate::record::Record;
use crate::statistics::median;
use crate::table::{Table, number, percent};

/// Motions of a row; of rows with one keyframe a flight, which take a search, fewer.
const SEEDS: u64 = 100;
const SEEDS_OF_ONE: u64 = 20;
/// Greatest error of what is given back [m, rad, s].
const EXACT: f64 = 1e-9;

const SUBJECTS: [(&str, Keyframed); 5] = [
    ("pencil, tip", Keyframed::Pencil(Style::Tip)),
    ("pencil, eraser", Keyframed::Pencil(Style::Eraser)),
    ("box, 1 bounce", Keyframed::Box(1)),
    ("box, 4 bounces", Keyframed::Box(4)),
    ("die, 3 bounces", Keyframed::Die(3)),
];
const TIMINGS: [(&str, Timing); 2] = [("physical", Timing::Known), ("edited", Timing::Edited)];
/// Errors of keyframes, per axis: positions \[m\], orientations \[°\].
const ERRORS: [(f64, f64); 2] = [(0.001, 1.0), (0.01, 5.0)];

/// What became of the sketches of a row.
#[derive(Default, Serialize)]
struct Row {
    scene: &'static str,
    stamps: &'static str,
    per_flight: usize,
    position_sd_m: f64,
    orientation_sd_deg: f64,
    sketches: usize,
    given_back: usize,
    /// `physical`, determined, without rivals, and not the motion that was sketched: their seeds.
    wrong: Vec<u64>,
    /// Something open or rivals, and said so.
    said_open: usize,
    plausible: usize,
    failed: usize,
    refused: Vec<(u64, String)>,
    /// Of those with a motion: greatest errors \[m\], \[rad\], \[s\].
    off: Vec<[f64; 3]>,
    milliseconds: Vec<f64>,
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let mut exact = Vec::new();
    let mut imprecise = Vec::new();
    for (scene, subject) in SUBJECTS {
        for timing in TIMINGS {
            if !options.wants(&format!("{scene}, {}", timing.0)) {
                continue;
            }
            for per_flight in [1, 2, 3, 6] {
                let of = Keyframing::exact(per_flight);
                exact.push(row((scene, subject), timing, &of, options));
            }
            for (position_sd_m, sd_deg) in ERRORS {
                for per_flight in [2, 3, 6, 40] {
                    let of = Keyframing {
                        per_flight,
                        position_sd_m,
                        orientation_sd_rad: sd_deg.to_radians(),
                    };
                    imprecise.push(row((scene, subject), timing, &of, options));
                }
            }
        }
    }
    record.table(table_of_exact(&exact));
    record.table(table_of_imprecise(&imprecise));
    record.numbers("exact", &exact)?;
    record.numbers("imprecise", &imprecise)
}

fn row(
    (scene, subject): (&'static str, Keyframed),
    (stamps, timing): (&'static str, Timing),
    keyframing: &Keyframing,
    options: &Options,
) -> Row {
    let mut row = Row {
        scene,
        stamps,
        per_flight: keyframing.per_flight,
        position_sd_m: keyframing.position_sd_m,
        orientation_sd_deg: keyframing.orientation_sd_rad.to_degrees(),
        ..Row::default()
    };
    let is_exact = keyframing.position_sd_m == 0.0;
    let seeds = match keyframing.per_flight {
        1 => SEEDS_OF_ONE,
        _ if is_exact => SEEDS,
        _ => SEEDS / 2,
    };
    for seed in options.seeds(seeds) {
        let Ok(mut truth) = subject.truth(seed) else {
            continue;
        };
        truth.scene.timing = timing;
        let events = keyframing.of(&truth, seed);
        row.sketches += 1;
        let begin = Instant::now();
        let outcome = Pipeline::of(truth.scene.clone(), events.clone()).finish(&mut ());
        row.milliseconds.push(1e3 * begin.elapsed().as_secs_f64());
        let outcome = match outcome {
            Ok(outcome) => outcome,
            Err(reason) => {
                row.refused.push((seed, reason.to_string()));
                continue;
            }
        };
        let estimate = &outcome.estimate;
        let off = Off::of(&truth, &events, estimate);
        let is_given_back = off.greatest() < EXACT;
        row.given_back += usize::from(is_given_back);
        if estimate.verdict == Verdict::Failed {
            row.failed += 1;
            continue;
        }
        row.off
            .push([off.position_m, off.orientation_rad, off.time_s]);
        if is_given_back {
            continue;
        }
        if estimate.rivals > 0 || !estimate.undetermined.is_empty() {
            row.said_open += 1;
        } else if estimate.verdict == Verdict::Plausible {
            row.plausible += 1;
        } else if is_exact {
            row.wrong.push(seed);
        }
    }
    row
}

fn table_of_exact(rows: &[Row]) -> Table {
    let header = [
        "scene",
        "stamps",
        "keyframes per flight",
        "sketches",
        "given back",
        "others: said open",
        "plausible",
        "failed",
        "refused",
        "wrong and not said",
        "median ms",
    ];
    let mut table = Table::new("exact", "Exact keyframes", &header);
    for row in rows {
        table.row([
            row.scene.to_owned(),
            row.stamps.to_owned(),
            row.per_flight.to_string(),
            row.sketches.to_string(),
            percent(row.given_back, row.sketches),
            row.said_open.to_string(),
            row.plausible.to_string(),
            row.failed.to_string(),
            row.refused.len().to_string(),
            row.wrong.len().to_string(),
            number(median(&row.milliseconds)),
        ]);
    }
    table
}

fn table_of_imprecise(rows: &[Row]) -> Table {
    let header = [
        "scene",
        "stamps",
        "error of keyframes",
        "keyframes per flight",
        "sketches",
        "physical and determined",
        "median error mm",
        "median error °",
        "median error of events ms",
    ];
    let mut table = Table::new("imprecise", "Imprecise keyframes", &header);
    for row in rows {
        let of = |part: usize, unit: f64| {
            let values: Vec<f64> = row.off.iter().map(|off| unit * off[part]).collect();
            number(median(&values))
        };
        let others = row.said_open + row.plausible + row.failed + row.refused.len();
        table.row([
            row.scene.to_owned(),
            row.stamps.to_owned(),
            format!(
                "{} mm, {}°",
                number(1e3 * row.position_sd_m),
                number(row.orientation_sd_deg)
            ),
            row.per_flight.to_string(),
            row.sketches.to_string(),
            percent(row.sketches - others.min(row.sketches), row.sketches),
            of(0, 1e3),
            of(1, 1f64.to_degrees()),
            of(2, 1e3),
        ]);
    }
    table
}
