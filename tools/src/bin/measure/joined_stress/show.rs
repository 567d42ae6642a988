//! Tables of what came of hard performances of joined bodies.

use std::collections::BTreeMap;

use super::{Answered, Ended, LIMIT_S};
use crate::record::Record;
use crate::statistics::{largest, median};
use crate::table::{Table, number, percent, share};

/// Names shown in a cell.
const SHOWN: usize = 4;

/// What is wrong with an answer itself, in words.
fn amiss(answer: &Answered) -> Option<String> {
    match answer {
        Answered {
            ended: Ended::Panicked,
            reason,
            ..
        } => Some(reason.clone()),
        Answered { has_nan: true, .. } => Some("not finite".to_owned()),
        _ => answer.finding.clone(),
    }
}

/// A line while it runs.
pub fn in_short(answers: &[Answered]) -> String {
    let count = |ended: Ended| answers.iter().filter(|of| of.ended == ended).count();
    let seconds: Vec<f64> = answers.iter().map(|of| of.seconds).collect();
    format!(
        "{} of {} physical, {} doubted, {} failed, {} stopped, {} amiss; longest {:.1} s",
        count(Ended::Physical),
        answers.len(),
        count(Ended::Doubted),
        count(Ended::Failed),
        count(Ended::Stopped),
        answers.iter().filter(|of| amiss(of).is_some()).count(),
        largest(&seconds),
    )
}

/// Tables and sentences.
pub fn show(rows: &[(String, Vec<Answered>)], record: &mut Record) {
    let all = || rows.iter().flat_map(|(_, answers)| answers);
    let count = |holds: &dyn Fn(&Answered) -> bool| all().filter(|of| holds(of)).count();
    record.say(format!(
        "Of {} performances of joined bodies that are hard or impossible, {} end as physical and {} as doubted motions, {} fail, {} are stopped after \
         {} s of a core; an independent look finds something against {} of the physical ones, {} panic, {} have a number that is none.",
        all().count(),
        percent(count(&|of| of.ended == Ended::Physical), all().count()),
        percent(count(&|of| of.ended == Ended::Doubted), all().count()),
        percent(count(&|of| of.ended == Ended::Failed), all().count()),
        percent(count(&|of| of.ended == Ended::Stopped), all().count()),
        LIMIT_S,
        count(&|of| of.finding.is_some()),
        count(&|of| of.ended == Ended::Panicked),
        count(&|of| of.has_nan),
    ));
    record.table(found(rows));
    record.table(said(rows));
    record.table(wrong(rows));
}

/// How often there is a motion, and how near it is.
fn found(rows: &[(String, Vec<Answered>)]) -> Table {
    let header = [
        "case",
        "performances",
        "physical",
        "doubted",
        "failed",
        "stopped",
        "best known",
        "from the truth: motions",
        "best known",
        "rods off, mm",
        "worst, mm",
        "errors grow by",
        "evaluations",
        "time, ms",
        "longest, ms",
    ];
    let mut table = Table::new("found", "", &header);
    for (name, answers) in rows {
        let ended = |ended: Ended| share(answers, |of| of.ended == ended);
        let values = |of: &dyn Fn(&Answered) -> Option<f64>| {
            answers.iter().filter_map(of).collect::<Vec<f64>>()
        };
        let times_s = values(&|of| Some(of.seconds));
        let worst_m = values(&|of| of.off_m.map(|off| off[1]));
        let growth = median(&values(&|of| Some(of.growth)));
        table.row([
            name.clone(),
            answers.len().to_string(),
            ended(Ended::Physical),
            ended(Ended::Doubted),
            ended(Ended::Failed),
            ended(Ended::Stopped),
            share(answers, |of| of.is_best),
            share(answers, |of| {
                of.from_truth.as_ref().is_some_and(|of| of.is_motion)
            }),
            share(answers, |of| of.is_best_from_truth),
            number(1e3 * median(&values(&|of| of.off_m.map(|off| off[0])))),
            match worst_m.is_empty() {
                true => number(f64::NAN),
                false => number(1e3 * largest(&worst_m)),
            },
            match growth > GROWN {
                true => format!("more than {}", number(GROWN)),
                false => number(growth),
            },
            number(median(&values(&|of| Some(of.evaluations as f64)))),
            number(1e3 * median(&times_s)),
            number(1e3 * largest(&times_s)),
        ]);
    }
    table
}

/// Beyond this a difference quotient tells no growth of errors: both motions are anywhere.
const GROWN: f64 = 1e7;

/// What is said of it.
fn said(rows: &[(String, Vec<Answered>)]) -> Table {
    let header = [
        "case",
        "motions",
        "doubts",
        "otherwise ended",
        "not determined",
        "fits",
        "unknown",
        "does not fit",
        "not told",
        "first suspect",
        "what is wrong is it",
    ];
    let mut table = Table::new("said", "", &header);
    for (name, answers) in rows {
        let motions: Vec<&Answered> = answers.iter().filter(|of| of.objective.is_some()).collect();
        let others = answers.iter().filter(|of| of.objective.is_none());
        let fits = |word: Option<&str>| share(&motions, |of| of.fits == word);
        table.row([
            name.clone(),
            motions.len().to_string(),
            counted(motions.iter().flat_map(|of| of.doubts.iter().cloned())),
            counted(others.map(|of| of.reason.clone())),
            counted(
                motions
                    .iter()
                    .flat_map(|of| of.undetermined.iter().cloned()),
            ),
            fits(Some("yes")),
            fits(Some("unknown")),
            fits(Some("no")),
            fits(None),
            counted(motions.iter().filter_map(|of| of.suspect.clone())),
            share(&motions, |of| of.is_named),
        ]);
    }
    table
}

/// Names with how often, the commonest first.
fn counted(names: impl Iterator<Item = String>) -> String {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for name in names {
        *counts.entry(name).or_default() += 1;
    }
    let mut counts: Vec<(String, usize)> = counts.into_iter().collect();
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let more = counts.len().saturating_sub(SHOWN);
    let shown = counts.into_iter().take(SHOWN);
    let mut said: Vec<String> = shown
        .map(|(name, count)| format!("{count} {name}"))
        .collect();
    if more > 0 {
        said.push(format!("{more} other"));
    }
    match said.is_empty() {
        true => "–".to_owned(),
        false => said.join(", "),
    }
}

/// What should not have been said, each by its seed.
fn wrong(rows: &[(String, Vec<Answered>)]) -> Table {
    let mut table = Table::new("wrong", "", &["case", "seed", "what is wrong"]);
    for (name, answers) in rows {
        for answer in answers {
            if let Some(what) = amiss(answer) {
                table.row([name.clone(), answer.seed.to_string(), what]);
            }
        }
    }
    table
}
