//! Accelerations of trees, their derivatives, energies and flights beside Pinocchio's and MuJoCo's.
//!
//! Mechanisms and states go out as JSON ([`draw`]), `tools/peers/mechanisms.py` builds them anew and
//! answers with raw numbers, which are compared here ([`judge`]).

mod draw;
mod judge;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};

use crate::options::Options;
use crate::record::Record;
use crate::statistics::{largest, median};
use crate::table::{Table, number, share};
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
    show(&judged, record);
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

fn greatest<'a>(all: impl Iterator<Item = &'a Judged>, of: impl Fn(&Judged) -> f64) -> f64 {
    all.map(of).fold(0.0, f64::max)
}

fn show(judged: &[Judged], record: &mut Record) {
    let header = [
        "mechanisms",
        "number",
        "condition of M, up to",
        "u̇: Pinocchio",
        "MuJoCo",
        "∂u̇/∂q: Pinocchio",
        "its articulated",
        "MuJoCo's differences",
        "∂u̇/∂u: Pinocchio",
        "its articulated",
        "MuJoCo's differences",
        "energy",
    ];
    let mut agree = Table::new("agree", "", &header);
    for (name, is_of) in groups() {
        let own = || judged.iter().filter(|one| is_of(one));
        let mut cells = vec![
            name,
            own().count().to_string(),
            format!("{:.0e}", greatest(own(), |one| one.condition)),
        ];
        let mut add = |part: fn(&Apart) -> f64, peer: usize| {
            cells.push(format!(
                "{:.0e}",
                greatest(own(), |one| part(&one.apart[peer]))
            ));
        };
        for peer in [PINOCCHIO, MUJOCO] {
            add(|apart| apart.accelerations, peer);
        }
        for peer in [PINOCCHIO, ARTICULATED, MUJOCO] {
            add(|apart| apart.by_coordinates, peer);
        }
        for peer in [PINOCCHIO, ARTICULATED, MUJOCO] {
            add(|apart| apart.by_rates, peer);
        }
        let energy = |one: &Judged| one.apart[PINOCCHIO].energy.max(one.apart[MUJOCO].energy);
        cells.push(format!("{:.0e}", greatest(own(), energy)));
        agree.row(cells);
    }
    let worst = |of: fn(&Apart) -> f64, peer: usize| {
        let all = judged.iter();
        format!("{:.0e}", greatest(all, |one| of(&one.apart[peer])))
    };
    record.say(format!(
        "In {} random trees of 2 to 8 links, 1 mm to 10 m, accelerations are within {} of Pinocchio's and {} of MuJoCo's, \
         their derivatives by coordinates within {} and by rates within {} of Pinocchio's analytic ones, relative to the greatest.",
        judged.len(),
        worst(|apart| apart.accelerations, PINOCCHIO),
        worst(|apart| apart.accelerations, MUJOCO),
        worst(|apart| apart.by_coordinates, PINOCCHIO),
        worst(|apart| apart.by_rates, PINOCCHIO),
    ));
    record.table(agree);
    record.table(flights(judged));
}

fn flights(judged: &[Judged]) -> Table {
    let header = [
        "flights",
        "number",
        "a rounding of the start: median",
        "greatest",
        "half the steps: median",
        "Pinocchio: median",
        "MuJoCo: median",
        "half the steps over the rounding: median",
        "Pinocchio over it: median",
        "MuJoCo over it: median",
        "Pinocchio within 1e-8",
        "MuJoCo within 1e-8",
    ];
    let mut table = Table::new("flights", "", &header);
    for (name, is_of) in groups() {
        let is_flown = |one: &&Judged| is_of(one) && one.flight_s.is_some();
        let own: Vec<&Judged> = judged.iter().filter(is_flown).collect();
        let all = |of: &dyn Fn(&Judged) -> Option<f64>| -> Vec<f64> {
            own.iter().map(|one| of(one).unwrap_or(f64::NAN)).collect()
        };
        let rounding = all(&|one| one.end_by_rounding);
        let ends = [
            all(&|one| one.end_in_half),
            all(&|one| one.apart[PINOCCHIO].end),
            all(&|one| one.apart[MUJOCO].end),
        ];
        let mut cells = vec![
            name,
            own.len().to_string(),
            format!("{:.0e}", median(&rounding)),
            format!("{:.0e}", largest(&rounding)),
        ];
        cells.extend(ends.iter().map(|ends| format!("{:.0e}", median(ends))));
        for ends in &ends {
            let over: Vec<f64> = ends.iter().zip(&rounding).map(|(a, b)| a / b).collect();
            cells.push(number(median(&over)));
        }
        cells.extend(ends[1..].iter().map(|ends| share(ends, |end| *end < 1e-8)));
        table.row(cells);
    }
    table
}

type Group = (String, Box<dyn Fn(&Judged) -> bool>);

/// All, then by base and joints, by number of links, by size.
fn groups() -> Vec<Group> {
    let mut groups: Vec<Group> = vec![("all".to_owned(), Box::new(|_| true))];
    for is_free in [false, true] {
        for joints in JOINTS {
            let joints = format!("{joints:?}").to_lowercase();
            let base = if is_free { "free" } else { "clamped" };
            let name = format!("{base}, {joints}");
            groups.push((
                name,
                Box::new(move |one| one.is_free == is_free && one.joints == joints),
            ));
        }
    }
    for links in LINKS {
        groups.push((
            format!("{links} links"),
            Box::new(move |one| one.links == links),
        ));
    }
    for size_m in SIZES_M {
        groups.push((
            format!("links of {size_m} m"),
            Box::new(move |one| one.size_m == size_m),
        ));
    }
    groups
}
