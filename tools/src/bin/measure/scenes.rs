//! Right performances of scenes drawn at random: how often nothing speaks against the motion, how near the truth it is then, and
//! what speaks against the rest.

use std::collections::BTreeMap;

use anyhow::Result;
use enact::motion::{Fits, Verdict};
use enact::pipeline::{Outcome, PipelineError};
use enact_tools::errors::EventTimesOff;
use enact_tools::scenes::{Asked, DrawnScene};
use rayon::prelude::*;
use serde::Serialize;

use crate::core_time::{CoreLimit, CoreTime};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{largest, median};
use crate::table::{Table, number, share};

/// Seeds that are drawn of a row.
const SEEDS: u64 = 60;
/// After which an answer is told to stop \[s on a core\].
const LIMIT_S: f64 = 20.0;
/// An event's time that is farther off than so many deviations is wrong in silence where nothing speaks against the motion.
const DEVIATIONS: f64 = 4.0;
/// Share of the body's length by which a hand wanders that is small.
const SMALL: f64 = 0.2;
/// Causes that a row shows.
const SHOWN: usize = 4;

/// The answer to one performance.
#[derive(Serialize)]
struct Answered {
    seed: u64,
    /// Whether marks are as people make them.
    has_rough_marks: bool,
    /// What speaks against the motion; nothing where it is empty.
    against: Vec<String>,
    /// How far the time of an event is off, in its deviations.
    deviations: f64,
    /// How far the time of an event is off \[ms\].
    off_ms: f64,
    seconds: f64,
}

impl Answered {
    fn of(scene: &DrawnScene, asked: Asked, seed: u64) -> Self {
        let case = scene.case(asked);
        let time = CoreTime::begin();
        let outcome = case.pipeline().finish(&mut CoreLimit(&time, LIMIT_S));
        let seconds = time.seconds();
        let off = match &outcome {
            Ok(outcome) => EventTimesOff::of(&case, outcome),
            Err(_) => EventTimesOff {
                ms: f64::NAN,
                deviations: f64::NAN,
            },
        };
        Self {
            seed,
            has_rough_marks: scene.has_rough_marks,
            against: against(&outcome),
            deviations: off.deviations,
            off_ms: off.ms,
            seconds,
        }
    }

    fn is_good(&self) -> bool {
        self.against.is_empty()
    }

    fn is_silent(&self) -> bool {
        self.is_good() && self.deviations > DEVIATIONS
    }
}

/// What speaks against a motion, in words.
fn against(outcome: &Result<Outcome, PipelineError>) -> Vec<String> {
    let estimate = match outcome {
        Ok(outcome) => &outcome.estimate,
        Err(_) => return vec!["refused".to_owned()],
    };
    if estimate.verdict == Verdict::Failed {
        return vec![estimate.reason.end.as_str().to_owned()];
    }
    let grave = estimate.doubts.iter().map(|doubt| doubt.about);
    let grave = grave.filter(|about| about.best() != Verdict::Physical);
    let mut all: Vec<String> = grave.map(|about| about.as_str().to_owned()).collect();
    if estimate.verdict != Verdict::Physical && all.is_empty() {
        all.push(estimate.reason.end.as_str().to_owned());
    }
    if estimate.fits() == Fits::No {
        all.push("does not fit".to_owned());
    }
    if !estimate.suspects.is_empty() {
        all.push("suspects".to_owned());
    }
    all.sort();
    all.dedup();
    all
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let header = [
        "stamps",
        "hand",
        "end",
        "marks",
        "performances",
        "nothing against",
        "and near the truth",
        "silent",
        "time, ms",
        "longest, s",
        "against the others",
    ];
    let mut table = Table::new("scenes", "", &header);
    let mut all = Vec::new();
    for (stamps, is_timing_known) in [("physical", true), ("tempo", false)] {
        for (hand, most) in [("up to a fifth", Some(SMALL)), ("any", None)] {
            for (end, asked) in [
                ("free", Asked::Nothing),
                ("position", Asked::Position),
                ("pose", Asked::Pose),
            ] {
                let row = format!("{stamps}, {hand}, {end}");
                if !options.wants(&row) {
                    continue;
                }
                let seeds = options.seeds(SEEDS).into_par_iter();
                let answers = seeds.filter_map(|seed| {
                    let scene = DrawnScene::new(seed, is_timing_known)?;
                    let scene = match most {
                        Some(share) => scene.with_hand_up_to(share),
                        None => scene,
                    };
                    Some(Answered::of(&scene, asked, seed))
                });
                let answers: Vec<Answered> = answers.collect();
                for (marks, is_rough) in [("good", false), ("as made", true)] {
                    let of_marks = answers.iter().filter(|of| of.has_rough_marks == is_rough);
                    let cells = cells(&of_marks.collect::<Vec<_>>());
                    let names = [stamps, hand, end, marks].map(str::to_owned);
                    table.row(names.into_iter().chain(cells));
                }
                eprintln!("  {row}");
                all.push((row, answers));
            }
        }
    }
    let answers = || all.iter().flat_map(|(_, answers)| answers);
    let silent = answers().filter(|of| of.is_silent()).count();
    let good = answers().filter(|of| of.is_good()).count();
    record.say(format!(
        "Of {} right performances nothing speaks against {good}; of these {silent} have an event whose time is more than four \
         deviations off.",
        answers().count(),
    ));
    record.table(table);
    record.numbers("scenes", &all)
}

fn cells(answers: &[&Answered]) -> [String; 7] {
    let seconds: Vec<f64> = answers.iter().map(|of| of.seconds).collect();
    let mut causes: BTreeMap<&str, usize> = BTreeMap::new();
    for cause in answers.iter().flat_map(|of| &of.against) {
        *causes.entry(cause).or_default() += 1;
    }
    let mut causes: Vec<(&str, usize)> = causes.into_iter().collect();
    causes.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let shown = causes.iter().take(SHOWN);
    let shown: Vec<String> = shown
        .map(|(cause, count)| format!("{cause} {count}"))
        .collect();
    [
        answers.len().to_string(),
        share(answers, |of| of.is_good()),
        share(answers, |of| of.is_good() && !of.is_silent()),
        answers
            .iter()
            .filter(|of| of.is_silent())
            .count()
            .to_string(),
        number(1e3 * median(&seconds)),
        number(largest(&seconds)),
        shown.join(", "),
    ]
}
