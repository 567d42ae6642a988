//! How often reported intervals hold the truth, over scenes, hands and how slowly they wander.
//!
//! What the noise model was chosen on: seeds 0 to 119. What is reported begins at the
//! option's 5000.

use std::collections::BTreeMap;

use anyhow::Result;
use enact::config::scene_from_toml;
use enact::motion::{Estimate, Scene, Verdict};
use serde::Serialize;

use crate::results::Options;
use crate::statistics::{median, rms};
use crate::table::{Table, number, percent};
use crate::tosses;
use enact_tools::case::{Case, Posed, estimated};
use enact_tools::ways;

/// Half widths of the 50, 90 and 95 % intervals [standard deviations].
const INTERVALS: [f64; 3] = [0.674_49, 1.644_85, 1.959_96];
/// What the tosses say of gravity together [m/s²].
const TOSSES_GRAVITY_M_S2: f64 = -9.648;

/// One reported quantity of one way.
#[derive(Default, Serialize)]
struct Quantity {
    /// Error and reported standard deviation, run by run.
    runs: Vec<(f64, Option<f64>)>,
}

/// One way of acting.
#[derive(Serialize)]
struct Row {
    way: String,
    runs: usize,
    /// Of these the quantities are.
    physical: usize,
    quantities: BTreeMap<String, Quantity>,
}

impl Row {
    fn new(way: String) -> Self {
        Self {
            way,
            runs: 0,
            physical: 0,
            quantities: BTreeMap::new(),
        }
    }

    fn add(&mut self, name: &str, error: f64, sd: Option<f64>) {
        // Bounces are alike; their numbers are not.
        let name = name.trim_end_matches(|c: char| c.is_ascii_digit() || c == ' ');
        let quantity = self.quantities.entry(name.to_owned()).or_default();
        quantity.runs.push((error, sd));
    }

    fn add_case(&mut self, case: &Case) {
        self.runs += 1;
        let Ok(outcome) = case.estimated(&mut ()) else {
            return;
        };
        if outcome.estimate.verdict != Verdict::Physical {
            return;
        }
        self.physical += 1;
        let posed = Posed::new(case.scene(), &outcome.sketch);
        let offset_s = case.offset_s(&posed, &outcome.sketch);
        let truth = &case.performance.truth;
        let estimate = &outcome.estimate;
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

/// Runs it.
pub fn run(options: &Options) -> Result<()> {
    let mut rows = Vec::new();
    for way in ways::all() {
        if !options.wants(&way.name) {
            continue;
        }
        let mut row = Row::new(way.name.clone());
        for seed in options.range() {
            let Some(case) = way.case(seed) else {
                eprintln!("skipped: {}: no real hand", way.name);
                break;
            };
            row.add_case(&case);
        }
        rows.push(row);
    }
    if let Some(row) = real_tosses()? {
        rows.push(row);
    }
    options.show(table(&rows));
    if options.only.is_some() {
        return Ok(());
    }
    options.write_csv(
        "coverage",
        "way,quantity,runs,physical,determined,hold_50,hold_90,hold_95,rms_error,rms_sd,median_sd",
        &rows.iter().flat_map(lines).collect::<Vec<String>>(),
    )
}

/// Vertical gravity of the real tosses against what all of them say together.
fn real_tosses() -> Result<Option<Row>> {
    let Some(folder) = tosses::folder() else {
        return Ok(None);
    };
    let scene: Scene = scene_from_toml(&tosses::scene_toml()?)?;
    let mut row = Row::new("real tosses, gravity free".into());
    for toss in tosses::read(&folder, &scene)? {
        let last = toss.flight as f64 - 1.0;
        let events = tosses::take(&toss, tosses::RATES_HZ[0], toss.flight, &[(last, "impact")]);
        row.runs += 1;
        let Ok(outcome) = estimated(&scene, &events, &mut ()) else {
            continue;
        };
        let estimate: &Estimate = &outcome.estimate;
        let vertical = estimate.parameters.iter().find(|p| p.name == "gravity.z");
        if let (Verdict::Physical, Some(vertical)) = (estimate.verdict, vertical) {
            row.physical += 1;
            let error = vertical.value - TOSSES_GRAVITY_M_S2;
            row.add(&vertical.name, error, vertical.sd);
        }
    }
    Ok(Some(row))
}

/// Of one quantity: runs, determined ones, those whose intervals hold, rms error and sd, median sd.
struct Account {
    all: usize,
    determined: usize,
    hold: [usize; 3],
    rms_error: f64,
    rms_sd: f64,
    median_sd: f64,
}

impl Quantity {
    fn account(&self) -> Account {
        let determined = self
            .runs
            .iter()
            .filter_map(|(error, sd)| Some((*error, (*sd)?)));
        let determined: Vec<(f64, f64)> = determined.collect();
        let errors: Vec<f64> = determined.iter().map(|(error, _)| *error).collect();
        let sds: Vec<f64> = determined.iter().map(|(_, sd)| *sd).collect();
        let hold = INTERVALS.map(|width| {
            let holds = |(error, sd): &&(f64, f64)| error.abs() <= width * sd;
            determined.iter().filter(holds).count()
        });
        Account {
            all: self.runs.len(),
            determined: determined.len(),
            hold,
            rms_error: rms(&errors),
            rms_sd: rms(&sds),
            median_sd: median(&sds),
        }
    }
}

fn lines(row: &Row) -> Vec<String> {
    let quantities = row.quantities.iter();
    quantities
        .map(|(name, quantity)| {
            let a = quantity.account();
            format!(
                "\"{}\",{name},{},{},{},{},{},{},{:.5e},{:.5e},{:.5e}",
                row.way,
                row.runs,
                row.physical,
                a.determined,
                a.hold[0],
                a.hold[1],
                a.hold[2],
                a.rms_error,
                a.rms_sd,
                a.median_sd
            )
        })
        .collect()
}

fn table(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "Share of reported 50, 90 and 95 % intervals that hold the truth (s, m/s², –)",
        &[
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
        ],
    );
    for row in rows {
        for (name, quantity) in &row.quantities {
            let a = quantity.account();
            let [fifty, ninety, most] = a.hold.map(|hold| percent(hold, a.determined));
            table.row([
                row.way.clone(),
                row.physical.to_string(),
                row.runs.to_string(),
                name.clone(),
                (a.all - a.determined).to_string(),
                fifty,
                ninety,
                most,
                number(a.rms_error),
                number(a.rms_sd),
                number(a.median_sd),
            ]);
        }
    }
    table
}
