//! Accelerations of trees, their derivatives, energies and flights beside Pinocchio's and MuJoCo's.
//!
//! Mechanisms and states go out as JSON ([`draw`]), `tools/peers/mechanisms.py` builds them anew and
//! answers with raw numbers, which are compared here ([`judge`]).

mod draw;
mod judge;
mod show;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};

use crate::options::Options;
use crate::record::Record;
use draw::{JOINTS, Mechanism, Row};
use judge::{Answer, Apart, Ours};

/// Mechanisms of each kind; those of the first seed fly.
const SEEDS: u64 = 5;
const LINKS: [usize; 4] = [2, 3, 5, 8];
const SIZES_M: [f64; 4] = [0.001, 0.03, 0.2, 10.0];
/// In the order of the answers.
const PEERS: [&str; 3] = ["Pinocchio", "Pinocchio, articulated", "MuJoCo"];
const PINOCCHIO: usize = 0;
const ARTICULATED: usize = 1;
const MUJOCO: usize = 2;

#[derive(Deserialize)]
struct Report {
    versions: serde_json::Value,
    answers: Vec<Vec<Answer>>,
}

/// What is kept of a mechanism.
#[derive(Serialize)]
struct Judged {
    seed: u64,
    is_free: bool,
    joints: String,
    links: usize,
    size_m: f64,
    condition: f64,
    flight_s: Option<f64>,
    end_in_half: Option<f64>,
    end_by_rounding: Option<f64>,
    /// As [`PEERS`].
    apart: Vec<Apart>,
}

fn tools() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("peers")
}

fn are_installed() -> bool {
    let python = Command::new(tools().join(".venv/bin/python"))
        .args(["-c", "import mujoco, pinocchio, scipy"])
        .output();
    python.is_ok_and(|output| output.status.success())
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    if !are_installed() {
        println!("mechanisms: no peers installed, left out (tools/peers/install.sh installs them)");
        return Ok(());
    }
    let drawn = drawn(options);
    let report = asked(&drawn)?;
    let mut judged = Vec::new();
    for ((seed, mechanism), answers) in drawn.iter().zip(&report.answers) {
        let names: Vec<&str> = answers.iter().map(|answer| answer.peer.as_str()).collect();
        if names != PEERS {
            bail!("the peers are {names:?}");
        }
        let ours = Ours::of(mechanism);
        let row = mechanism.row;
        judged.push(Judged {
            seed: *seed,
            is_free: row.is_free,
            joints: format!("{:?}", row.joints).to_lowercase(),
            links: row.links,
            size_m: row.size_m,
            condition: ours.condition,
            flight_s: mechanism.flight_s,
            end_in_half: ours.end_in_half,
            end_by_rounding: ours.end_by_rounding,
            apart: answers.iter().map(|answer| ours.apart(answer)).collect(),
        });
    }
    show::show(&judged, record);
    record.numbers("versions", &report.versions)?;
    record.numbers("mechanisms", &judged)
}

fn drawn(options: &Options) -> Vec<(u64, Mechanism)> {
    let mut rows = Vec::new();
    for is_free in [false, true] {
        for joints in JOINTS {
            for links in LINKS {
                rows.extend(SIZES_M.map(|size_m| Row {
                    is_free,
                    joints,
                    links,
                    size_m,
                }));
            }
        }
    }
    let seeds = options.seeds(SEEDS);
    let first = seeds.start;
    let of = |seed: u64| {
        let numbered = rows.iter().zip(0..);
        numbered.map(move |(row, number)| {
            let mechanism = Mechanism::draw(*row, seed, number);
            match seed == first {
                true => (seed, mechanism.flying()),
                false => (seed, mechanism),
            }
        })
    };
    seeds.flat_map(of).collect()
}

/// Gives the mechanisms to the peers.
fn asked(drawn: &[(u64, Mechanism)]) -> Result<Report> {
    let folder = tempfile::tempdir()?;
    for (index, (_, mechanism)) in drawn.iter().enumerate() {
        let path = folder.path().join(format!("{index:05}.json"));
        fs::write(path, mechanism.file().to_string())?;
    }
    let answers = folder.path().join("answers");
    let status = Command::new(tools().join(".venv/bin/python"))
        .arg(tools().join("mechanisms.py"))
        .arg(folder.path())
        .arg(&answers)
        .status()
        .context("cannot run the peers")?;
    if !status.success() {
        bail!("the peers ended with {status}");
    }
    let report: Report = serde_json::from_str(&fs::read_to_string(&answers)?)?;
    if report.answers.len() != drawn.len() {
        bail!(
            "{} answers to {} mechanisms",
            report.answers.len(),
            drawn.len()
        );
    }
    Ok(report)
}
