//! Where methods fail: every trouble at all seeds, and what the program says then.

use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Instant;
use std::{fs, panic};

use anyhow::Result;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::results::Options;
use crate::table::Table;
use enact_tools::stress::{Finding, Judged, Timing, Trouble, all, judged};

/// Reasons shown in a row of the table.
const SHOWN: usize = 3;

/// One trouble at all seeds.
#[derive(Clone, Default, Serialize, Deserialize)]
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
#[derive(Clone, Serialize, Deserialize)]
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

/// Runs those whose description holds `options.only`; the others stay as they were measured.
pub fn run(options: &Options) -> Result<()> {
    let path = options.results.join("stress.json");
    let known = fs::read_to_string(path)
        .ok()
        .filter(|_| options.only.is_some());
    let known = known.and_then(|text| serde_json::from_str::<Vec<Row>>(&text).ok());
    let mut known = known.unwrap_or_default();
    let all = all();
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    for trouble in all.iter().filter(|t| is_chosen(t, options)) {
        let begin = Instant::now();
        let row = row(trouble, options.range());
        let took_s = begin.elapsed().as_secs();
        eprintln!(
            "{}: {}, {} | {} | {} false | {}, {} | {} | {took_s} s",
            row.theme,
            row.name,
            row.timing,
            row.shares(),
            row.false_physical,
            row.panics,
            row.not_finite,
            row.says()
        );
        known.retain(|known| !known.is_of(trouble));
        known.push(row);
        options.write_json("stress", &in_order(&all, &known))?;
    }
    panic::set_hook(hook);
    options.show(table(&in_order(&all, &known)));
    Ok(())
}

fn in_order(all: &[Trouble], rows: &[Row]) -> Vec<Row> {
    let row_of = |trouble| rows.iter().find(|row| row.is_of(trouble)).cloned();
    all.iter().filter_map(row_of).collect()
}

fn is_chosen(trouble: &Trouble, options: &Options) -> bool {
    let (theme, name) = (trouble.theme, &trouble.name);
    let described = format!("{theme}: {name}, {}", trouble.timing.as_str());
    options.wants(&described)
}

fn row(trouble: &Trouble, seeds: Range<u64>) -> Row {
    let each: Vec<(u64, Result<Judged, String>)> = seeds
        .into_par_iter()
        .map(|seed| (seed, (trouble.make)(seed).map(|case| judged(&case, seed))))
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
    fn is_of(&self, trouble: &Trouble) -> bool {
        (self.theme.as_str(), &self.name) == (trouble.theme, &trouble.name)
            && self.timing == trouble.timing.as_str()
    }

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
