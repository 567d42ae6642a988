//! Previews during a performance, against the estimate after it.

use anyhow::Result;
use enact::motion::{Stamp, TakeEvent};
use enact::pipeline::Preview;
use serde::Serialize;

use super::scenes::{SCENES, Scene};
use super::{REPEATS, SEEDS, mark, timed};
use crate::figure::{Axis, Curve, Figure};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{median, quantile};
use crate::table::{Table, number, percent};
use enact_tools::apart::apart;
use enact_tools::case::Case;

/// Of the tracker.
const RATE_HZ: f64 = 120.0;
/// A preview is made after every such share of a performance, and after every mark.
const STEPS: u32 = 20;
/// Steps that are shown.
const SHOWN: [u32; 4] = [5, 10, 15, 20];

/// What is known after a share of the performances of a scene.
#[derive(Serialize)]
struct Row {
    scene: &'static str,
    percent: u32,
    performances: usize,
    /// That went on from the one before.
    warm: usize,
    /// Time of a preview \[ms\].
    times_ms: Vec<f64>,
    /// From the true motion so far, rms \[mm\].
    errors_mm: Vec<f64>,
    /// Of the estimate after the performance, over the same part \[mm\].
    final_mm: Vec<f64>,
    /// Ratio of the two.
    over_final: Vec<f64>,
    /// Time of that estimate \[ms\].
    final_ms: Vec<f64>,
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let mut rows = Vec::new();
    for scene in SCENES {
        let mut of_scene = SHOWN.map(|step| Row {
            scene: scene.name,
            percent: 100 * step / STEPS,
            performances: 0,
            warm: 0,
            times_ms: Vec::new(),
            errors_mm: Vec::new(),
            final_mm: Vec::new(),
            over_final: Vec::new(),
            final_ms: Vec::new(),
        });
        for case in scene.cases(options, (RATE_HZ, 1.0)) {
            follow(&case, &mut of_scene);
        }
        rows.extend(of_scene);
    }
    record.figure(by_share(
        "spent_previews",
        "How near the truth previews are",
        "distance from the true motion so far, rms [mm]",
        &rows,
        |row| &row.errors_mm,
    ));
    record.figure(by_share(
        "spent_previews_final",
        "How near the truth previews are, beside the final estimate",
        "distance of a preview over that of the final estimate",
        &rows,
        |row| &row.over_final,
    ));
    record.figure(by_time(&rows));
    record.table(table(&rows));
    let over_final: Vec<f64> = rows.iter().map(|row| median(&row.over_final)).collect();
    record.say(format!(
        "Previews are at most {:.1} times as far from the truth as the final estimate of the same part (medians of {SEEDS} \
         performances, {} scenes).",
        quantile(&over_final, 1.0),
        SCENES.len()
    ));
    record.numbers("previews", &rows)
}

/// Acts a performance before the previews, as it came.
fn follow(case: &Case, rows: &mut [Row]) {
    let events = &case.performance.events;
    let (last, final_ms) = timed(|| case.estimated(&mut ()));
    let Ok(last) = last else { return };
    let stamps = || events.iter().map(stamp);
    let (Some(from), Some(to)) = (stamps().min(), stamps().max()) else {
        return;
    };
    let mut preview = Preview::new(case.scene().clone());
    let mut events = events.iter().peekable();
    for step in 1..=STEPS {
        let share = f64::from(step) / f64::from(STEPS);
        let until = Stamp(from.0 + (share * (to.0 - from.0) as f64).ceil() as i64);
        while let Some(event) = events.next_if(|event| stamp(event) <= until) {
            preview.push(event.clone());
            if matches!(event, TakeEvent::Mark(_)) {
                // Too early for one, mostly.
                let _ = preview.estimate(&mut ());
            }
        }
        let before = preview.clone();
        let (_, took_ms) = timed(|| before.clone().estimate(&mut ()).is_ok());
        let previewed = preview.estimate(&mut ());
        let Some(row) = rows
            .iter_mut()
            .find(|row| row.percent * STEPS == 100 * step)
        else {
            continue;
        };
        row.performances += 1;
        row.final_ms.push(final_ms);
        let acting = &case.performance.acting;
        let acted_s = until.seconds_since(acting.start) - acting.hold_before_s;
        let until_s = case.performance.tempo.physical_s(acted_s);
        let off_mm =
            |scene, estimate| Some(1e3 * apart(case, scene, estimate, until_s)?.position_m);
        let final_mm = off_mm(&last.scene, &last.estimate);
        row.final_mm.extend(final_mm);
        let Ok(Some(previewed)) = previewed else {
            continue;
        };
        row.warm += usize::from(previewed.is_warm);
        row.times_ms.push(took_ms);
        let error_mm = off_mm(&previewed.outcome.scene, &previewed.outcome.estimate);
        row.errors_mm.extend(error_mm);
        let both = error_mm.zip(final_mm);
        row.over_final
            .extend(both.map(|(error_mm, final_mm)| error_mm / final_mm));
    }
}

fn stamp(event: &TakeEvent) -> Stamp {
    match event {
        TakeEvent::Pose { sample, .. } => sample.stamp,
        TakeEvent::Mark(mark) => mark.stamp,
    }
}

fn of<'a>(scene: &'a Scene, rows: &'a [Row]) -> impl Iterator<Item = &'a Row> {
    rows.iter()
        .filter(|row| row.scene == scene.name && !row.errors_mm.is_empty())
}

/// By the share of the performance.
fn by_share(
    name: &str,
    title: &str,
    label: &str,
    rows: &[Row],
    shown: fn(&Row) -> &[f64],
) -> Figure {
    let curves = SCENES.iter().map(|scene| {
        let points =
            of(scene, rows).map(|row| mark(f64::from(row.percent), shown(row), row.performances));
        Curve::new(scene.name, points.collect())
    });
    Figure {
        name: name.into(),
        title: title.into(),
        note: format!(
            "Previews after 25, 50, 75 and 100 % of a performance at {RATE_HZ} Hz, one made every {} % and after every mark. \
             Distances are of centres of mass from the true motion, from its beginning to what was acted last, rms over time and \
             bodies; the final estimate is compared over the same part. Medians, with bars up to what 95 % are below.",
            100 / STEPS
        ),
        x: Axis::linear("share of the performance [%]"),
        y: Axis::logarithmic(label),
        curves: curves.collect(),
    }
}

fn by_time(rows: &[Row]) -> Figure {
    let curves = SCENES.iter().map(|scene| {
        let points = of(scene, rows).map(|row| {
            let mut point = mark(median(&row.times_ms), &row.errors_mm, row.performances);
            point.setting = Some(format!("{} %", row.percent));
            point
        });
        Curve::new(scene.name, points.collect())
    });
    Figure {
        name: "spent_previews_time".into(),
        title: "How near the truth previews are, by what they cost".into(),
        note: format!(
            "The same previews. Across: median time of a preview on one thread, the fastest of {REPEATS} runs each."
        ),
        x: Axis::logarithmic("time of a preview [ms]"),
        y: Axis::logarithmic("distance from the true motion so far, rms [mm]"),
        curves: curves.collect(),
    }
}

fn table(rows: &[Row]) -> Table {
    let header = [
        "scene",
        "acted",
        "previews",
        "warm",
        "time ms, median",
        "95 %",
        "rms mm, median",
        "95 %",
        "final of that part, median",
        "95 %",
        "preview over final, median",
        "95 %",
        "final's time ms",
    ];
    let mut table = Table::new("previews", "", &header);
    for row in rows {
        table.row([
            row.scene.to_owned(),
            format!("{} %", row.percent),
            format!("{} of {}", row.errors_mm.len(), row.performances),
            percent(row.warm, row.errors_mm.len()),
            number(median(&row.times_ms)),
            number(quantile(&row.times_ms, 0.95)),
            number(median(&row.errors_mm)),
            number(quantile(&row.errors_mm, 0.95)),
            number(median(&row.final_mm)),
            number(quantile(&row.final_mm, 0.95)),
            number(median(&row.over_final)),
            number(quantile(&row.over_final, 0.95)),
            number(median(&row.final_ms)),
        ]);
    }
    table
}
