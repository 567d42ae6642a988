//! One answer from many takes, by the program and by MuJoCo's system identification, on the same takes of known truth.
//!
//! `tools/peers/several.py` makes the takes and asks both; an answer of MuJoCo takes a minute and more, so that answers are kept in a
//! file as they come, and a run that ended goes on from there.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use serde::{Deserialize, Serialize};

use crate::options::Options;
use crate::record::Record;
use crate::statistics::median;
use crate::table::{Table, number, percent};

/// Seed of the first answer, and how many there are; nothing was chosen on these.
const FIRST_SEED: u64 = 15_000;
const SEEDS: u64 = 5;
/// Takes of an answer.
const TAKES: usize = 10;
/// Takes of an answer that only shows that everything runs.
const QUICK_TAKES: usize = 2;

/// What the file has.
#[derive(Deserialize, Serialize)]
struct Report {
    /// Of packages, and the revision of the project.
    versions: BTreeMap<String, String>,
    answers: Vec<Answer>,
}

/// What one way makes of the takes of one seed.
#[derive(Deserialize, Serialize)]
struct Answer {
    way: String,
    seed: u64,
    takes: usize,
    /// Why there is none.
    why_none: Option<String>,
    /// Of what is asked.
    numbers: BTreeMap<String, Found>,
    wall_s: f64,
    core_s: f64,
}

/// One quantity of an answer, component by component.
#[derive(Deserialize, Serialize)]
struct Found {
    /// How far each is from the truth, SI.
    off: Vec<f64>,
    /// Whether the interval of each holds the truth, where there are intervals.
    is_held: Option<Vec<bool>>,
}

fn tools() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("peers")
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let python = tools().join(".venv_several/bin/python");
    let has_all = Command::new(&python)
        .args(["-c", "import enact_motion, mujoco.sysid, scipy"])
        .output();
    if !has_all.is_ok_and(|output| output.status.success()) {
        println!("fit_peers: no {}, left out", python.display());
        return Ok(());
    }
    let takes = options.either(QUICK_TAKES, TAKES);
    let seeds = options.either(1, SEEDS);
    let file = tools().join(options.either(".several_quick.json", ".several.json"));
    let status = Command::new(&python)
        .arg(tools().join("several.py"))
        .arg(&file)
        .args(["--first", &FIRST_SEED.to_string()])
        .args(["--seeds", &seeds.to_string()])
        .args(["--takes", &takes.to_string()])
        .status()
        .context("cannot run several.py")?;
    if !status.success() {
        bail!("several.py ended with {status}");
    }
    let mut report: Report = serde_json::from_str(&fs::read_to_string(&file)?)?;
    let is_asked =
        |of: &Answer| (FIRST_SEED..FIRST_SEED + seeds).contains(&of.seed) && of.takes == takes;
    report.answers.retain(is_asked);
    ensure!(!report.answers.is_empty(), "{}: no answers", file.display());
    let mut ways: Vec<&str> = Vec::new();
    for answer in &report.answers {
        if !ways.contains(&answer.way.as_str()) {
            ways.push(&answer.way);
        }
    }
    let header = [
        "",
        "answers",
        "none",
        "restitution off: median",
        "friction",
        "gravity, m/s²",
        "tracker, mm",
        "in 95 % intervals",
        "time of a core for a take, s",
    ];
    let mut table = Table::new("fit_peers", "", &header);
    for way in ways {
        let answers = report.answers.iter().filter(|of| of.way == way);
        table.row(cells(way, &answers.collect::<Vec<_>>()));
    }
    record.table(table);
    let mut made = Table::new("made", "", &["made with", ""]);
    for (name, version) in &report.versions {
        made.row([name.clone(), version.clone()]);
    }
    let last = FIRST_SEED + seeds - 1;
    made.row(["seeds".to_owned(), format!("{FIRST_SEED} to {last}")]);
    made.row(["takes of a seed".to_owned(), takes.to_string()]);
    record.table(made);
    record.numbers("fit_peers", &report)
}

fn cells(way: &str, answers: &[&Answer]) -> Vec<String> {
    let off = |name: &str, factor: f64| {
        let found = answers.iter().filter_map(|of| of.numbers.get(name));
        let off = found.flat_map(|of| of.off.iter().map(|off| off * factor));
        number(median(&off.collect::<Vec<_>>()))
    };
    let numbers = answers.iter().flat_map(|of| of.numbers.values());
    let held = numbers.filter_map(|of| of.is_held.as_ref()).flatten();
    let held: Vec<bool> = held.copied().collect();
    let holding = held.iter().filter(|held| **held).count();
    let none = answers.iter().filter(|of| of.numbers.is_empty()).count();
    let core_s: Vec<f64> = answers
        .iter()
        .map(|of| of.core_s / of.takes as f64)
        .collect();
    vec![
        way.to_owned(),
        answers.len().to_string(),
        none.to_string(),
        off("restitution", 1.0),
        off("friction", 1.0),
        off("gravity", 1.0),
        off("tracker", 1e3),
        format!("{} of {}", percent(holding, held.len()), held.len()),
        number(median(&core_s)),
    ]
}
