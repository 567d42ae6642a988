//! How often reported intervals hold the truth, over scenes, hands and how slowly they wander.

use std::collections::BTreeMap;

use anyhow::Result;
use enact::motion::{Timing, Verdict};
use serde::Serialize;

use super::{weighed, white_noise};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{INTERVALS, median, rms};
use crate::table::{Table, number, percent};
use enact_tools::case::{Case, Posed};
use enact_tools::perform::{Acting, Style};
use enact_tools::tosses;
use enact_tools::ways;

/// Performances of a way.
const SEEDS: u64 = 100;
/// What the tosses say of gravity together [m/s²].
const TOSSES_GRAVITY_M_S2: f64 = -9.648;

/// One way of acting.
#[derive(Default, Serialize)]
struct Row {
    way: String,
    runs: usize,
    /// Of these the quantities are.
    physical: usize,
    /// Errors and reported standard deviations, run by run.
    quantities: BTreeMap<String, Vec<(f64, Option<f64>)>>,
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let mut rows = Vec::new();
    for style in Style::ALL {
        for timing in ["known", "unknown"] {
            let way = format!("{}, {timing}, white noise, weighed by it", style.as_str());
            if options.wants(&way) {
                let case = |seed| Some(white(style, timing == "unknown", seed));
                rows.push(Row::of(way, options, case));
            }
        }
    }
    for way in ways::all() {
        if options.wants(&way.name) {
            rows.push(Row::of(way.name.clone(), options, |seed| way.case(seed)));
        }
    }
    rows.extend(real_tosses()?);
    record.table(table(&rows));
    let of = |row: &Row| -> Vec<(f64, Option<f64>)> {
        row.quantities.values().flatten().copied().collect()
    };
    let all: Vec<(f64, Option<f64>)> = rows
        .iter()
        .filter(|row| !row.way.starts_with("real"))
        .flat_map(of)
        .collect();
    let (held, determined) = held(&all, INTERVALS[2].1);
    record.say(format!(
        "Reported 95 % intervals hold the truth {} of the time, over all hands and scenes ({determined} intervals).",
        percent(held, determined)
    ));
    record.numbers("intervals", &rows)
}

/// White noise of the size that the scene's weights say.
fn white(style: Style, timing_is_unknown: bool, seed: u64) -> Case {
    let white = white_noise();
    let mut truth = weighed(style, &white);
    if !timing_is_unknown {
        return Case::new(&truth, &white, seed);
    }
    truth.scene.timing = Timing::Unknown {
        tempo_sd_per_sqrt_s: 0.5,
    };
    let slow = Acting {
        slowdown: 2.5,
        tempo_variation: 0.3,
        ..white
    };
    Case::new(&truth, &slow, seed)
}

impl Row {
    /// All performances; none where data that they need are not there.
    fn of(way: String, options: &Options, case: impl Fn(u64) -> Option<Case>) -> Self {
        let mut row = Self {
            way,
            ..Self::default()
        };
        for seed in options.seeds(SEEDS) {
            let Some(case) = case(seed) else {
                eprintln!("  left out: {}: no real hand", row.way);
                break;
            };
            row.add_case(&case);
        }
        row
    }

    fn add(&mut self, name: &str, error: f64, sd: Option<f64>) {
        // Bounces are alike; their numbers are not.
        let name = name.trim_end_matches(|c: char| c.is_ascii_digit() || c == ' ');
        self.quantities
            .entry(name.to_owned())
            .or_default()
            .push((error, sd));
    }

    fn add_case(&mut self, case: &Case) {
        self.runs += 1;
        let Ok(outcome) = case.estimated(&mut ()) else {
            return;
        };
        let estimate = &outcome.estimate;
        if estimate.verdict != Verdict::Physical {
            return;
        }
        self.physical += 1;
        let posed = Posed::new(case.scene(), &outcome.sketch);
        let offset_s = case.offset_s(&posed, &outcome.sketch);
        let truth = &case.performance.truth;
        for event in &estimate.events {
            let true_s = truth.event_times_s[event.event] + offset_s;
            if posed.problem.event_is_free[event.event] {
                let name = format!("time of {}", case.scene().events[event.event].name);
                self.add(&name, event.time_s - true_s, event.sd_s);
            }
        }
        for (parameter, truth) in estimate.parameters.iter().zip(&truth.parameters) {
            self.add(&parameter.name, parameter.value - truth, parameter.sd);
        }
    }
}

/// Vertical gravity of the real tosses against what all of them say together.
fn real_tosses() -> Result<Option<Row>> {
    let Some((scene, tosses)) = tosses::all()? else {
        return Ok(None);
    };
    let mut row = Row {
        way: "real tosses, gravity free".to_owned(),
        ..Row::default()
    };
    for toss in &tosses {
        row.runs += 1;
        let Ok(outcome) = toss.first_flight(&scene, tosses::RATES_HZ[0]) else {
            continue;
        };
        let estimate = &outcome.estimate;
        let vertical = estimate.parameters.iter().find(|p| p.name == "gravity.z");
        if let (Verdict::Physical, Some(vertical)) = (estimate.verdict, vertical) {
            row.physical += 1;
            row.add(
                &vertical.name,
                vertical.value - TOSSES_GRAVITY_M_S2,
                vertical.sd,
            );
        }
    }
    Ok(Some(row))
}

/// How many intervals of that half width hold the truth, of how many there are.
fn held(runs: &[(f64, Option<f64>)], width: f64) -> (usize, usize) {
    let determined = runs.iter().filter_map(|(error, sd)| Some((*error, (*sd)?)));
    determined.fold((0, 0), |(held, all), (error, sd)| {
        (held + usize::from(error.abs() <= width * sd), all + 1)
    })
}

fn table(rows: &[Row]) -> Table {
    let header = [
        "way",
        "physical",
        "of",
        "quantity",
        "undetermined",
        "50 %",
        "90 %",
        "95 %",
        "rms error",
        "rms sd",
        "median sd",
    ];
    let title = "Share of reported 50, 90 and 95 % intervals that hold the truth (s, m/s², –)";
    let mut table = Table::new("intervals", title, &header);
    for row in rows {
        for (name, runs) in &row.quantities {
            let determined = runs.iter().filter_map(|(error, sd)| Some((*error, (*sd)?)));
            let (errors, sds): (Vec<f64>, Vec<f64>) = determined.unzip();
            let [fifty, ninety, most] = INTERVALS.map(|(_, width)| {
                let (held, all) = held(runs, width);
                percent(held, all)
            });
            table.row([
                row.way.clone(),
                row.physical.to_string(),
                row.runs.to_string(),
                name.clone(),
                (runs.len() - sds.len()).to_string(),
                fifty,
                ninety,
                most,
                number(rms(&errors)),
                number(rms(&sds)),
                number(median(&sds)),
            ]);
        }
    }
    table
}
