//! Deadlines: an observer that ends the run, and how far the result so far is from the truth.

use std::time::{Duration, Instant};

use anyhow::Result;
use enact::motion::Observer;
use serde::Serialize;

use super::scenes::{SCENES, Scene};
use super::{SEEDS, mark};
use crate::figure::{Axis, Curve, Figure};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{median, quantile};
use crate::table::{Table, number, percent};
use enact_tools::apart::apart;
use enact_tools::case::Case;
use enact_tools::errors::has_converged;

/// Of the tracker.
const RATE_HZ: f64 = 120.0;
/// The last one is none \[s\].
const DEADLINES_S: [f64; 9] = [
    0.0,
    0.5e-3,
    1e-3,
    2e-3,
    4e-3,
    8e-3,
    16e-3,
    32e-3,
    f64::INFINITY,
];

/// Stops a run when its time is over.
struct Deadline {
    begun: Instant,
    after: Duration,
}

impl Observer for Deadline {
    fn should_stop(&mut self) -> bool {
        self.begun.elapsed() >= self.after
    }
}

/// One deadline for a scene's performances.
#[derive(Serialize)]
struct Row {
    scene: &'static str,
    /// None is none \[ms\].
    deadline_ms: Option<f64>,
    performances: usize,
    converged: usize,
    /// Without an estimate.
    refused: usize,
    times_ms: Vec<f64>,
    errors_mm: Vec<f64>,
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let mut rows = Vec::new();
    for scene in SCENES {
        let cases = options
            .seeds(SEEDS)
            .filter_map(|seed| scene.case(RATE_HZ, 1.0, seed));
        let cases: Vec<Case> = cases.collect();
        rows.extend(DEADLINES_S.map(|deadline_s| row(&scene, deadline_s, &cases)));
    }
    record.figure(figure(&rows));
    record.table(table(&rows));
    record.numbers("deadlines", &rows)
}

fn row(scene: &Scene, deadline_s: f64, cases: &[Case]) -> Row {
    let mut row = Row {
        scene: scene.name,
        deadline_ms: deadline_s.is_finite().then_some(1e3 * deadline_s),
        performances: cases.len(),
        converged: 0,
        refused: 0,
        times_ms: Vec::new(),
        errors_mm: Vec::new(),
    };
    for case in cases {
        let mut deadline = Deadline {
            begun: Instant::now(),
            after: Duration::try_from_secs_f64(deadline_s).unwrap_or(Duration::MAX),
        };
        let outcome = case.estimated(&mut deadline);
        let took_s = deadline.begun.elapsed().as_secs_f64();
        let until_s = case.performance.truth.duration_s;
        let error = outcome.ok().and_then(|outcome| {
            row.converged += usize::from(has_converged(&outcome.estimate));
            apart(case, &outcome.scene, &outcome.estimate, until_s)
        });
        match error {
            Some(error) => {
                row.times_ms.push(1e3 * took_s);
                row.errors_mm.push(1e3 * error.position_m);
            }
            None => row.refused += 1,
        }
    }
    row
}

fn figure(rows: &[Row]) -> Figure {
    let curve = |scene: &Scene| {
        let of_scene = rows.iter().filter(|row| row.scene == scene.name);
        let points = of_scene.filter(|row| !row.errors_mm.is_empty()).map(|row| {
            let mut point = mark(median(&row.times_ms), &row.errors_mm, row.performances);
            let deadline = row.deadline_ms.map(|ms| format!("{ms} ms"));
            point.setting = Some(deadline.unwrap_or("none".into()));
            point
        });
        Curve::new(scene.name, points.collect())
    };
    Figure {
        name: "spent_deadline".into(),
        title: "How near the truth when stopped by a deadline".into(),
        note: format!(
            "Recordings at {RATE_HZ} Hz, a hand's wander and a tracker's noise. The caller's observer stops the estimation when a \
             deadline is over; iterations are not interrupted, and segmentation, arc fits and deviations are made all the same. Across: median \
             time until the estimate is there. Up: distance of centres of mass from the true motion, rms over time and bodies; \
             medians, with bars up to what 95 % are below."
        ),
        x: Axis::logarithmic("time until the estimate is there [ms]"),
        y: Axis::logarithmic("distance from the true motion, rms [mm]"),
        curves: SCENES.iter().map(curve).collect(),
    }
}

fn table(rows: &[Row]) -> Table {
    let header = [
        "scene",
        "deadline ms",
        "there after ms, median",
        "95 %",
        "no estimate",
        "converged",
        "rms mm, median",
        "95 %",
    ];
    let mut table = Table::new("deadlines", "", &header);
    for row in rows {
        table.row([
            row.scene.to_owned(),
            row.deadline_ms.map_or("none".to_owned(), number),
            number(median(&row.times_ms)),
            number(quantile(&row.times_ms, 0.95)),
            format!("{} of {}", row.refused, row.performances),
            percent(row.converged, row.performances),
            number(median(&row.errors_mm)),
            number(quantile(&row.errors_mm, 0.95)),
        ]);
    }
    table
}
