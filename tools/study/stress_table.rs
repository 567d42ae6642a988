//! Where methods fail: every trouble at all seeds, and what the program says then.

use std::collections::BTreeMap;
use std::panic;

use anyhow::Result;
use rayon::prelude::*;
use serde::Serialize;

use crate::results::Options;
use crate::stress::{Finding, Judged, Timing, Trouble, all, judged};
use crate::table::{Table, percent};

/// Reasons shown in a row of the table.
const SHOWN: usize = 3;

/// One trouble at all seeds.
#[derive(Serialize)]
struct Row {
    theme: &'static str,
    name: String,
    timing: &'static str,
    performances: usize,
    best: usize,
    physical: usize,
    /// Physical by its gaps, with a named contact point inside its surface at some other time.
    dips: usize,
    /// Physical by its own account only.
    false_physical: usize,
    panics: usize,
    not_finite: usize,
    undetermined: usize,
    /// What it says and how often.
    said: BTreeMap<String, usize>,
    /// The first seed of each.
    first_seeds: BTreeMap<String, u64>,
    /// Seeds of the physical ones that are not the best known optimum, with the ratio.
    above_best: Vec<(u64, f64)>,
    #[serde(skip)]
    lines: Vec<String>,
}

/// Runs those whose description holds `options.only`.
pub fn run(options: &Options) -> Result<()> {
    let all = all();
    let chosen: Vec<&Trouble> = all.iter().filter(|t| is_chosen(t, options)).collect();
    panic::set_hook(Box::new(|_| {}));
    let mut rows = Vec::new();
    for trouble in &chosen {
        let begin = std::time::Instant::now();
        let row = row(trouble, options.seeds);
        let took_s = begin.elapsed().as_secs();
        eprintln!("{} | {took_s} s", row.cells().join(" | "));
        rows.push(row);
        if options.only.is_none() {
            write(options, &rows)?;
        }
    }
    let _ = panic::take_hook();
    let mut table = Table::new("Where methods fail", &HEADER);
    for row in &rows {
        table.row(row.cells());
    }
    println!("{table}");
    Ok(())
}

/// All that was measured so far; of single seeds those where something was amiss.
fn write(options: &Options, rows: &[Row]) -> Result<()> {
    options.write_json("stress", &rows)?;
    let header = "theme,name,timing,seed,best,objective,lowest,lowest_start,iterations,off_m,\
                  finding,said,reason";
    let lines: Vec<String> = rows.iter().flat_map(|row| row.lines.clone()).collect();
    options.write_csv("stress", header, &lines)
}

fn is_chosen(trouble: &Trouble, options: &Options) -> bool {
    let described = format!(
        "{}: {}, {}",
        trouble.theme,
        trouble.name,
        trouble.timing.word()
    );
    let only = options.only.as_ref();
    only.is_none_or(|only| described.contains(only.as_str()))
}

fn row(trouble: &Trouble, seeds: u64) -> Row {
    let each: Vec<(u64, Result<Judged, String>)> = (0..seeds)
        .into_par_iter()
        .map(|seed| (seed, (trouble.make)(seed).map(|case| judged(&case, seed))))
        .collect();
    let mut row = Row {
        theme: trouble.theme,
        name: trouble.name.clone(),
        timing: match trouble.timing {
            Timing::Known => "known",
            Timing::Unknown => "unknown",
        },
        performances: 0,
        best: 0,
        physical: 0,
        dips: 0,
        false_physical: 0,
        panics: 0,
        not_finite: 0,
        undetermined: 0,
        said: BTreeMap::new(),
        first_seeds: BTreeMap::new(),
        above_best: Vec::new(),
        lines: Vec::new(),
    };
    for (seed, judged) in each {
        match judged {
            Ok(judged) => row.add(seed, &judged),
            Err(error) => row.lines.push(format!(
                "{},{},{},{seed},,,,,,,,{},",
                row.theme,
                quoted(&row.name),
                row.timing,
                quoted(&format!("no such motion: {error}"))
            )),
        }
    }
    row
}

/// A field of a CSV.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "'"))
}

const HEADER: [&str; 9] = [
    "case",
    "timing",
    "n",
    "best",
    "physical",
    "of these through a surface",
    "false physical",
    "panics, not finite",
    "otherwise says (first seed)",
];

impl Row {
    fn add(&mut self, seed: u64, judged: &Judged) {
        let is_physical = judged.said == "physical";
        self.performances += 1;
        self.best += usize::from(judged.is_best);
        self.physical += usize::from(is_physical);
        self.panics += usize::from(judged.said.starts_with("panic"));
        self.not_finite += usize::from(judged.has_nan);
        self.undetermined += usize::from(judged.undetermined > 0);
        let finding = match &judged.finding {
            None | Some(Finding::Agrees) => String::new(),
            Some(Finding::Dips) => {
                self.dips += 1;
                "through a surface".to_owned()
            }
            Some(Finding::Disagrees(what)) => {
                self.false_physical += 1;
                what.clone()
            }
        };
        *self.said.entry(judged.said.clone()).or_default() += 1;
        self.first_seeds.entry(judged.said.clone()).or_insert(seed);
        let (lowest, start) = judged.lowest.clone().unwrap_or((f64::NAN, String::new()));
        if is_physical && !judged.is_best {
            self.above_best.push((seed, judged.objective / lowest));
        }
        if judged.is_best && finding.is_empty() && !judged.has_nan {
            return;
        }
        self.lines.push(format!(
            "{},{},{},{seed},{},{:.6e},{lowest:.6e},{},{},{:.3e},{},{},{}",
            self.theme,
            quoted(&self.name),
            self.timing,
            judged.is_best,
            judged.objective,
            quoted(&start),
            judged.iterations,
            judged.off_m,
            quoted(&finding),
            quoted(&judged.said),
            quoted(&judged.reason),
        ));
    }

    fn cells(&self) -> [String; 9] {
        let mut others: Vec<(&String, &usize)> = self.said.iter().collect();
        others.retain(|(said, _)| *said != "physical");
        others.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
        let more: usize = others.iter().skip(SHOWN).map(|(_, count)| **count).sum();
        let shown = others.iter().take(SHOWN);
        let mut said: Vec<String> = shown
            .map(|(said, count)| format!("{count} {said} ({})", self.first_seeds[*said]))
            .collect();
        if more > 0 {
            said.push(format!("{more} more"));
        }
        [
            format!("{}: {}", self.theme, self.name),
            self.timing.to_owned(),
            self.performances.to_string(),
            percent(self.best, self.performances),
            percent(self.physical, self.performances),
            self.dips.to_string(),
            self.false_physical.to_string(),
            format!("{}, {}", self.panics, self.not_finite),
            said.join("; "),
        ]
    }
}
