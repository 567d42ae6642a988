//! Phases of motions drawn at random: how near times and coefficients are to the truth, and how often they are within their
//! deviations.

use anyhow::Result;
use enact::motion::{Fits, Verdict};
use enact::pipeline::Pipeline;
use enact_tools::phases::{PhaseKind, PhasedTake};
use rayon::prelude::*;
use serde::Serialize;

use crate::core_time::{CoreLimit, CoreTime};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{largest, median, quantile};
use crate::table::{Table, number, percent};

/// Seeds that are drawn of a kind.
const SEEDS: u64 = 100;
/// After which an answer is told to stop \[s on a core\].
const LIMIT_S: f64 = 20.0;
/// A time that is told is right within so many deviations, or within this \[s\].
const DEVIATIONS: f64 = 3.0;
const NEAR_S: f64 = 0.01;
/// Beyond so many, one is wrong in silence where nothing speaks against the motion.
const WRONG: f64 = 4.0;
/// Half width of a 95 % interval, in deviations.
const INTERVAL: f64 = 1.96;

/// What is told of a number, beside the truth.
#[derive(Clone, Copy, Serialize)]
struct Told {
    off: f64,
    sd: Option<f64>,
}

impl Told {
    fn is_within(&self, deviations: f64) -> bool {
        self.sd.is_some_and(|sd| self.off.abs() <= deviations * sd)
    }
}

/// The answer to one take.
#[derive(Serialize)]
struct Answered {
    seed: u64,
    is_refused: bool,
    is_physical: bool,
    fits: bool,
    /// Of times of changes \[s\].
    times: Vec<Told>,
    /// Of free parameters.
    values: Vec<Told>,
    seconds: f64,
}

impl Answered {
    fn of(take: PhasedTake, seed: u64) -> Self {
        let PhasedTake {
            scene,
            events,
            changes_s,
            values,
        } = take;
        let time = CoreTime::begin();
        let outcome = Pipeline::of(scene, events).finish(&mut CoreLimit(&time, LIMIT_S));
        let seconds = time.seconds();
        let Ok(outcome) = outcome else {
            return Self {
                seed,
                is_refused: true,
                is_physical: false,
                fits: false,
                times: Vec::new(),
                values: Vec::new(),
                seconds,
            };
        };
        let estimate = &outcome.estimate;
        let names = outcome.scene.events.iter().map(|event| &event.name);
        let names: Vec<&String> = names.collect();
        let times = changes_s.iter().filter_map(|(name, truth_s)| {
            let mut told = estimate.events.iter();
            let told = told.find(|of| names[of.event] == name)?;
            Some(Told {
                off: told.time_s - truth_s,
                sd: told.sd_s,
            })
        });
        let values = values.iter().filter_map(|(name, truth)| {
            let mut told = estimate.parameters.iter();
            let told = told.find(|of| of.name == *name)?;
            Some(Told {
                off: told.value - truth,
                sd: told.sd,
            })
        });
        Self {
            seed,
            is_refused: false,
            is_physical: estimate.verdict == Verdict::Physical,
            fits: estimate.fits() != Fits::No && estimate.suspects.is_empty(),
            times: times.collect(),
            values: values.collect(),
            seconds,
        }
    }

    fn is_well(&self) -> bool {
        self.is_physical && self.fits
    }

    fn is_silent(&self) -> bool {
        let mut all = self.times.iter().chain(&self.values);
        self.is_well() && all.any(|of| of.sd.is_some() && !of.is_within(WRONG))
    }
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let header = [
        "motion",
        "seen by",
        "takes",
        "physical",
        "nothing against",
        "times off, ms: median",
        "nine of ten",
        "largest",
        "within 10 ms or 3 deviations",
        "in 95 % intervals",
        "coefficients in 95 % intervals",
        "silent",
        "time, ms",
        "longest, s",
    ];
    let mut table = Table::new("phases", "", &header);
    let mut all = Vec::new();
    for kind in PhaseKind::ALL {
        for (seen, is_acted) in [("a tracker", false), ("a hand that strays by 8 mm", true)] {
            let row = format!("{}, {seen}", kind.as_str());
            if !options.wants(&row) {
                continue;
            }
            let seeds = options.seeds(SEEDS).into_par_iter();
            let answers = seeds.map(|seed| Answered::of(kind.draw(seed, is_acted), seed));
            let answers: Vec<Answered> = answers.collect();
            let names = [kind.as_str(), seen].map(str::to_owned);
            table.row(names.into_iter().chain(cells(&answers)));
            eprintln!("  {row}");
            all.push((row, answers));
        }
    }
    let answers = || all.iter().flat_map(|(_, answers)| answers);
    record.say(format!(
        "Of {} takes with phases {} are physical, nothing speaks against {}; in {} of these a time or a coefficient is more than four \
         deviations off.",
        answers().count(),
        answers().filter(|of| of.is_physical).count(),
        answers().filter(|of| of.is_well()).count(),
        answers().filter(|of| of.is_silent()).count(),
    ));
    record.table(table);
    record.numbers("phases", &all)
}

fn cells(answers: &[Answered]) -> [String; 12] {
    let times: Vec<&Told> = answers.iter().flat_map(|of| &of.times).collect();
    let values: Vec<&Told> = answers.iter().flat_map(|of| &of.values).collect();
    let off_ms: Vec<f64> = times.iter().map(|of| 1e3 * of.off.abs()).collect();
    let told: Vec<&&Told> = times.iter().filter(|of| of.sd.is_some()).collect();
    let seconds: Vec<f64> = answers.iter().map(|of| of.seconds).collect();
    let is_right = |of: &&&Told| of.off.abs() <= NEAR_S || of.is_within(DEVIATIONS);
    let count = |is: fn(&Answered) -> bool| {
        let of_them = answers.iter().filter(|of| is(of)).count();
        of_them.to_string()
    };
    [
        answers.len().to_string(),
        count(|of| of.is_physical),
        count(Answered::is_well),
        number(median(&off_ms)),
        number(quantile(&off_ms, 0.9)),
        number(largest(&off_ms)),
        percent(times.iter().filter(is_right).count(), times.len()),
        percent(
            told.iter().filter(|of| of.is_within(INTERVAL)).count(),
            told.len(),
        ),
        percent(
            values.iter().filter(|of| of.is_within(INTERVAL)).count(),
            values.len(),
        ),
        count(Answered::is_silent),
        number(1e3 * median(&seconds)),
        number(largest(&seconds)),
    ]
}
