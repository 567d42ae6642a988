//! General solvers, side by side with this program on the very same problems.
//!
//! Problems go out as JSON ([`export`]), `tools/peers/solve.py` shows that its formulas agree,
//! solves them, and answers as JSON. Where `tools/peers/install.sh` has not been run there are no
//! peers, and that is said.

mod account;
mod figures;
mod front;
mod scenes;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};

use crate::options::Options;
use crate::record::Record;
use crate::table::Table;
use account::Account;
use enact_tools::export;
use enact_tools::starts::is_best;
use scenes::Given;

/// Violation up to which a motion counts \[units\].
pub const FEASIBLE: f64 = 1e-6;

/// How the peers are run.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Solves of each problem; the least and the greatest time are kept.
    pub repeats: usize,
    /// Longest time of a solve; what takes longer has failed \[s\].
    pub limit_s: f64,
    /// At which violation of constraints they may end \[units\]; each has a tolerance of optimality
    /// that goes with it.
    pub tolerance: f64,
    /// Name of the point from which they start.
    pub from: &'static str,
    /// Which of [`PEERS`].
    pub peers: &'static [&'static str],
}

/// All of them, as `solvers.py` calls them.
pub const PEERS: &[&str] = &[
    "CasADi, IPOPT",
    "CasADi, SQP",
    "Drake, SNOPT",
    "Drake, IPOPT",
];

/// What came back.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Report {
    /// Versions of everything.
    pub versions: serde_json::Value,
    /// Problem by problem.
    pub agreements: Vec<Agreement>,
    /// Peer by peer, problem by problem.
    pub answers: Vec<Answer>,
}

/// How well the peers' formulas agree with ours on one problem, over all its points.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Agreement {
    /// Index of the problem.
    pub problem: usize,
    /// Largest difference of the objective, relative.
    pub objective: f64,
    /// Largest difference of a constraint \[units\].
    pub constraint: f64,
    /// Largest difference of a derivative from a difference quotient, relative.
    pub derivative: f64,
    /// Why it is none of the peers', if it is not.
    pub refused: Option<String>,
}

/// What a peer made of a problem.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Answer {
    /// Index of the problem.
    pub problem: usize,
    /// Who.
    pub peer: String,
    /// In its own words.
    pub status: String,
    /// Least and greatest of the repeats \[s\].
    pub seconds: [f64; 2],
    /// Of the least: inside the compiled formulas \[s\].
    pub formula_seconds: f64,
    /// Of the least: in Python between solver and formulas, the latter included, where the solver
    /// calls Python \[s\].
    pub callback_seconds: Option<f64>,
    /// Sum of squares where it ended; `None` where that is no number.
    pub objective: Option<f64>,
    /// Largest violation there \[units\].
    pub violation: Option<f64>,
    /// Whether events are in order there.
    pub is_in_order: bool,
    /// Evaluations of the objective.
    pub evaluations: usize,
    /// Iterations, where it says.
    pub iterations: Option<usize>,
}

impl Answer {
    /// Whether it is a motion: constraints hold and events are in order.
    pub fn is_motion(&self) -> bool {
        self.objective.is_some() && self.is_in_order && self.violation.is_some_and(|v| v < FEASIBLE)
    }

    /// Whether the limit of time stopped it.
    pub fn is_late(&self) -> bool {
        self.status == "over the limit"
    }

    /// Whether it is the motion of that objective, or as good.
    pub fn is_success(&self, lowest: f64) -> bool {
        self.is_motion()
            && self
                .objective
                .is_some_and(|objective| is_best(objective, lowest))
    }
}

/// Where the peers are.
pub fn tools() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("peers")
}

/// Whether there are peers.
pub fn are_installed() -> bool {
    tools().join(".venv/bin/python").exists()
}

/// Gives the problems to the peers; `None` where there are none.
pub fn solve(problems: &[export::Problem], settings: &Settings) -> Result<Option<Report>> {
    if !are_installed() {
        return Ok(None);
    }
    let folder = tempfile::tempdir()?;
    for (index, problem) in problems.iter().enumerate() {
        let path = folder.path().join(format!("{index:05}.json"));
        fs::write(path, serde_json::to_string(problem)?)?;
    }
    let answers = folder.path().join("answers");
    let status = Command::new(tools().join(".venv/bin/python"))
        .arg(tools().join("solve.py"))
        .arg(folder.path())
        .arg(&answers)
        .args(["--repeats", &settings.repeats.to_string()])
        .args(["--limit", &settings.limit_s.to_string()])
        .args(["--tolerance", &settings.tolerance.to_string()])
        .args(["--from", settings.from])
        .args(["--peers", &settings.peers.join("|")])
        .status()
        .context("cannot run the peers")?;
    if !status.success() {
        bail!("the peers ended with {status}");
    }
    let text = fs::read_to_string(&answers)?;
    Ok(Some(serde_json::from_str(&text)?))
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    if !are_installed() {
        println!("peers: none installed, left out (tools/peers/install.sh installs them)");
        return Ok(());
    }
    let settings = Settings {
        repeats: options.either(2, 3),
        limit_s: options.either(0.5, 2.0),
        tolerance: 1e-8,
        from: "start",
        peers: PEERS,
    };
    let distortions = options.either(&[1.0][..], &[1.0, 2.0, 4.0]);
    let mut account = Account::default();
    for scene in scenes::all(distortions) {
        let seeds = options.seeds(scenes::SEEDS);
        let given = seeds.filter_map(|seed| scene.given(seed, settings.repeats));
        account.add(&scene, given.collect());
    }
    let problems: Vec<export::Problem> = account
        .given
        .iter()
        .map(|given| given.problem.clone())
        .collect();
    let Some(report) = solve(&problems, &settings)? else {
        return Ok(());
    };
    account.show(&report, &settings, record)?;
    front::run(&settings, options, record)?;
    control(&account.given, settings, record)
}

/// How many motions the peers find from the truth: formulas that were wrong would fail there too.
fn control(given: &[Given], settings: Settings, record: &mut Record) -> Result<()> {
    let settings = Settings {
        repeats: 1,
        from: "truth",
        ..settings
    };
    let mut few: Vec<export::Problem> = Vec::new();
    for Given { problem, .. } in given {
        let has_truth = problem
            .points
            .iter()
            .any(|point| point.name == settings.from);
        if has_truth && few.iter().all(|other| other.name != problem.name) {
            few.push(problem.clone());
        }
    }
    let Some(report) = solve(&few, &settings)? else {
        return Ok(());
    };
    let title = "From the truth, one problem of each scene that has one";
    let mut table = Table::new("control", title, &["peer", "problems", "motions found"]);
    for name in PEERS {
        let answers = report.answers.iter().filter(|answer| answer.peer == *name);
        let motions = answers.filter(|answer| answer.is_motion()).count();
        table.row([
            (*name).to_owned(),
            few.len().to_string(),
            motions.to_string(),
        ]);
    }
    record.table(table);
    Ok(())
}
