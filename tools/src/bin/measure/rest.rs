//! Dice that are asked to show a face at rest: whether they do, whether it is said where not, and how
//! far from the performance that leads.

use std::time::Instant;

use anyhow::Result;
use enact::motion::{About, LinkIndex, Verdict};
use enact::pipeline::Outcome;
use enact::sampling::SampledMotion;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde::Serialize;

use crate::options::Options;
use crate::record::Record;
use crate::statistics::{median, quantile};
use crate::table::{Table, number, percent};
use enact_tools::case::Case;
use enact_tools::perform::{Acting, Roll};

/// Rolls whose stamps are physical times, acted slowly, and with labels that are free.
const SEEDS: [u64; 3] = [1000, 100, 100];
/// A face is up where its normal is no farther from up than this \[rad\]: the scenes' own angle.
const UP_RAD: f64 = 0.18;

/// One roll.
#[derive(Serialize)]
struct Rolled {
    seed: u64,
    side_mm: f64,
    bounces: usize,
    friction: f64,
    asked: &'static str,
    verdict: &'static str,
    /// Whether the program says that the face is shown, and that nothing near shows it.
    reached: bool,
    refused: bool,
    /// Whether the last exported pose shows it.
    shown: bool,
    /// Whether a search was needed.
    searched: bool,
    /// Root mean square residual in weights: of the best motion and of this one.
    best_rms: f64,
    rms: f64,
    time_ms: f64,
    doubts: Vec<&'static str>,
}

impl Rolled {
    fn is_wrong(&self) -> bool {
        (self.reached || self.verdict == Verdict::Physical.as_str()) && !self.shown
    }
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let mut table = Table::new(
        "rolls",
        "Faces asked for",
        &[
            "performances",
            "rolls",
            "face shown",
            "of these physical",
            "says it cannot",
            "no motion",
            "wrong",
            "shown at once",
            "best, rms weights",
            "shown, rms weights",
            "95 %",
            "median time",
            "95 %",
        ],
    );
    let ways = [
        ("physical stamps", Acting::timing_known(), "physical", ""),
        ("acted slowly", Acting::default(), "tempo", ""),
        (
            "physical stamps, labels free",
            Acting::timing_known(),
            "physical",
            "labels = \"free\"\n",
        ),
    ];
    for ((what, acting, stamps, goal), most) in ways.into_iter().zip(SEEDS) {
        if !options.wants(what) {
            continue;
        }
        let rolled = options.seeds(most);
        let rolled: Vec<Rolled> = rolled
            .filter_map(|seed| rolled_of(seed, &acting, stamps, goal))
            .collect();
        let count = |is: &dyn Fn(&Rolled) -> bool| rolled.iter().filter(|r| is(r)).count();
        let shown = count(&|r| r.reached && r.shown);
        let searched = || rolled.iter().filter(|r| r.reached && r.searched);
        let rms = |of: fn(&Rolled) -> f64| searched().map(of).collect::<Vec<f64>>();
        let times: Vec<f64> = rolled.iter().map(|r| r.time_ms).collect();
        table.row([
            what.to_owned(),
            rolled.len().to_string(),
            percent(shown, rolled.len()),
            count(&|r| r.reached && r.verdict == Verdict::Physical.as_str()).to_string(),
            count(&|r| r.refused).to_string(),
            count(&|r| !r.reached && !r.refused).to_string(),
            count(&Rolled::is_wrong).to_string(),
            count(&|r| r.reached && !r.searched).to_string(),
            number(median(&rms(|r| r.best_rms))),
            number(median(&rms(|r| r.rms))),
            number(quantile(&rms(|r| r.rms), 0.95)),
            format!("{:.0} ms", median(&times)),
            format!("{:.0} ms", quantile(&times, 0.95)),
        ]);
        record.say(format!(
            "{what}: {shown} of {} rolls show the face that was asked for, {} are said not to, {} are wrong.",
            rolled.len(),
            count(&|r| r.refused),
            count(&Rolled::is_wrong),
        ));
        record.numbers(what, &rolled)?;
    }
    record.table(table);
    Ok(())
}

/// `None` where there is no such throw.
fn rolled_of(seed: u64, acting: &Acting, stamps: &str, goal: &str) -> Option<Rolled> {
    let roll = Roll::of(seed);
    let (truth, _) = roll.truth(goal, stamps).ok()?;
    let pipeline = Case::new(&truth, acting, seed).pipeline();
    let began = Instant::now();
    let outcome = pipeline.finish(&mut ());
    let time_ms = 1e3 * began.elapsed().as_secs_f64();
    let none = Rolled {
        seed,
        side_mm: 1e3 * roll.side_m(),
        bounces: roll.bounces,
        friction: roll.throw.friction,
        asked: roll.face,
        verdict: "refused",
        reached: false,
        refused: false,
        shown: false,
        searched: false,
        best_rms: f64::NAN,
        rms: f64::NAN,
        time_ms,
        doubts: Vec::new(),
    };
    let Ok(outcome) = outcome else {
        return Some(none);
    };
    let estimate = &outcome.estimate;
    let rms = |objective: f64| (objective / outcome.counts.used as f64).sqrt();
    let rest = outcome.rest.as_ref();
    let doubts = estimate.doubts.iter();
    Some(Rolled {
        verdict: estimate.verdict.as_str(),
        reached: rest.is_some_and(|rest| rest.is_reached()),
        refused: doubts.clone().any(|doubt| doubt.about == About::Rest),
        shown: is_shown(&outcome, roll.face),
        searched: rest.is_some_and(|rest| rest.work.motions > 0),
        best_rms: rest.map_or(f64::NAN, |rest| rms(rest.work.best_objective)),
        rms: rms(estimate.objective),
        doubts: doubts.map(|doubt| doubt.about.as_str()).collect(),
        ..none
    })
}

/// Whether the last pose that is exported has that axis up.
fn is_shown(outcome: &Outcome, face: &str) -> bool {
    let settled = outcome.settled.as_ref();
    let Ok(motion) = SampledMotion::new(
        &outcome.scene,
        &outcome.sketch,
        &outcome.estimate,
        settled,
        240.0,
    ) else {
        return false;
    };
    let Some(last) = motion.estimates[LinkIndex(0)].last() else {
        return false;
    };
    let [x, y, z, w] = last.quaternion_xyzw;
    let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    let axis = ["x", "y", "z"].iter().position(|axis| face.ends_with(axis));
    let sign = if face.starts_with('-') { -1.0 } else { 1.0 };
    let up = turn * Vector3::ith(axis.unwrap_or(0), sign);
    up.angle(&Vector3::z()) <= UP_RAD
}
