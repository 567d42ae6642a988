//! An observer that ends the run: how far the result so far is from the truth, and from a motion that
//! physics allows.

use anyhow::Result;
use enact::motion::Observer;
use serde::Serialize;

use super::scenes::{SCENES, Scene};
use super::{HANDS, REPEATS, mark, timed};
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
/// Questions of the run that the observer answers with no; it is asked after every round of the sweep and of the
/// multipliers, and before every step of the finish. The last is as many as there are.
const QUESTIONS: [usize; 6] = [0, 2, 4, 8, 16, usize::MAX];
/// Gaps below this are rounding \[mm\].
const ROUNDING_MM: f64 = 1e-9;

/// Ends a run after so many questions.
struct Stop {
    left: usize,
}

impl Observer for Stop {
    fn should_stop(&mut self) -> bool {
        let is_over = self.left == 0;
        self.left = self.left.saturating_sub(1);
        is_over
    }
}

/// A scene's performances, ended after so many questions.
#[derive(Serialize)]
struct Row {
    scene: &'static str,
    hand: &'static str,
    /// None is as many as there are.
    questions: Option<usize>,
    performances: usize,
    converged: usize,
    /// Without an estimate.
    refused: usize,
    iterations: Vec<f64>,
    times_ms: Vec<f64>,
    errors_mm: Vec<f64>,
    /// The largest at an event.
    gaps_mm: Vec<f64>,
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let mut rows: Vec<Row> = Vec::new();
    for (distortion, hand, words) in HANDS {
        for scene in SCENES {
            let cases = scene.cases(options, (RATE_HZ, distortion));
            rows.extend(QUESTIONS.map(|questions| row(&scene, hand, questions, &cases)));
        }
        let shown: Shown = |row| &row.errors_mm;
        record.figure(figure(
            hand,
            "How near the truth",
            (hand, words),
            &rows,
            shown,
        ));
    }
    let hand = (HANDS[0].1, HANDS[0].2);
    record.figure(figure("gap", "How near to physics", hand, &rows, |row| {
        &row.gaps_mm
    }));
    record.table(table(&rows));
    record.numbers("stopped", &rows)
}

fn row(scene: &Scene, hand: &'static str, questions: usize, cases: &[Case]) -> Row {
    let mut row = Row {
        scene: scene.name,
        hand,
        questions: (questions < usize::MAX).then_some(questions),
        performances: cases.len(),
        converged: 0,
        refused: 0,
        iterations: Vec::new(),
        times_ms: Vec::new(),
        errors_mm: Vec::new(),
        gaps_mm: Vec::new(),
    };
    for case in cases {
        let (outcome, took_ms) = timed(|| case.estimated(&mut Stop { left: questions }));
        let until_s = case.performance.truth.duration_s;
        let estimated = outcome.ok().and_then(|outcome| {
            let apart = apart(case, &outcome.scene, &outcome.estimate, until_s)?;
            Some((apart, outcome.estimate))
        });
        let Some((apart, estimate)) = estimated else {
            row.refused += 1;
            continue;
        };
        row.converged += usize::from(has_converged(&estimate));
        row.iterations.push(estimate.counters.iterations as f64);
        row.times_ms.push(took_ms);
        row.errors_mm.push(1e3 * apart.position_m);
        let gaps_mm = estimate
            .events
            .iter()
            .map(|event| 1e3 * event.gap.position_m);
        row.gaps_mm.push(gaps_mm.fold(ROUNDING_MM, f64::max));
    }
    row
}

/// What is shown of a row.
type Shown = fn(&Row) -> &[f64];

fn figure(name: &str, what: &str, hand: (&str, &str), rows: &[Row], shown: Shown) -> Figure {
    let (hand, words) = hand;
    let curve = |scene: &Scene| {
        let of_scene = rows
            .iter()
            .filter(|row| row.scene == scene.name && row.hand == hand);
        let points = of_scene.filter(|row| !row.errors_mm.is_empty()).map(|row| {
            let mut point = mark(median(&row.times_ms), shown(row), row.performances);
            point.setting = Some(format!("{:.0}", median(&row.iterations)));
            point
        });
        Curve::new(scene.name, points.collect())
    };
    Figure {
        name: format!("spent_stopped_{name}"),
        title: format!("{what} when stopped early: {words}"),
        note: format!(
            "Recordings at {RATE_HZ} Hz; the caller's observer ends the estimation when it is asked for the 1st, 3rd, 5th, 9th, 17th \
             time, or never; numbers are iterations until then. Segmentation, arc fits and deviations are made all the same. Across: \
             median time until the estimate is there, on one thread, the fastest of {REPEATS} runs each. Up: medians, with bars up to \
             what 95 % are below."
        ),
        x: Axis::logarithmic("time until the estimate is there [ms]"),
        y: Axis::logarithmic(match name {
            "gap" => "largest gap at an event [mm]",
            _ => "distance from the true motion, rms [mm]",
        }),
        curves: SCENES.iter().map(curve).collect(),
    }
}

fn table(rows: &[Row]) -> Table {
    let header = [
        "scene",
        "errors of the performance",
        "ended at question",
        "iterations",
        "no estimate",
        "converged",
        "time ms",
        "rms mm, median",
        "95 %",
        "largest gap mm, median",
        "95 %",
    ];
    let mut table = Table::new("stopped", "", &header);
    for row in rows {
        let question = row.questions.map(|count| (count + 1).to_string());
        table.row([
            row.scene.to_owned(),
            row.hand.to_owned(),
            question.unwrap_or("never".into()),
            format!("{:.0}", median(&row.iterations)),
            format!("{} of {}", row.refused, row.performances),
            percent(row.converged, row.performances),
            number(median(&row.times_ms)),
            number(median(&row.errors_mm)),
            number(quantile(&row.errors_mm, 0.95)),
            number(median(&row.gaps_mm)),
            number(quantile(&row.gaps_mm, 0.95)),
        ]);
    }
    table
}
