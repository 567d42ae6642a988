//! Fewer samples: the same recordings thinned.

use anyhow::Result;
use enact::motion::TakeEvent;
use serde::Serialize;

use super::scenes::{SCENES, Scene};
use super::{HANDS, REPEATS, mark, timed};
use crate::figure::{Axis, Curve, Figure};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{median, quantile};
use crate::table::{Table, number};
use enact_tools::apart::{Apart, apart};
use enact_tools::case::{Case, estimated};

/// Of the recordings as they are.
const RATE_HZ: f64 = 960.0;
/// Every so manyth sample is used.
const STRIDES: [usize; 6] = [1, 2, 4, 8, 16, 32];
/// One thinning of a scene's performances.
#[derive(Serialize)]
struct Row {
    scene: &'static str,
    hand: &'static str,
    stride: usize,
    performances: usize,
    /// Without an estimate.
    refused: usize,
    samples: f64,
    times_ms: Vec<f64>,
    errors: Vec<Apart>,
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let mut rows: Vec<Row> = Vec::new();
    for (distortion, hand, words) in HANDS {
        for scene in SCENES {
            let cases = scene.cases(options, (RATE_HZ, distortion));
            rows.extend(STRIDES.map(|stride| row(&scene, hand, stride, &cases)));
        }
        record.figure(figure(hand, words, &rows));
    }
    record.table(table(&rows));
    let [hand, noise] = HANDS.map(|(_, hand, _)| gains(hand, &rows));
    record.say(format!(
        "32 times the samples bring an estimate {noise} times nearer to the truth with a tracker's noise alone, and {hand} times \
         with a hand that wanders by centimetres."
    ));
    record.numbers("samples", &rows)
}

/// By what factor the most samples are nearer to the truth than the fewest: least and greatest of the scenes.
fn gains(hand: &str, rows: &[Row]) -> String {
    let [most, fewest] = [STRIDES[0], STRIDES[STRIDES.len() - 1]];
    let of = |scene: &Scene, stride: usize| {
        let row = rows
            .iter()
            .find(|row| row.scene == scene.name && row.hand == hand && row.stride == stride);
        row.map_or(f64::NAN, |row| median(&row.positions_mm()))
    };
    let gains = SCENES.map(|scene| of(&scene, fewest) / of(&scene, most));
    format!(
        "{:.1} to {:.1}",
        quantile(&gains, 0.0),
        quantile(&gains, 1.0)
    )
}

fn row(scene: &Scene, hand: &'static str, stride: usize, cases: &[Case]) -> Row {
    let mut row = Row {
        scene: scene.name,
        hand,
        stride,
        performances: cases.len(),
        refused: 0,
        samples: 0.0,
        times_ms: Vec::new(),
        errors: Vec::new(),
    };
    let mut samples = Vec::new();
    for case in cases {
        let events = thinned(case, stride);
        let (outcome, took_ms) = timed(|| estimated(case.scene(), &events, &mut ()));
        let until_s = case.performance.truth.duration_s;
        let error = outcome.ok().and_then(|outcome| {
            samples.push(outcome.counts.used as f64);
            apart(case, &outcome.scene, &outcome.estimate, until_s)
        });
        match error {
            Some(error) => {
                row.times_ms.push(took_ms);
                row.errors.push(error);
            }
            None => row.refused += 1,
        }
    }
    row.samples = median(&samples);
    row
}

/// Every so manyth sample of each track from its first on, and all marks.
fn thinned(case: &Case, stride: usize) -> Vec<TakeEvent> {
    let mut seen = vec![0_usize; case.scene().tracks.len()];
    let mut is_kept = |event: &&TakeEvent| match event {
        TakeEvent::Mark(_) => true,
        TakeEvent::Pose { track, .. } => {
            let count = &mut seen[usize::from(*track)];
            *count += 1;
            (*count - 1).is_multiple_of(stride)
        }
    };
    let events = case.performance.events.iter();
    events.filter(|event| is_kept(event)).cloned().collect()
}

impl Row {
    fn positions_mm(&self) -> Vec<f64> {
        self.errors
            .iter()
            .map(|error| 1e3 * error.position_m)
            .collect()
    }
}

fn figure(hand: &str, words: &str, rows: &[Row]) -> Figure {
    let curve = |scene: &Scene| {
        let of_scene = rows
            .iter()
            .filter(|row| row.scene == scene.name && row.hand == hand);
        let points = of_scene.filter(|row| !row.errors.is_empty()).map(|row| {
            let mut point = mark(median(&row.times_ms), &row.positions_mm(), row.performances);
            point.setting = Some(format!("1/{}", row.stride));
            point
        });
        Curve::new(scene.name, points.collect())
    };
    Figure {
        name: format!("spent_samples_{hand}"),
        title: format!("How near the truth in what time with fewer samples: {words}"),
        note: format!(
            "Recordings at {RATE_HZ} Hz of which every 1st, 2nd, … 32nd sample is used (right to left). Across: median \
             time of an estimate on one thread, the fastest of {REPEATS} runs each. Up: distance of centres of mass from the true motion, rms over time and bodies; medians, \
             with bars up to what 95 % are below. Crosses: no estimate of half of the performances."
        ),
        x: Axis::logarithmic("time of an estimate [ms]"),
        y: Axis::logarithmic("distance from the true motion, rms [mm]"),
        curves: SCENES.iter().map(curve).collect(),
    }
}

fn table(rows: &[Row]) -> Table {
    let header = [
        "scene",
        "errors of the performance",
        "used of 960 Hz",
        "samples",
        "no estimate",
        "time ms",
        "rms mm, median",
        "95 %",
        "rms °, median",
        "95 %",
    ];
    let mut table = Table::new("samples", "", &header);
    for row in rows {
        let positions_mm = row.positions_mm();
        let angles_deg: Vec<f64> = row
            .errors
            .iter()
            .map(|error| error.orientation_rad.to_degrees())
            .collect();
        table.row([
            row.scene.to_owned(),
            row.hand.to_owned(),
            format!("1/{}", row.stride),
            format!("{:.0}", row.samples),
            format!("{} of {}", row.refused, row.performances),
            number(median(&row.times_ms)),
            number(median(&positions_mm)),
            number(quantile(&positions_mm, 0.95)),
            number(median(&angles_deg)),
            number(quantile(&angles_deg, 0.95)),
        ]);
    }
    table
}
