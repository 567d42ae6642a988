//! Corners that hit in quick succession: how often the motion is found, and whether its deviations
//! hold.

use std::fmt;

use anyhow::Result;
use enact::motion::{FreeParameter, Quantity, TrackIndex, Verdict};
use enact::pipeline::Outcome;
use serde::Serialize;

use crate::options::Options;
use crate::record::Record;
use crate::statistics::{median, rms};
use crate::table::{Table, number, percent};
use enact_tools::case::Case;
use enact_tools::perform::{Acting, Truth, clatter};

/// Performances of a row.
const SEEDS: u64 = 60;
const INTERVALS_S: [f64; 4] = [0.002, 0.004, 0.008, 0.016];
const RATES_HZ: [f64; 2] = [120.0, 60.0];
/// Deviations within which an error is expected in 19 of 20.
const WITHIN: f64 = 2.0;

/// How exactly collisions are marked.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
enum Marks {
    Exact,
    HalfASample,
    Late,
}

impl fmt::Display for Marks {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Marks::Exact => "exact",
            Marks::HalfASample => "½ sample off",
            Marks::Late => "30 ms off, and said to be",
        })
    }
}

/// One way of hitting and of marking.
#[derive(Clone, Copy, Debug, Serialize)]
struct Way {
    corners: usize,
    interval_s: f64,
    rate_hz: f64,
    marks: Marks,
    /// Whether every restitution is free.
    is_free: bool,
    is_timing_known: bool,
}

#[derive(Serialize)]
struct Row {
    way: Way,
    runs: usize,
    physical: usize,
    plausible: usize,
    failed: usize,
    /// Seeds without an estimate, and why.
    refused: Vec<(u64, String)>,
    /// Of the collisions' times and of restitutions, in physical motions: error and reported
    /// deviation \[ms\], \[–\].
    times_ms: Vec<(f64, Option<f64>)>,
    restitutions: Vec<(f64, Option<f64>)>,
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let mut rows = Vec::new();
    for corners in [2, 3] {
        for interval_s in INTERVALS_S {
            for rate_hz in RATES_HZ {
                for marks in [Marks::Exact, Marks::HalfASample, Marks::Late] {
                    rows.push(Way {
                        corners,
                        interval_s,
                        rate_hz,
                        marks,
                        is_free: false,
                        is_timing_known: true,
                    });
                }
            }
            let exact = Way {
                corners,
                interval_s,
                rate_hz: RATES_HZ[0],
                marks: Marks::Exact,
                is_free: true,
                is_timing_known: true,
            };
            let unknown = Way {
                is_free: false,
                is_timing_known: false,
                ..exact
            };
            rows.extend([exact, unknown]);
        }
    }
    let wanted = rows.into_iter().filter(|way| options.wants(&way.name()));
    let rows: Vec<Row> = wanted.map(|way| row(way, options)).collect();
    record.table(table(&rows));
    record.numbers("rows", &rows)
}

impl Way {
    fn name(&self) -> String {
        let interval_ms = 1e3 * self.interval_s;
        format!("{} corners, {interval_ms} ms", self.corners)
    }

    fn acting(&self) -> Acting {
        let acting = if self.is_timing_known {
            Acting::timing_known()
        } else {
            Acting::default()
        };
        Acting {
            distortion: 0.0,
            rate_hz: self.rate_hz,
            mark_error_s: match self.marks {
                Marks::Exact => 0.0,
                Marks::HalfASample => 0.5 / self.rate_hz,
                Marks::Late => 0.03,
            },
            ..acting
        }
    }

    fn truth(&self, seed: u64) -> Result<Truth> {
        let mut truth = clatter(self.corners, self.interval_s, seed)?;
        if self.marks == Marks::Late {
            truth.scene.mark_sd_s = Some(0.03);
        }
        for event in (0..self.corners).filter(|_| self.is_free) {
            let collision = truth.scene.events[event].kind.collision();
            let law = collision.expect("an impact").law;
            truth
                .parameters
                .push(truth.scene.contact_laws[law].restitution);
            truth.scene.parameters.push(FreeParameter {
                name: format!("restitution {event}"),
                quantity: Quantity::Restitution { law },
                initial: 0.5,
                lower: 0.0,
                upper: 1.0,
                prior_sd: None,
            });
        }
        Ok(truth)
    }
}

fn row(way: Way, options: &Options) -> Row {
    let mut row = Row {
        way,
        runs: 0,
        physical: 0,
        plausible: 0,
        failed: 0,
        refused: Vec::new(),
        times_ms: Vec::new(),
        restitutions: Vec::new(),
    };
    for seed in options.seeds(SEEDS) {
        let Ok(truth) = way.truth(seed) else { continue };
        row.runs += 1;
        let case = Case::new(&truth, &way.acting(), seed);
        match case.pipeline().finish(&mut ()) {
            Ok(outcome) => row.add(&case, &outcome),
            Err(reason) => row.refused.push((seed, reason.to_string())),
        }
    }
    row
}

impl Row {
    fn add(&mut self, case: &Case, outcome: &Outcome) {
        let estimate = &outcome.estimate;
        match estimate.verdict {
            Verdict::Physical => self.physical += 1,
            Verdict::Plausible => self.plausible += 1,
            Verdict::Failed => self.failed += 1,
        }
        if estimate.verdict != Verdict::Physical {
            return;
        }
        let truth = &case.performance.truth;
        let first = &estimate.sample_times[0];
        let offset_s = first.time_s - case.hidden_s(TrackIndex(0), first.stamp);
        for event in &estimate.events[..self.way.corners] {
            let error_s = event.time_s - offset_s - truth.event_times_s[event.event];
            self.times_ms
                .push((1e3 * error_s, event.sd_s.map(|sd_s| 1e3 * sd_s)));
        }
        let parameters = estimate.parameters.iter().zip(&truth.parameters);
        let errors = parameters.map(|(found, truth)| (found.value - truth, found.sd));
        self.restitutions.extend(errors);
    }
}

fn table(rows: &[Row]) -> Table {
    let header = [
        "corners",
        "apart ms",
        "Hz",
        "marks",
        "restitution",
        "timing",
        "performances",
        "physical",
        "plausible",
        "failed",
        "refused",
        "times within 2 sd",
        "rms error over sd",
        "rms error ms",
        "median sd ms",
        "restitution within 2 sd",
        "without a sd",
    ];
    let mut table = Table::new("clatter", "", &header);
    for row in rows {
        let way = &row.way;
        let times = with_sd(&row.times_ms);
        let restitutions = with_sd(&row.restitutions);
        let within = |ratios: &[f64]| {
            let held = ratios.iter().filter(|ratio| ratio.abs() <= WITHIN);
            percent(held.count(), ratios.len())
        };
        let both = row.times_ms.iter().chain(&row.restitutions);
        let sds: Vec<f64> = row.times_ms.iter().filter_map(|(_, sd)| *sd).collect();
        let errors: Vec<f64> = row.times_ms.iter().map(|(error, _)| *error).collect();
        table.row([
            way.corners.to_string(),
            number(1e3 * way.interval_s),
            number(way.rate_hz),
            way.marks.to_string(),
            if way.is_free { "free" } else { "given" }.to_owned(),
            if way.is_timing_known {
                "known"
            } else {
                "unknown"
            }
            .to_owned(),
            row.runs.to_string(),
            row.physical.to_string(),
            row.plausible.to_string(),
            row.failed.to_string(),
            row.refused.len().to_string(),
            within(&times),
            number(rms(&times)),
            number(rms(&errors)),
            number(median(&sds)),
            if way.is_free {
                within(&restitutions)
            } else {
                String::new()
            },
            both.filter(|(_, sd)| sd.is_none()).count().to_string(),
        ]);
    }
    table
}

/// Errors over their deviations, where there is one.
fn with_sd(errors: &[(f64, Option<f64>)]) -> Vec<f64> {
    let ratios = errors.iter().filter_map(|(error, sd)| Some(error / (*sd)?));
    ratios.collect()
}
