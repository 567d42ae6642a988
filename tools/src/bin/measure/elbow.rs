//! Real tosses of two boxes joined by a hinge: residuals, gravity, and what the scene says wrongly.

mod struck;

use std::time::Instant;

use anyhow::Result;
use enact::motion::{Estimate, Scene, TakeEvent, TrackResidual, Verdict};
use enact::pipeline::Pipeline;
use enact_tools::elbow::{self, Reading, Reads};
use serde::Serialize;

use crate::options::Options;
use crate::record::Record;
use crate::statistics::{largest, median};
use crate::table::{Table, number, percent, share};

/// Least readings of a flight.
const LEAST: usize = 10;
/// Gravities between which the lowest objective is looked for [m/s²].
const GRAVITIES_M_S2: [f64; 3] = [9.3, 9.8, 10.3];

/// One flight.
#[derive(Serialize)]
struct Flown {
    toss: String,
    readings: usize,
    verdict: String,
    is_motion: bool,
    is_physical: bool,
    doubts: Vec<String>,
    /// Root mean square residuals of the boxes that are seen, the greater \[mm, degrees\].
    off_mm: Option<f64>,
    off_deg: Option<f64>,
    /// Root mean square error of the hinge's angle against the reading, over the later half \[degrees\].
    angle_off_deg: Option<f64>,
    gravity_m_s2: Option<f64>,
    seconds: f64,
}

fn finished(scene: Scene, events: &[TakeEvent]) -> Estimate {
    let outcome = Pipeline::of(scene, events.iter().cloned()).finish(&mut ());
    outcome.expect("an estimate").estimate
}

/// The greatest residual of a kind of the bodies that are seen.
fn greatest(estimate: &Estimate, of: impl Fn(&TrackResidual) -> Option<f64>) -> Option<f64> {
    let residuals = estimate.trees.first()?.residuals.iter();
    residuals.filter_map(of).reduce(f64::max)
}

/// Between which values the middle half lies.
fn middle_half(values: &[f64]) -> String {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let quarter = sorted.len() / 4;
    let last = sorted.len().checked_sub(1 + quarter);
    match (sorted.get(quarter), last.and_then(|at| sorted.get(at))) {
        (Some(low), Some(high)) => format!("{low:.2} to {high:.2}"),
        _ => String::new(),
    }
}

/// The gravity with the lowest objective, of the parabola through three.
fn gravity_m_s2(scene: &Scene, events: &[TakeEvent]) -> Option<f64> {
    let [low, middle, high] = GRAVITIES_M_S2.map(|gravity_m_s2| {
        let mut scene = scene.clone();
        scene.gravity_m_s2.z = -gravity_m_s2;
        finished(scene, events).objective
    });
    let step = GRAVITIES_M_S2[1] - GRAVITIES_M_S2[0];
    let bend = low - 2.0 * middle + high;
    (bend > 0.0).then(|| GRAVITIES_M_S2[1] + 0.5 * step * (low - high) / bend)
}

impl Flown {
    fn of(toss: String, flight: &[Reading], reads: &Reads) -> Self {
        let (scene, events) = elbow::take(flight, reads);
        let begin = Instant::now();
        let estimate = finished(scene.clone(), &events);
        let seconds = begin.elapsed().as_secs_f64();
        let motion = estimate.trees.first();
        let is_motion = estimate.verdict != Verdict::Failed;
        let angle_off_deg = motion.filter(|_| is_motion).map(|motion| {
            let (_, joined) = scene.joint_trees().next().expect("a tree");
            let tree = scene.tree_model(joined);
            let [_, angle] = tree.angles_of(1).expect("a pin");
            let begin_s = flight[0].time_s;
            let later = &flight[flight.len() / 2..];
            let squares = later.iter().map(|reading| {
                let time_s = reading.time_s - begin_s;
                let state = motion.state(&tree, &estimate.gravity_m_s2, time_s);
                let off_rad = state.coordinates[angle.start] - reading.angle_rad;
                let turns = (off_rad / std::f64::consts::TAU).round();
                (off_rad - turns * std::f64::consts::TAU).powi(2)
            });
            (squares.sum::<f64>() / later.len() as f64)
                .sqrt()
                .to_degrees()
        });
        Self {
            toss,
            readings: flight.len(),
            verdict: format!("{:?}", estimate.verdict).to_lowercase(),
            is_motion,
            is_physical: estimate.verdict == Verdict::Physical,
            doubts: estimate
                .doubts
                .iter()
                .map(|of| of.about.as_str().to_owned())
                .collect(),
            off_mm: greatest(&estimate, |of| of.position_rms_m.map(|m| 1e3 * m)),
            off_deg: greatest(&estimate, |of| of.orientation_rms_rad.map(f64::to_degrees)),
            angle_off_deg,
            gravity_m_s2: gravity_m_s2(&scene, &events),
            seconds,
        }
    }
}

fn variants() -> [(&'static str, Reads); 5] {
    let documented = Reads {
        sees_both: true,
        moment_kg_m2: Some(6.167e-4),
        hinge_off_m: 0.0,
    };
    let uniform = Reads {
        moment_kg_m2: None,
        ..documented
    };
    let one = |reads: Reads| Reads {
        sees_both: false,
        ..reads
    };
    [
        ("both seen, moments as documented", documented),
        ("both seen, uniform boxes", uniform),
        ("the first seen, moments as documented", one(documented)),
        ("the first seen, uniform boxes", one(uniform)),
        (
            "both seen, uniform boxes, hinge 10 mm off",
            Reads {
                hinge_off_m: 0.01,
                ..uniform
            },
        ),
    ]
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let header = [
        "read as",
        "flights",
        "motions",
        "physical",
        "off, mm",
        "most, mm",
        "off, degrees",
        "angle off, degrees",
        "most, degrees",
        "gravity, m/s²",
        "middle half, m/s²",
        "time, ms",
    ];
    let mut table = Table::new("elbow", "", &header);
    let mut numbers = Vec::new();
    let mut said = None;
    // Every other toss, from the first: the height at which flights end was chosen on the others.
    let mut files: Vec<_> = elbow::files().into_iter().step_by(2).collect();
    if files.is_empty() {
        return Ok(());
    }
    if options.quick {
        files.truncate(3);
    }
    for (name, reads) in variants() {
        let mut all = Vec::new();
        for file in &files {
            let flight = elbow::flight(file);
            if flight.len() >= LEAST {
                let toss = file.file_stem().unwrap_or_default().to_string_lossy();
                all.push(Flown::of(toss.into_owned(), &flight, &reads));
            }
        }
        let of =
            |of: &dyn Fn(&Flown) -> Option<f64>| all.iter().filter_map(of).collect::<Vec<f64>>();
        let gravities = of(&|one| one.gravity_m_s2);
        table.row([
            name.to_owned(),
            all.len().to_string(),
            share(&all, |one| one.is_motion),
            share(&all, |one| one.is_physical),
            number(median(&of(&|one| one.off_mm))),
            number(largest(&of(&|one| one.off_mm))),
            number(median(&of(&|one| one.off_deg))),
            number(median(&of(&|one| one.angle_off_deg))),
            number(largest(&of(&|one| one.angle_off_deg))),
            number(median(&gravities)),
            middle_half(&gravities),
            number(1e3 * median(&of(&|one| Some(one.seconds)))),
        ]);
        eprintln!("  {name}");
        let physical = all.iter().filter(|one| one.is_physical).count();
        said.get_or_insert_with(|| (percent(physical, all.len()), median(&of(&|one| one.off_mm))));
        numbers.push((name, all));
    }
    if let Some((physical, off_mm)) = said {
        record.say(format!(
            "Real flights of two boxes joined by a hinge: {physical} physical, {} mm from the readings in the median.",
            number(off_mm)
        ));
    }
    record.table(table);
    record.numbers("elbow", &numbers)?;
    struck::run(options, record)
}
