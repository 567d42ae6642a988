//! How long motions last that were acted in a tempo of their own: real tosses of a cube, replayed
//! slowly as if somebody had acted them, and acted pencils. Errors, and whether what is said of the
//! duration holds.
//!
//! One constant (`CONTRADICTION` in `src/core/estimate/covariance/timing.rs`) was chosen on every other toss, those
//! of even index in the manifest; the table keeps them apart.

use anyhow::{Context, Result};
use enact::config::scene_from_toml;
use enact::motion::{Estimate, Scene, TakeEvent, TrackIndex, Verdict};
use serde::Serialize;

use crate::options::Options;
use crate::record::Record;
use crate::statistics::{median, quantile};
use crate::table::{Table, number};
use enact_tools::case::{Case, estimated};
use enact_tools::perform::{Acting, Style};
use enact_tools::tosses::{self, FREE_LAW_TOML, IMPACT_TOML, RATES_HZ, Toss, end_toml, scene_toml};

/// Performances of a pencil.
const SEEDS: u64 = 60;
/// So many times slower than they were.
const SLOWDOWN: f64 = 2.5;
/// Samples after the first impact.
const AFTER_IMPACT: usize = 6;
/// What is far off, as a share of the duration.
const FAR: f64 = 0.2;
/// Of a standard deviation in an interval of 95 %.
const INTERVAL: f64 = 1.96;

/// One motion.
struct Told {
    error: f64,
    sd: f64,
    is_determined: bool,
    is_physical: bool,
}

impl Told {
    fn new(estimate: &Estimate, true_s: f64) -> Self {
        let duration = estimate.duration;
        Self {
            error: duration.duration_s / true_s - 1.0,
            sd: duration.sd_s.unwrap_or(f64::INFINITY) / true_s,
            is_determined: duration.is_determined(),
            is_physical: estimate.verdict == Verdict::Physical,
        }
    }

    fn is_far(&self) -> bool {
        self.error.abs() > FAR
    }
}

/// A row of the table.
#[derive(Serialize)]
struct Row {
    what: String,
    motions: usize,
    physical: usize,
    /// In the interval of 95 %.
    held: usize,
    /// Said to be undetermined.
    undetermined: usize,
    /// Physical and off by more than a fifth.
    far: usize,
    /// Those of them that are said to be undetermined.
    far_said: usize,
    median_error: f64,
    largest_error: f64,
    median_sd: f64,
}

impl Row {
    fn new(what: String, told: &[Told]) -> Self {
        let count = |is: &dyn Fn(&Told) -> bool| told.iter().filter(|told| is(told)).count();
        let errors: Vec<f64> = told.iter().map(|told| told.error.abs()).collect();
        let sds: Vec<f64> = told.iter().map(|told| told.sd).collect();
        let is_far = |told: &Told| told.is_physical && told.is_far();
        Self {
            what,
            motions: told.len(),
            physical: count(&|told| told.is_physical),
            held: count(&|told| told.error.abs() <= INTERVAL * told.sd),
            undetermined: count(&|told| !told.is_determined),
            far: count(&is_far),
            far_said: count(&|told| is_far(told) && !told.is_determined),
            median_error: median(&errors),
            largest_error: quantile(&errors, 1.0),
            median_sd: median(&sds),
        }
    }
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let mut rows = of_tosses()?;
    for style in Style::ALL {
        for distortion in [1.0, 2.0, 4.0] {
            let what = format!("pencil, {} first, {distortion}×", style.as_str());
            let told: Vec<Told> = options
                .seeds(SEEDS)
                .filter_map(|seed| pencil(style, distortion, seed))
                .collect();
            rows.push(Row::new(what, &told));
        }
    }
    record.table(table(&rows));
    record.numbers("rows", &rows)
}

fn pencil(style: Style, distortion: f64, seed: u64) -> Option<Told> {
    let acting = Acting {
        distortion,
        ..Acting::default()
    };
    let case = Case::pencil(style, &acting, seed);
    let estimate = case.estimated(&mut ()).ok()?.estimate;
    let start_s = case.hidden_s(TrackIndex(0), estimate.sample_times.first()?.stamp);
    let end_s = case.performance.truth.event_times_s.last()?;
    Some(Told::new(&estimate, end_s - start_s))
}

/// Rows of the tosses, if they are there.
fn of_tosses() -> Result<Vec<Row>> {
    let Some((_, tosses)) = tosses::all()? else {
        return Ok(Vec::new());
    };
    let (head, _) = scene_toml().split_once("[[event]]").context("events")?;
    let head = head.replace("\"physical\"", "\"tempo\"");
    let head = format!("gravity_m_s2 = [0, 0, -9.648]\n{head}");
    let end = end_toml("end");
    let scenes = [
        ("first flight", format!("{head}{end}"), 0),
        (
            "flight and impact, its law free",
            format!("{head}{IMPACT_TOML}{end}{FREE_LAW_TOML}"),
            AFTER_IMPACT,
        ),
        (
            "flight and impact of another law",
            format!("{head}{IMPACT_TOML}{end}"),
            AFTER_IMPACT,
        ),
    ];
    let mut rows = Vec::new();
    for (what, text, after) in scenes {
        let scene = scene_from_toml(&text)?;
        for (half, name) in ["even", "odd"].into_iter().enumerate() {
            let of_half = tosses.iter().skip(half).step_by(2);
            let told: Vec<Told> = of_half
                .filter_map(|toss| toss_told(&scene, toss, after))
                .collect();
            rows.push(Row::new(format!("toss, {what}, {name}"), &told));
        }
    }
    Ok(rows)
}

/// None where there is nothing to estimate from.
fn toss_told(scene: &Scene, toss: &Toss, after: usize) -> Option<Told> {
    let estimate = estimated(scene, &slowed(toss, after)?, &mut ())
        .ok()?
        .estimate;
    let last = toss.flight + after - 1;
    Some(Told::new(&estimate, last as f64 / RATES_HZ[0]))
}

/// The first flight of a toss, and so many samples after its impact, slowly.
fn slowed(toss: &Toss, after: usize) -> Option<Vec<TakeEvent>> {
    let count = toss.flight + after;
    let mut marks = vec![(count as f64 - 1.0, "end")];
    if after > 0 {
        marks.insert(0, (toss.flight as f64 - 0.5, "impact"));
    }
    let events = || toss.take(RATES_HZ[0] / SLOWDOWN, count, &marks);
    (count <= toss.poses.len()).then(events)
}

fn table(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "durations",
        "Durations of what was acted slowly",
        &[
            "what",
            "motions",
            "physical",
            "within 95 %",
            "said: not determined",
            "physical, off by a fifth",
            "of them said",
            "median error",
            "largest",
            "median sd",
        ],
    );
    for row in rows {
        table.row([
            row.what.clone(),
            row.motions.to_string(),
            row.physical.to_string(),
            row.held.to_string(),
            row.undetermined.to_string(),
            row.far.to_string(),
            row.far_said.to_string(),
            number(row.median_error),
            number(row.largest_error),
            number(row.median_sd),
        ]);
    }
    table
}
