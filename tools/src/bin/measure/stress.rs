//! Where methods fail: every trouble at all seeds, and what the program says then.

use std::collections::BTreeMap;
use std::ops::Range;
use std::panic;

use anyhow::Result;
use rayon::prelude::*;
use serde::Serialize;

use crate::options::Options;
use crate::record::Record;
use crate::table::{Table, percent};
use enact_tools::stress::{Finding, Judged, Timing, Trouble, all, judged};

/// Performances of a row.
const SEEDS: u64 = 8;
/// Reasons shown in a row of the table.
const SHOWN: usize = 3;

/// One trouble at all seeds.
#[derive(Clone, Default, Serialize)]
struct Row {
    theme: String,
    name: String,
    timing: String,
    performances: usize,
    best: usize,
    physical: usize,
    /// Physical by its gaps, with a named contact point inside its surface at some other time.
    through_a_surface: usize,
    /// Physical by its gaps, with a collision that has no impact.
    without_an_impact: usize,
    /// Physical by its own account only.
    false_physical: usize,
    /// Of these three, those whose verdict the program's checks take back.
    caught: usize,
    panics: usize,
    not_finite: usize,
    /// Something is reported as undetermined.
    undetermined: usize,
    /// Median over seeds of the largest distance of an arc's middle from the truth \[m\].
    off_m: Option<f64>,
    /// What it says, how often, and at which seed first.
    said: BTreeMap<String, (usize, u64)>,
    /// Seeds with an estimate that is not the best known, or not what it says.
    amiss: Vec<Amiss>,
}

/// A performance whose estimate is not as one would wish.
#[derive(Clone, Serialize)]
struct Amiss {
    seed: u64,
    said: String,
    objective: Option<f64>,
    lowest: Option<f64>,
    lowest_start: Option<String>,
    finding: Option<String>,
    iterations: usize,
    off_m: Option<f64>,
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let mut rows: Vec<Row> = Vec::new();
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    for trouble in all() {
        let (theme, name) = (trouble.theme, &trouble.name);
        if !options.wants(&format!("{theme}: {name}, {}", trouble.timing.as_str())) {
            continue;
        }
        let row = row(&trouble, options.seeds(SEEDS));
        eprintln!(
            "  {theme}: {name}, {} | {} | {} false | {}, {} | {}",
            row.timing,
            row.shares(),
            row.false_physical,
            row.panics,
            row.not_finite,
            row.says()
        );
        rows.push(row);
    }
    panic::set_hook(hook);
    record.table(table(&rows));
    let sum = |value: fn(&Row) -> usize| rows.iter().map(value).sum::<usize>();
    record.say(format!(
        "Of {} performances that are hard or wrong, {} end at the best optimum known; {} are called physical and are \
         not, {} panic.",
        sum(|row| row.performances),
        percent(sum(|row| row.best), sum(|row| row.performances)),
        sum(|row| row.false_physical),
        sum(|row| row.panics),
    ));
    record.numbers("rows", &rows)
}

fn row(trouble: &Trouble, seeds: Range<u64>) -> Row {
    let each: Vec<(u64, Result<Judged, String>)> = seeds
        .into_par_iter()
        .map(|seed| {
            (
                seed,
                (trouble.make)(seed).map(|case| judged(&case.one_by_one(), seed)),
            )
        })
        .collect();
    let mut row = Row {
        theme: trouble.theme.to_owned(),
        name: trouble.name.clone(),
        timing: trouble.timing.as_str().to_owned(),
        ..Row::default()
    };
    let mut off_m = Vec::new();
    for (seed, judged) in &each {
        // A seed without a motion is no performance.
        if let Ok(judged) = judged {
            row.add(*seed, judged);
            off_m.push(judged.off_m);
        }
    }
    off_m.retain(|off_m| off_m.is_finite());
    row.off_m = finite(crate::statistics::median(&off_m));
    row
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// One row per case, both timings side by side.
fn table(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "troubles",
        "Where methods fail (of physical ones: s through a surface, i without an impact; c of them caught by the checks)",
        &[
            "case",
            "n",
            "known: best, physical %",
            "unknown: best, physical %",
            "false physical, panics, not finite",
            "otherwise says, known",
            "otherwise says, unknown",
        ],
    );
    let mut cases: Vec<(&str, &str)> = Vec::new();
    for row in rows {
        let case = (row.theme.as_str(), row.name.as_str());
        if !cases.contains(&case) {
            cases.push(case);
        }
    }
    for (theme, name) in cases {
        let of = |timing: Timing| {
            let mut rows = rows.iter();
            rows.find(|r| r.theme == theme && r.name == name && r.timing == timing.as_str())
        };
        let both = [of(Timing::Known), of(Timing::Unknown)];
        let some = || both.iter().flatten();
        let sum = |value: fn(&Row) -> usize| some().map(|row| value(row)).sum::<usize>();
        let says = |row: &Option<&Row>| row.map_or_else(String::new, Row::says);
        let shares = |row: &Option<&Row>| row.map_or_else(String::new, Row::shares);
        table.row([
            format!("{theme}: {name}"),
            some()
                .map(|row| row.performances)
                .max()
                .unwrap_or(0)
                .to_string(),
            shares(&both[0]),
            shares(&both[1]),
            format!(
                "{}, {}, {}",
                sum(|row| row.false_physical),
                sum(|row| row.panics),
                sum(|row| row.not_finite)
            ),
            says(&both[0]),
            says(&both[1]),
        ]);
    }
    table
}

impl Row {
    fn add(&mut self, seed: u64, judged: &Judged) {
        self.performances += 1;
        self.best += usize::from(judged.is_best);
        self.physical += usize::from(judged.said == "physical");
        self.panics += usize::from(judged.said.starts_with("panic"));
        self.not_finite += usize::from(judged.has_nan);
        self.undetermined += usize::from(judged.undetermined > 0);
        self.caught += usize::from(judged.is_caught);
        let finding = match &judged.finding {
            None | Some(Finding::Agrees) => None,
            Some(Finding::Dips) => {
                self.through_a_surface += 1;
                Some("through a surface".to_owned())
            }
            Some(Finding::Grazes) => {
                self.without_an_impact += 1;
                Some("without an impact".to_owned())
            }
            Some(Finding::Disagrees(what)) => {
                self.false_physical += 1;
                Some(what.clone())
            }
        };
        let said = self.said.entry(judged.said.clone()).or_insert((0, seed));
        said.0 += 1;
        let is_amiss = !judged.is_best || finding.is_some() || judged.has_nan;
        if is_amiss && !judged.said.starts_with("refused") {
            let (lowest, start) = judged.lowest.clone().unzip();
            self.amiss.push(Amiss {
                seed,
                said: judged.said.clone(),
                objective: finite(judged.objective),
                lowest,
                lowest_start: start,
                finding,
                iterations: judged.iterations,
                off_m: finite(judged.off_m),
            });
        }
    }

    /// Best and physical in per cent, and what is amiss with the physical ones.
    fn shares(&self) -> String {
        let share = |count: usize| 100 * count / self.performances.max(1);
        let mut text = format!("{}, {}", share(self.best), share(self.physical));
        for (count, mark) in [
            (self.through_a_surface, "s"),
            (self.without_an_impact, "i"),
            (self.caught, "c"),
        ] {
            if count > 0 {
                text += &format!(" ({count} {mark})");
            }
        }
        text
    }

    /// What it says where it does not say `physical`: the commonest first, with the first seed.
    fn says(&self) -> String {
        let mut others: Vec<_> = self.said.iter().collect();
        others.retain(|(said, _)| *said != "physical");
        others.sort_by_key(|(_, (count, _))| std::cmp::Reverse(*count));
        let more: usize = others.iter().skip(SHOWN).map(|(_, (count, _))| count).sum();
        let shown = others.iter().take(SHOWN);
        let mut said: Vec<String> = shown
            .map(|(said, (count, seed))| format!("{count} {said} ({seed})"))
            .collect();
        if more > 0 {
            said.push(format!("{more} more"));
        }
        said.join("; ")
    }
}
